//! Sections of the input file of LEparagliding: numbered, of plain lines.

/// Most ribs of a wing: larger numbers of ribs in a file are taken for this.
pub(super) const MOST_RIBS: f64 = 1000.0;

/// Why a file cannot be read.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum ReadFault {
    /// A section is not there, or ends too early.
    #[error("section {number} ({name}) is missing, or is too short")]
    Section {
        /// Its number in the file.
        number: usize,
        /// What it holds.
        name: &'static str,
    },
    /// A length is not positive.
    #[error("{0} is not positive")]
    Length(&'static str),
    /// Ribs are not listed from the middle outwards.
    #[error(
        "rib {0} (section 1) does not lie farther out than the one before: list ribs from the middle outwards"
    )]
    Order(usize),
    /// A chord that no wing has.
    #[error(
        "the chord of rib {0} (section 1) is more than twice that of the one before: look at the leading and trailing edges of both"
    )]
    Chord(usize),
    /// A rib has no row that can be read.
    #[error(
        "rib {0} has no row in section 1 that can be read: it takes its number and at least seven more, with points in decimals"
    )]
    Rib(usize),
    /// A path of lines that the format does not have.
    #[error(
        "a path of lines has {0} levels (sections 9 and 10): 1 to 4 are possible, with the riser"
    )]
    Levels(usize),
    /// Ribs are missing, or their number is wrong.
    #[error("section 1 tells of {told} ribs, but lists {found} of a half: {} or {} are expected", 2 * found - 1, 2 * found)]
    RibCount {
        /// Of the whole wing, as the file says.
        told: usize,
        /// Rows of a half.
        found: usize,
    },
    /// Widths of panels that no panel has.
    #[error(
        "places of the skin tension (sections 5 and 31) have to grow from 0 to 100, and shares to be 25 at most"
    )]
    SkinTension,
    /// A line of a section has too few numbers.
    #[error("in section {number} ({name}) the line `{line}` cannot be read")]
    Line {
        /// Number of the section.
        number: usize,
        /// What it holds.
        name: &'static str,
        /// The line.
        line: String,
    },
}

/// Lines of the sections, by their numbers.
pub(super) struct Sections<'a>(Vec<(usize, Vec<&'a str>)>);

/// Number of the section that a line with a star begins.
fn heading(line: &str) -> Option<usize> {
    let rest = line.trim_start().trim_start_matches('*').trim_start();
    let (number, name) = rest.split_once('.')?;
    let is_name = name.trim_start().starts_with(|c: char| c.is_alphabetic());
    number.trim().parse().ok().filter(|_| is_name)
}

impl<'a> Sections<'a> {
    pub(super) fn new(text: &'a str) -> Self {
        let mut all: Vec<(usize, Vec<&str>)> = Vec::new();
        for line in text.lines() {
            let line = line.trim();
            if line.starts_with('*') {
                if let Some(number) = heading(line) {
                    all.push((number, Vec::new()));
                }
            } else if let (false, Some((_, lines))) = (line.is_empty(), all.last_mut()) {
                lines.push(line);
            }
        }
        Self(all)
    }

    pub(super) fn get(
        &self,
        number: usize,
        name: &'static str,
    ) -> Result<Section<'_, 'a>, ReadFault> {
        let found = self.0.iter().find(|(known, _)| *known == number);
        let (_, lines) = found.ok_or(ReadFault::Section { number, name })?;
        Ok(Section {
            number,
            name,
            lines: lines.iter(),
        })
    }
}

/// Lines of a section that are still to be read.
pub(super) struct Section<'s, 'a> {
    number: usize,
    name: &'static str,
    lines: std::slice::Iter<'s, &'a str>,
}

impl<'a> Section<'_, 'a> {
    pub(super) fn line(&mut self) -> Result<&'a str, ReadFault> {
        let (number, name) = (self.number, self.name);
        let line = self.lines.next().copied();
        line.ok_or(ReadFault::Section { number, name })
    }

    pub(super) fn fault(&self, line: &str) -> ReadFault {
        ReadFault::Line {
            number: self.number,
            name: self.name,
            line: line.to_owned(),
        }
    }

    /// The numbers at the beginning of the next line, of which there are some at least.
    pub(super) fn numbers(&mut self, least: usize) -> Result<Vec<f64>, ReadFault> {
        let line = self.line()?;
        let found = numbers(line);
        if found.len() < least {
            return Err(self.fault(line));
        }
        Ok(found)
    }

    pub(super) fn number(&mut self) -> Result<f64, ReadFault> {
        Ok(self.numbers(1)?[0])
    }

    pub(super) fn count(&mut self) -> Result<usize, ReadFault> {
        Ok(self.number()?.max(0.0) as usize)
    }

    /// Rows that begin with a number and have some more; what is a heading is passed over.
    pub(super) fn rows(self, least: usize) -> Vec<Vec<f64>> {
        let rows = self.lines.map(|line| numbers(line));
        rows.filter(|row| row.len() >= least).collect()
    }
}

/// Numbers at the beginning of a line.
pub(super) fn numbers(line: &str) -> Vec<f64> {
    let words = line.split_whitespace();
    let number = |word: &str| word.parse().ok().filter(|number: &f64| number.is_finite());
    words.map_while(number).collect()
}

pub(super) fn unquoted(line: &str) -> String {
    let line = line.trim();
    let inner = line
        .strip_prefix('"')
        .and_then(|rest| rest.split('"').next());
    inner.unwrap_or(line).trim().to_owned()
}
