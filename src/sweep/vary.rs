//! What varies in a sweep, from the words of the command line.

use std::collections::BTreeMap;

/// Value that leaves a key as the case has it.
pub const AS_WRITTEN: &str = "as_written";

/// Key that moves all that stands in the air against the lattice.
pub const SHIFT_KEY: &str = "resolution.shift_cells";

/// Keys that set the size of cells.
pub(super) const LATTICE_KEYS: [&str; 3] = [
    "resolution.cells_per_diameter",
    "resolution.cells_per_chord",
    "resolution.cell_size_m",
];

/// Steps along x, y, z from one start of an ensemble to the next [cells]: the golden ratio, √2 and √3 without their whole parts. Multiples of
/// numbers that are so badly approximated by fractions lie evenly within a cell, however many there are.
const START_STEPS: [f64; 3] = [0.618_034, std::f64::consts::SQRT_2 - 1.0, 0.732_051];

/// Longest name of a folder.
const LONGEST_NAME: usize = 80;

/// Most runs of one sweep.
const RUN_LIMIT: usize = 10_000;

/// Keys that vary together: the first value of each belongs to the first run, and so on.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Vary {
    /// Dotted paths of the keys.
    pub keys: Vec<String>,
    /// Values of every run, one for each key.
    pub values: Vec<Vec<String>>,
}

/// One run of a sweep.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Point {
    /// Keys and values, in the order of the command line.
    pub values: Vec<(String, String)>,
    /// Folder below that of the sweep.
    pub folder: String,
}

/// Splits at `separator` outside brackets and quotes.
fn split(text: &str, separator: char) -> Vec<String> {
    let mut parts = vec![String::new()];
    let (mut depth, mut quote) = (0_i32, None);
    for c in text.chars() {
        match (quote, c) {
            (Some(open), _) if c == open => quote = None,
            (None, '"' | '\'') => quote = Some(c),
            (None, '[' | '{') => depth += 1,
            (None, ']' | '}') => depth -= 1,
            _ => {}
        }
        if c == separator && depth == 0 && quote.is_none() {
            parts.push(String::new());
        } else if let Some(last) = parts.last_mut() {
            last.push(c);
        }
    }
    parts.into_iter().map(|p| p.trim().to_owned()).collect()
}

impl std::str::FromStr for Vary {
    type Err = String;

    /// Reads `key.path=a,b,c`, or several of them, separated by semicolons, that vary together.
    fn from_str(text: &str) -> Result<Self, String> {
        let mut lists: Vec<(String, Vec<String>)> = Vec::new();
        for part in split(text, ';') {
            let (key, values) = part
                .split_once('=')
                .ok_or_else(|| format!("there is no `=` in `{part}`: write key.path=a,b,c"))?;
            let (key, values) = (key.trim().to_owned(), split(values, ','));
            if key.is_empty() || values.iter().any(String::is_empty) {
                return Err(format!(
                    "a key or a value is empty in `{part}`: write key.path=a,b,c"
                ));
            }
            if let Some((first, known)) = lists.first()
                && known.len() != values.len()
            {
                return Err(format!(
                    "{first} has {} values and {key} has {}: keys that vary together need as many",
                    known.len(),
                    values.len()
                ));
            }
            lists.push((key, values));
        }
        let count = lists.first().map_or(0, |(_, values)| values.len());
        Ok(Self {
            values: (0..count)
                .map(|run| {
                    lists
                        .iter()
                        .map(|(_, values)| values[run].clone())
                        .collect()
                })
                .collect(),
            keys: lists.into_iter().map(|(key, _)| key).collect(),
        })
    }
}

impl Vary {
    /// The same case from so many places on the lattice, each within half a cell of where it is written; the first is not moved.
    #[must_use]
    pub fn ensemble(count: usize) -> Self {
        let place = |member: usize| {
            let parts = START_STEPS.map(|step| {
                let turns = 0.5 + member as f64 * step;
                format!("{:.4}", turns.fract() - 0.5)
            });
            format!("[{}]", parts.join(", "))
        };
        let moved = (1..count).map(|member| vec![place(member)]);
        Self {
            keys: vec![SHIFT_KEY.to_owned()],
            values: std::iter::once(vec![AS_WRITTEN.to_owned()])
                .chain(moved)
                .collect(),
        }
    }

    /// True if it changes the size of cells.
    #[must_use]
    pub fn changes_lattice(&self) -> bool {
        let mut keys = self.keys.iter();
        keys.any(|key| LATTICE_KEYS.contains(&key.as_str()))
    }
}

impl Point {
    /// Changes of the case, `key.path=value` each.
    #[must_use]
    pub fn overrides(&self) -> Vec<String> {
        let changed = self.values.iter().filter(|(_, value)| value != AS_WRITTEN);
        changed
            .map(|(key, value)| format!("{key}={value}"))
            .collect()
    }
}

/// All runs of a sweep: every value of one `--vary` with every value of the others, the last one fastest. An error tells of keys that
/// appear twice, or of too many runs.
pub fn points(varies: &[Vary]) -> Result<Vec<Point>, String> {
    let mut keys: Vec<&String> = varies.iter().flat_map(|vary| &vary.keys).collect();
    let count = keys.len();
    keys.sort();
    keys.dedup();
    if keys.len() < count {
        return Err("a key varies twice: name each key once".to_owned());
    }
    for vary in varies {
        let mut values = vary.values.clone();
        values.sort();
        values.dedup();
        if values.len() < vary.values.len() {
            return Err(format!(
                "`{}` has a value twice, which would be one run twice: name each value once (--ensemble N shifts starts)",
                vary.keys.join(",")
            ));
        }
    }
    let runs = varies
        .iter()
        .try_fold(1_usize, |product, vary| {
            product.checked_mul(vary.values.len())
        })
        .filter(|&runs| runs <= RUN_LIMIT);
    if runs.is_none() {
        return Err(format!("these are more than {RUN_LIMIT} runs"));
    }
    let mut points: Vec<Vec<(String, String, bool)>> = vec![Vec::new()];
    for vary in varies {
        points = points
            .iter()
            .flat_map(|before| {
                vary.values.iter().map(move |values| {
                    let own = vary.keys.iter().zip(values).enumerate();
                    let own = own.map(|(k, (key, value))| (key.clone(), value.clone(), k == 0));
                    before.iter().cloned().chain(own).collect()
                })
            })
            .collect();
    }
    let starts: BTreeMap<&String, usize> = varies
        .iter()
        .filter(|vary| vary.keys == [SHIFT_KEY])
        .flat_map(|vary| &vary.values)
        .enumerate()
        .filter_map(|(start, values)| Some((values.first()?, start)))
        .collect();
    let mut found: Vec<Point> = Vec::new();
    for point in points {
        // The first key of those that vary together tells the run; the others follow from it.
        let words = point
            .iter()
            .filter(|(_, _, leads)| *leads)
            .filter_map(|(key, value, _)| match starts.get(value) {
                // The first start has the folder of a sweep without others.
                Some(0) if key == SHIFT_KEY => None,
                Some(start) if key == SHIFT_KEY => Some(format!("start={}", start + 1)),
                _ => {
                    let key = key.rsplit('.').next().unwrap_or(key);
                    Some(format!("{key}={value}"))
                }
            });
        let words = words.collect::<Vec<_>>().join(",");
        let name = folder_name(if words.is_empty() { "start=1" } else { &words });
        let taken = |name: &str| found.iter().any(|p| p.folder == name);
        let mut folder = name.clone();
        let mut number = 2;
        while taken(&folder) {
            folder = format!("{name}-{number}");
            number += 1;
        }
        found.push(Point {
            values: point
                .into_iter()
                .map(|(key, value, _)| (key, value))
                .collect(),
            folder,
        });
    }
    Ok(found)
}

fn folder_name(words: &str) -> String {
    let allowed = |c: char| c.is_ascii_alphanumeric() || "._-=,+".contains(c);
    let mut name: String = (words.chars())
        .map(|c| if allowed(c) { c } else { '_' })
        .collect();
    name.truncate(LONGEST_NAME);
    name
}

#[cfg(test)]
mod tests {
    use super::*;

    fn vary(text: &str) -> Vary {
        text.parse().unwrap()
    }

    #[test]
    fn keys_vary_alone_together_and_crosswise() {
        let wind = vary("air.wind_tunnel.speed_m_s=20,30; time.end_s = 1.5, 1");
        assert_eq!(wind.keys, ["air.wind_tunnel.speed_m_s", "time.end_s"]);
        assert_eq!(wind.values, [["20", "1.5"], ["30", "1"]]);
        let belts = vary("belts=as_written,absent");
        let runs = points(&[wind, belts]).unwrap();
        let folders: Vec<&str> = runs.iter().map(|run| run.folder.as_str()).collect();
        assert_eq!(
            folders,
            [
                "speed_m_s=20,belts=as_written",
                "speed_m_s=20,belts=absent",
                "speed_m_s=30,belts=as_written",
                "speed_m_s=30,belts=absent"
            ]
        );
        assert_eq!(
            runs[0].overrides(),
            ["air.wind_tunnel.speed_m_s=20", "time.end_s=1.5"]
        );
        assert_eq!(runs[1].overrides()[2], "belts=absent");
    }

    #[test]
    fn starts_of_an_ensemble_fill_a_cell() {
        let starts = Vary::ensemble(9);
        assert_eq!(starts.values[0], [AS_WRITTEN]);
        let places: Vec<Vec<f64>> = starts.values[1..]
            .iter()
            .map(|value| {
                let inside = value[0].trim_matches(['[', ']']);
                inside.split(", ").map(|x| x.parse().unwrap()).collect()
            })
            .collect();
        for axis in 0..3 {
            let mut along: Vec<f64> = places.iter().map(|place| place[axis]).collect();
            along.push(0.0);
            along.sort_by(f64::total_cmp);
            assert!(along[0] >= -0.5 && along[8] < 0.5, "{along:?}");
            // Nine evenly spread points would stand a ninth apart.
            let widest = along.windows(2).map(|p| p[1] - p[0]).fold(0.0, f64::max);
            assert!(widest < 0.25, "{along:?}");
        }
        let cells = vary("resolution.cells_per_diameter=12,16");
        assert!(cells.changes_lattice() && !starts.changes_lattice());
        let runs = points(&[cells, Vary::ensemble(2)]).unwrap();
        let folders: Vec<&str> = runs.iter().map(|run| run.folder.as_str()).collect();
        assert_eq!(
            folders,
            [
                "cells_per_diameter=12",
                "cells_per_diameter=12,start=2",
                "cells_per_diameter=16",
                "cells_per_diameter=16,start=2"
            ]
        );
        assert_eq!(runs[0].overrides(), ["resolution.cells_per_diameter=12"]);
        assert!(runs[1].overrides()[1].starts_with("resolution.shift_cells=["));
        assert_eq!(points(&[Vary::ensemble(2)]).unwrap()[0].folder, "start=1");
    }

    #[test]
    fn lists_and_tables_are_single_values() {
        let times = vary("output.picture_times_s=[0, 0.1],[0.2]");
        assert_eq!(times.values, [["[0, 0.1]"], ["[0.2]"]]);
        let model = vary("a.b={ x = 1, y = \"p,q;r\" },2");
        assert_eq!(model.values.len(), 2);
    }

    #[test]
    fn folders_differ_and_wrong_lists_are_refused() {
        let runs = points(&[vary("a.x=1/2,1?2")]).unwrap();
        assert_eq!(runs[0].folder, "x=1_2");
        assert_eq!(runs[1].folder, "x=1_2-2");
        for wrong in ["a.b", "a.b=", "=1", "a.b=1,,2", "a=1,2;b=1", "a=1;"] {
            assert!(wrong.parse::<Vary>().is_err(), "{wrong}");
        }
        assert!(points(&[vary("a=1,2"), vary("a=3,4")]).is_err());
        assert!(points(&[vary("a=1,2,1")]).is_err());
        assert!(points(&[vary("a=1,1;b=1,2")]).is_ok());
        let many = vary(&format!("a={}", vec!["1"; 101].join(",")));
        let mut other = many.clone();
        other.keys = vec!["b".to_owned()];
        assert!(points(&[many, other]).is_err());
    }
}
