//! What is wrong with one key of a case.

/// A finding about one key, before it is located in the file.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Problem {
    /// Dotted path of the key.
    pub key: String,
    /// What is wrong, with the value.
    pub message: String,
    /// What is allowed and what to do.
    pub help: String,
}

impl Problem {
    /// A finding about `key`.
    pub fn new(
        key: impl Into<String>,
        message: impl Into<String>,
        help: impl Into<String>,
    ) -> Self {
        Self {
            key: key.into(),
            message: message.into(),
            help: help.into(),
        }
    }
}
