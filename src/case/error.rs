//! What is wrong with a case, as a user reads it: located in the text of the file.

use miette::{Diagnostic, NamedSource, SourceSpan};

use super::problem::Problem;

/// What is wrong with a case, where, and what to do.
#[derive(Debug, thiserror::Error, Diagnostic)]
#[error("{message}")]
pub struct CaseError {
    message: String,
    #[help]
    help: Option<String>,
    #[source_code]
    source_code: Option<NamedSource<String>>,
    #[label("{label}")]
    span: Option<SourceSpan>,
    label: String,
    /// What else is wrong.
    #[related]
    others: Vec<Self>,
}

impl CaseError {
    /// The same with what else is wrong.
    pub(super) fn with_others(mut self: Box<Self>, others: Vec<Self>) -> Box<Self> {
        self.others = others;
        self
    }

    /// An error about a whole file.
    pub(super) fn about_file(message: String, help: &str) -> Box<Self> {
        Box::new(Self {
            message,
            help: Some(help.to_owned()),
            source_code: None,
            span: None,
            label: String::new(),
            others: Vec::new(),
        })
    }

    pub(super) fn located(
        name: &str,
        source: &str,
        span: Option<std::ops::Range<usize>>,
        label: &str,
        problem: Problem,
    ) -> Box<Self> {
        Box::new(Self {
            message: problem.message,
            help: Some(problem.help),
            source_code: Some(NamedSource::new(name, source.to_owned())),
            span: span.map(Into::into),
            label: label.to_owned(),
            others: Vec::new(),
        })
    }
}
