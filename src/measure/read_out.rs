//! Read-outs as rows: every column of the history, and every result, is declared in one place.
//!
//! A row of [`columns!`] tells name, unit and meaning, how its value follows from a sample, where it exists and what becomes of its samples.
//! A row of [`results!`] declares a result that is no column. Each row has a handle: columns are looked up, and results put in, by it alone.

use crate::case::Scene;
pub use crate::output::ReadOut;

/// What becomes of the samples of a column.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Reduction {
    /// No result of its own.
    None,
    /// The mean over the window is the result of the same name.
    Mean,
    /// The largest from the release on is the result of the same name.
    Largest,
    /// The same; the mean over the window is the result of another name.
    LargestAndMean(&'static str),
    /// The smallest from the release on, and the mean under another name.
    SmallestAndMean(&'static str),
    /// The smallest of all samples is the result of the same name.
    Smallest,
    /// The largest from the release on is the result of another name.
    LargestAs(&'static str),
    /// The last sample is the result of the same name.
    Last,
}

impl Reduction {
    fn words(self) -> String {
        match self {
            Self::None => String::new(),
            Self::Mean => "mean".to_owned(),
            Self::Largest => "largest".to_owned(),
            Self::Smallest => "smallest".to_owned(),
            Self::LargestAndMean(mean) => format!("largest; mean as `{mean}`"),
            Self::SmallestAndMean(mean) => format!("smallest; mean as `{mean}`"),
            Self::LargestAs(largest) => format!("largest as `{largest}`"),
            Self::Last => "last".to_owned(),
        }
    }
}

/// Where a column exists, besides that its table does.
#[derive(Debug)]
pub(super) struct When<In> {
    /// In words.
    pub words: &'static str,
    /// Whether it does.
    pub holds: fn(&In) -> bool,
}

/// A column of the history of what is known as `Of` at a sample, in what is known as `In` of the case.
#[derive(Debug)]
pub(super) struct Column<Of, In: 'static> {
    pub read_out: &'static ReadOut,
    pub how: fn(&Of) -> f64,
    pub reduced: Reduction,
    pub when: Option<&'static When<In>>,
}

impl<Of, In: 'static> Column<Of, In> {
    /// A column that its table always has, and that has no result.
    pub const fn new(read_out: &'static ReadOut, how: fn(&Of) -> f64) -> Self {
        Self {
            read_out,
            how,
            reduced: Reduction::None,
            when: None,
        }
    }

    /// The same with a result.
    pub const fn reduced(mut self, reduced: Reduction) -> Self {
        self.reduced = reduced;
        self
    }

    /// The same where a condition holds.
    pub const fn when(mut self, when: &'static When<In>) -> Self {
        self.when = Some(when);
        self
    }
}

/// The columns of one kind of sample, in the order of the history.
#[derive(Debug)]
pub(super) struct Columns<Of: 'static, In: 'static = Scene> {
    /// Which scenes have them.
    pub title: &'static str,
    pub rows: &'static [Column<Of, In>],
}

impl<Of, In> Columns<Of, In> {
    /// Those that exist.
    pub fn of<'a>(
        &self,
        place: &'a In,
    ) -> impl Iterator<Item = &'static Column<Of, In>> + use<'a, Of, In> {
        let exists = |row: &&Column<Of, In>| row.when.is_none_or(|when| (when.holds)(place));
        self.rows.iter().filter(exists)
    }

    /// Their read-outs.
    pub fn read_outs(&self, place: &In) -> Vec<ReadOut> {
        self.of(place).map(|row| row.read_out.clone()).collect()
    }

    /// Their read-outs, of an owner.
    pub fn read_outs_of(&self, place: &In, owner: &str) -> Vec<ReadOut> {
        self.of(place).map(|row| row.read_out.of(owner)).collect()
    }

    /// Their values; without a sample they are unknown.
    pub fn values(&self, place: &In, sample: Option<&Of>) -> Vec<f64> {
        let value = |row: &Column<Of, In>| sample.map_or(f64::NAN, row.how);
        self.of(place).map(value).collect()
    }

    /// Those with that reduction.
    pub fn reduced(&self, place: &In, to: Reduction) -> impl Iterator<Item = &'static ReadOut> {
        self.of(place)
            .filter(move |row| row.reduced == to)
            .map(|row| row.read_out)
    }

    /// For the documentation.
    pub fn group(&self) -> Group {
        let row = |row: &Column<Of, In>| Row {
            read_out: row.read_out,
            when: row.when.map_or("", |when| when.words),
            reduced: row.reduced,
        };
        Group {
            title: self.title,
            are_columns: true,
            rows: self.rows.iter().map(row).collect(),
        }
    }
}

/// Results that are no columns.
#[derive(Debug)]
pub(super) struct Declared {
    /// Which scenes have them.
    pub title: &'static str,
    pub rows: &'static [&'static ReadOut],
}

impl Declared {
    /// For the documentation.
    pub fn group(&self) -> Group {
        let row = |read_out: &&'static ReadOut| Row {
            read_out,
            when: "",
            reduced: Reduction::None,
        };
        Group {
            title: self.title,
            are_columns: false,
            rows: self.rows.iter().map(row).collect(),
        }
    }
}

/// A table of the documentation.
#[derive(Debug)]
pub struct Group {
    pub(super) title: &'static str,
    pub(super) are_columns: bool,
    pub(super) rows: Vec<Row>,
}

/// One of its rows.
#[derive(Debug)]
pub(super) struct Row {
    pub read_out: &'static ReadOut,
    pub when: &'static str,
    pub reduced: Reduction,
}

impl Row {
    /// The results that come of the column.
    pub fn results(&self) -> Vec<ReadOut> {
        let own = || self.read_out.clone();
        let other = |name| self.read_out.named(name);
        match self.reduced {
            Reduction::None => Vec::new(),
            Reduction::Mean | Reduction::Largest | Reduction::Smallest | Reduction::Last => {
                vec![own()]
            }
            Reduction::LargestAndMean(name) | Reduction::SmallestAndMean(name) => {
                vec![own(), other(name)]
            }
            Reduction::LargestAs(name) => vec![other(name)],
        }
    }
}

impl Group {
    /// Its title.
    #[must_use]
    pub const fn title(&self) -> &'static str {
        self.title
    }

    /// The read-outs of its rows.
    pub fn read_outs(&self) -> impl Iterator<Item = &'static ReadOut> {
        self.rows.iter().map(|row| row.read_out)
    }

    /// The results of its rows.
    #[must_use]
    pub fn results(&self) -> Vec<ReadOut> {
        match self.are_columns {
            true => self.rows.iter().flat_map(Row::results).collect(),
            false => self.read_outs().cloned().collect(),
        }
    }

    /// The table in Markdown, under its heading.
    #[must_use]
    pub fn markdown(&self) -> String {
        let title = self.title;
        let cell = |text: &str| text.replace('|', "\\|");
        let mut text = if self.are_columns {
            format!("### {title}\n\n| column | unit | meaning | result |\n|---|---|---|---|\n")
        } else {
            format!("### {title}\n\n| result | unit | meaning |\n|---|---|---|\n")
        };
        for row in &self.rows {
            let ReadOut {
                name,
                unit,
                meaning,
            } = row.read_out;
            let when = match row.when {
                "" => String::new(),
                when => format!(" ({when})"),
            };
            text += &format!("| `{name}` | {unit} | {}{when} |", cell(meaning));
            if self.are_columns {
                text += &format!(" {} |", row.reduced.words());
            }
            text.push('\n');
        }
        text
    }
}

/// Declares a table of columns with a handle for each: `HANDLE: "name", "unit", "meaning" => how, reduced …, when …;` A row without
/// a name is one that another file declares.
macro_rules! columns {
    (
        $(#[$doc:meta])*
        $table:ident of $of:ty, in $in:ty: $title:literal;
        $( $handle:ident $( : $name:literal, $unit:literal, $meaning:literal )? => $how:expr
            $( , reduced $reduced:expr )? $( , when $when:expr )? ; )+
    ) => {
        $( $(
            #[doc = concat!("Read-out: ", $meaning, ".")]
            pub(crate) static $handle: $crate::output::ReadOut =
                $crate::output::ReadOut::new($name, $unit, $meaning);
        )? )+
        $(#[$doc])*
        pub(super) static $table: $crate::measure::read_out::Columns<$of, $in> =
            $crate::measure::read_out::Columns {
                title: $title,
                rows: &[ $(
                    $crate::measure::read_out::Column::<$of, $in>::new(&$handle, $how)
                        $( .reduced($reduced) )? $( .when(&$when) )?
                ),+ ],
            };
    };
}

/// Declares results that are no columns, with a handle for each: `HANDLE: "name", "unit", "meaning";`. A row without a name is one
/// that another file declares.
macro_rules! results {
    (
        $(#[$doc:meta])*
        $table:ident: $title:literal;
        $( $handle:ident $( : $name:literal, $unit:literal, $meaning:literal )? ; )+
    ) => {
        $( $(
            #[doc = concat!("Result: ", $meaning, ".")]
            pub(crate) static $handle: $crate::output::ReadOut =
                $crate::output::ReadOut::new($name, $unit, $meaning);
        )? )+
        $(#[$doc])*
        pub(super) static $table: $crate::measure::read_out::Declared =
            $crate::measure::read_out::Declared { title: $title, rows: &[ $( &$handle ),+ ] };
    };
}

pub(super) use {columns, results};
