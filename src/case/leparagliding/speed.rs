//! Section 28: how far the risers are shortened where the wing is turned nose down.

use toml::{Table, Value};

use super::super::design::Keys;
use super::sections::{Section, Sections};

/// A study of the speed system: the wing turns about the attachments of its last riser.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct SpeedStudy {
    /// Places of the risers from the nose, per cent of the chord.
    places: Vec<f64>,
    /// Largest turn, nose down [°].
    turn_deg: f64,
}

impl SpeedStudy {
    /// `None` where the file has none, or none that can be read.
    pub(super) fn read(sections: &Sections) -> Option<Self> {
        let mut section: Section = sections.get(28, "speed system").ok()?;
        if section.count().ok()? == 0 {
            return None;
        }
        let risers = section.count().ok()?;
        let mut places = section.numbers(risers.max(2)).ok()?;
        places.truncate(risers);
        let turn_deg = -section.number().ok()?;
        let grows = places.windows(2).all(|pair| pair[1] > pair[0]);
        ((0.1..20.0).contains(&turn_deg) && grows).then_some(Self { places, turn_deg })
    }

    /// By how much the bar shortens the riser of each row at full travel [m], where the chord in the middle is so long [m].
    fn shortening_m(&self, chord_m: f64) -> impl Iterator<Item = f64> {
        let last = self.places.last().copied().unwrap_or(0.0);
        let per_cent_m = 0.01 * chord_m * self.turn_deg.to_radians().sin();
        self.places
            .iter()
            .map(move |place| (last - place) * per_cent_m)
    }
}

/// Puts the speed bar, by the rows of the risers from the nose on, if they have lines, and the chord in the middle [m].
pub(super) fn derive(
    study: Option<&SpeedStudy>,
    risers: &[Option<&str>],
    chord_m: f64,
    keys: &mut Keys,
    left_out: &mut Vec<String>,
) {
    let Some(study) = study else {
        left_out.push(
            "a speed bar: the file has no study of one that can be used (section 28)".to_owned(),
        );
        return;
    };
    let shortened: Table = (risers.iter().zip(study.shortening_m(chord_m)))
        .filter(|(_, length_m)| *length_m > 0.0)
        .filter_map(|(row, length_m)| row.map(|name| (name.to_owned(), Value::from(length_m))))
        .collect();
    if shortened.is_empty() {
        left_out.push("a speed bar: its study has one riser (section 28)".to_owned());
        return;
    }
    keys.set(
        "structure.wing.speed_bar.shortening_m",
        Value::Table(shortened),
        "section 28: the largest turn of its study, about the last riser",
    );
}
