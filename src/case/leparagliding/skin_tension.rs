//! Sections 5 and 31, "skin tension": by how much panels are cut wider than the distance of their ribs.
//!
//! Both edges of a panel stand outwards by a share of its width, so the panel is wider by twice that. Shares are given over the length along the outline.
//! Those of upper panels count from the front lip of the intake around the nose to the trailing edge, those of lower ones from the trailing edge to the rear lip.

use glam::DVec2;
use toml::Value;

use super::super::design::Keys;
use super::super::design::wing::usual_ballooning;
use super::sections::{MOST_RIBS, ReadFault, Section, Sections};
use crate::geometry::profile::Profile;

/// Points of section 5.
const GLOBAL_POINTS: usize = 6;

/// Points along each side of an outline whose lengths are summed up.
const POINTS_PER_SIDE: usize = 200;

/// Largest share of the width at either edge [%]: panels one and a half times as wide as the distance of their ribs.
const MOST_SHARE: f64 = 25.0;

/// Upper and lower panels: points (place along the outline, share of the width at either edge), both per cent, places growing.
type Law = [Vec<[f64; 2]>; 2];

/// What the file says of its panels.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct SkinTension {
    law: Law,
    /// Number of the section that it is from.
    section: i64,
    /// Ribs of other laws, first and last of each.
    others: Vec<[usize; 2]>,
}

/// Rows of a table, from the column of the first place on.
fn law(section: &mut Section, rows: usize, first: usize) -> Result<Law, ReadFault> {
    let mut law = [Vec::new(), Vec::new()];
    for _ in 0..rows {
        let row = section.numbers(first + 4)?;
        for (side, points) in law.iter_mut().enumerate() {
            points.push([row[first + 2 * side], row[first + 2 * side + 1]]);
        }
    }
    let grows = |points: &Vec<[f64; 2]>| points.windows(2).all(|pair| pair[1][0] > pair[0][0]);
    let is_whole = |points: &Vec<[f64; 2]>| {
        let ends = [points.first(), points.last()].map(|point| point.map(|point| point[0]));
        ends == [Some(0.0), Some(100.0)]
    };
    let shares = law.iter().flatten().map(|point| point[1]);
    let are_shares = shares.into_iter().all(|share| share <= MOST_SHARE);
    if are_shares && law.iter().all(|points| grows(points) && is_whole(points)) {
        Ok(law)
    } else {
        Err(ReadFault::SkinTension)
    }
}

impl SkinTension {
    /// Section 31 where it is in use, of the law that most ribs have; section 5 elsewhere.
    pub(super) fn read(sections: &Sections) -> Result<Self, ReadFault> {
        if let Ok(mut section) = sections.get(31, "new skin tension")
            && section.count().is_ok_and(|scheme| scheme == 1)
        {
            return Self::of_groups(&mut section);
        }
        let mut section = sections.get(5, "skin tension")?;
        section.line()?;
        Ok(Self {
            law: law(&mut section, GLOBAL_POINTS, 0)?,
            section: 5,
            others: Vec::new(),
        })
    }

    fn of_groups(section: &mut Section) -> Result<Self, ReadFault> {
        let mut groups: Vec<([usize; 2], Law)> = Vec::new();
        for _ in 0..section.count()? {
            // Group, first and last rib, points, rule between them.
            let row = section.numbers(4)?;
            let ribs = [row[1], row[2]].map(|rib| rib.clamp(0.0, MOST_RIBS) as usize);
            groups.push((ribs, law(section, row[3].max(0.0) as usize, 1)?));
        }
        let ribs_of = |law: &Law| -> usize {
            let same = groups.iter().filter(|(_, other)| other == law);
            same.map(|([first, last], _)| (last + 1).saturating_sub(*first))
                .sum()
        };
        let most = groups.iter().rev().max_by_key(|(_, law)| ribs_of(law));
        let Some((_, law)) = most.cloned() else {
            return Err(ReadFault::SkinTension);
        };
        let others = groups.iter().filter(|(_, other)| *other != law);
        Ok(Self {
            others: others.map(|(ribs, _)| *ribs).collect(),
            law,
            section: 31,
        })
    }
}

/// Puts the ballooning of the panels; the usual one where the file's cannot be read, or the profile is not there. `intake` is over the chord.
pub(super) fn derive(
    read: &Result<SkinTension, ReadFault>,
    profile: Option<&Profile>,
    intake: Option<[f64; 2]>,
    keys: &mut Keys,
    left_out: &mut Vec<String>,
) {
    let (tension, profile) = match (read, profile) {
        (Ok(tension), Some(profile)) => (tension, profile),
        (Err(fault), _) => {
            left_out.push(format!(
                "skin tension: {fault}; that of the shipped wings stands in its place"
            ));
            return usual_ballooning(keys);
        }
        (_, None) => {
            left_out.push(
                "skin tension: the profile in the middle cannot be read; that of the shipped wings stands in its place"
                    .to_owned(),
            );
            return usual_ballooning(keys);
        }
    };
    for [first, last] in &tension.others {
        left_out.push(format!(
            "skin tension of the ribs {first} to {last}: all panels have that of the others"
        ));
    }
    if tension.law.iter().flatten().any(|point| point[1] < 0.0) {
        left_out
            .push("panels narrower than the distance of their ribs: they are as wide".to_owned());
    }
    let why = format!("skin tension, section {}, at both edges", tension.section);
    let tables = ballooning(&tension.law, profile, intake.unwrap_or([0.0; 2]));
    for (side, table) in ["upper", "lower"].into_iter().zip(tables) {
        let points: Vec<Value> = table
            .into_iter()
            .map(|point| Value::from(point.map(Value::from).to_vec()))
            .collect();
        keys.set(format!("structure.wing.ballooning.{side}"), points, &why);
    }
}

/// Points (x/c, width over the distance of the ribs less 1) of the upper and the lower side, places growing from 0 to 1.
fn ballooning(law: &Law, profile: &Profile, [from, to]: [f64; 2]) -> Law {
    let outline = profile.resampled(POINTS_PER_SIDE);
    let mut lower = outline[..=POINTS_PER_SIDE].to_vec();
    lower.reverse();
    let sides = [&outline[POINTS_PER_SIDE..], &lower[..]].map(lengths);
    let [upper, lower] = &sides;
    // From the front lip to the nose, and on to the trailing edge.
    let [lip, rear_lip] = [from, to].map(|place| between(lower, place, [0, 1]));
    let upper_length = lip + upper.last().map_or(0.0, |end| end[1]);
    let lower_length = lower.last().map_or(0.0, |end| end[1]) - rear_lip;
    let extra = |share: f64| 0.02 * share.max(0.0);
    let at_nose = extra(between(&law[0], 100.0 * lip / upper_length, [0, 1]));
    let mut tables = [vec![[0.0, at_nose]], vec![[0.0, at_nose]]];
    for [place, share] in &law[0] {
        let length = 0.01 * place * upper_length - lip;
        tables[0].push([between(upper, length, [1, 0]), extra(*share)]);
    }
    tables[1].push([from, extra(law[0].first().map_or(0.0, |point| point[1]))]);
    for [place, share] in law[1].iter().rev() {
        let length = rear_lip + (1.0 - 0.01 * place) * lower_length;
        tables[1].push([between(lower, length, [1, 0]), extra(*share)]);
    }
    // Points between the front lip and the nose are left out, since the lower side is straight there; others are not twice at one place.
    for table in &mut tables {
        table.dedup_by(|next, before| next[0] <= before[0] + 1e-6);
        if let Some(last) = table.last_mut() {
            last[0] = 1.0;
        }
    }
    tables
}

/// Points (x/c, length along the side from the nose), places growing.
fn lengths(side: &[DVec2]) -> Vec<[f64; 2]> {
    let mut length = 0.0;
    let mut points: Vec<[f64; 2]> = vec![[0.0, 0.0]];
    for pair in side.windows(2) {
        length += pair[0].distance(pair[1]);
        points.push([pair[1].x, length]);
    }
    // A nose may reach ahead of the origin.
    points.dedup_by(|next, before| next[0] <= before[0]);
    points
}

/// The second of two columns where the first has a value, on straight lines; constant beyond the ends.
fn between(points: &[[f64; 2]], at: f64, [known, asked]: [usize; 2]) -> f64 {
    let next = points.partition_point(|point| point[known] <= at);
    let (Some(before), Some(after)) = (points.get(next.wrapping_sub(1)), points.get(next)) else {
        let end = if next == 0 {
            points.first()
        } else {
            points.last()
        };
        return end.map_or(0.0, |point| point[asked]);
    };
    let share = (at - before[known]) / (after[known] - before[known]);
    before[asked] + share * (after[asked] - before[asked])
}

#[cfg(test)]
mod tests {
    use super::*;

    const TEXT: &str = "*           5. SKIN TENSION\nExtrados\n0. 0. 0. 0.\n7.5 1.3 10. 1.33\n15. 2.5 20. 2.5\n80. 2.5 80. 2.5\n90. 1.33 90. 1.33\n100. 0. 100. 0.\n0.0114\n";

    /// A flat plate, nearly: lengths along the outline are places along the chord.
    fn plate() -> Profile {
        Profile::naca("0001").unwrap()
    }

    fn value(table: &[[f64; 2]], place: f64) -> f64 {
        between(table, place, [0, 1])
    }

    /// Of a thin profile whose intake reaches from 10 to 20 % of the chord the upper outline is 1.1 chords long, the lower 0.8.
    #[test]
    fn places_are_those_along_the_outline() {
        let tension = SkinTension::read(&Sections::new(TEXT)).unwrap();
        let [upper, lower] = ballooning(&tension.law, &plate(), [0.1, 0.2]);
        // 10 % of 1.1 chords is at 0.01 behind the nose, 15 % at 0.065, 80 % at 0.78.
        let nose = value(&tension.law[0], 100.0 * 0.1 / 1.1);
        assert!((upper[0][1] - 0.02 * nose).abs() < 1e-3, "{upper:?}");
        for (place, extra) in [(0.07, 0.05), (0.5, 0.05), (0.89, 0.0266), (1.0, 0.0)] {
            assert!(
                (value(&upper, place) - extra).abs() < 1e-3,
                "{place} {upper:?}"
            );
        }
        // From the trailing edge: 10 % of 0.8 chords is at 0.92, 90 % at 0.28.
        for (place, extra) in [(0.92, 0.0266), (0.5, 0.05), (0.28, 0.0266), (0.2, 0.0)] {
            assert!(
                (value(&lower, place) - extra).abs() < 1e-3,
                "{place} {lower:?}"
            );
        }
        for table in [&upper, &lower] {
            assert!(
                table.windows(2).all(|pair| pair[1][0] > pair[0][0]),
                "{table:?}"
            );
            assert_eq!([table[0][0], table[table.len() - 1][0]], [0.0, 1.0]);
        }
    }

    /// Of a thick, cambered profile half of the upper outline is not half of the chord. Here lengths are summed up from the profile's own formula.
    #[test]
    fn places_follow_a_thick_nose() {
        let tension = SkinTension::read(&Sections::new(TEXT)).unwrap();
        let profile = Profile::naca("2430").unwrap();
        let [upper, _] = ballooning(&tension.law, &profile, [0.0, 0.0]);
        // NACA 2430: thickness 5 t (0.2969 √x − 0.126 x − 0.3516 x² + 0.2843 x³ − 0.1036 x⁴), camber 2 % at 40 %; nodes dense at the nose.
        let point = |x: f64| {
            let half =
                1.5 * (0.2969 * x.sqrt() - x * (0.126 + x * (0.3516 - x * (0.2843 - 0.1036 * x))));
            let (camber, slope) = if x < 0.4 {
                (0.125 * (0.8 * x - x * x), 0.25 * (0.4 - x))
            } else {
                ((0.2 + 0.8 * x - x * x) / 18.0, (0.4 - x) / 9.0)
            };
            let angle = f64::atan(slope);
            DVec2::new(x - half * angle.sin(), camber + half * angle.cos())
        };
        let places: Vec<DVec2> = (0..=4000)
            .map(|i| point((f64::from(i) / 4000.0).powi(2)))
            .collect();
        let steps: Vec<f64> = places.windows(2).map(|p| p[0].distance(p[1])).collect();
        let whole: f64 = steps.iter().sum();
        let mut length = 0.0;
        let at = |share: f64, length: &mut f64| {
            let next = steps.iter().position(|step| {
                *length += step;
                *length >= share * whole
            });
            places[next.unwrap() + 1].x
        };
        let place = at(0.15, &mut length);
        assert!(place < 0.1, "{place}");
        let found = upper
            .iter()
            .find(|point| (point[1] - 0.05).abs() < 1e-9)
            .unwrap()[0];
        assert!((found - place).abs() < 2e-3, "{found} {place}");
    }

    /// Lower places count from the trailing edge: a law that is not the same from both ends shows it.
    #[test]
    fn groups_of_ribs() {
        let groups = "* 31. NEW SKIN TENSION MODULE\n1\n2\n* group\n1 1 4 3 1\n1 0 0 0 0\n2 50 1 25 2\n3 100 0 100 0\n* group\n2 5 15 3 1\n1 0 0 0 0\n2 50 2 25 2\n3 100 0 100 -1\n";
        let text = TEXT.to_owned() + groups;
        let tension = SkinTension::read(&Sections::new(&text)).unwrap();
        assert_eq!((tension.section, &tension.others[..]), (31, &[[1, 4]][..]));
        let [upper, lower] = ballooning(&tension.law, &plate(), [0.0, 0.0]);
        assert!((value(&upper, 0.5) - 0.04).abs() < 1e-3, "{upper:?}");
        assert!((value(&lower, 0.75) - 0.04).abs() < 1e-3, "{lower:?}");
        assert!(
            value(&lower, 0.25) < 0.02 && lower[0][1] >= 0.0,
            "{lower:?}"
        );
    }

    #[test]
    fn what_cannot_be_read() {
        for text in [
            "* 5. SKIN TENSION\nExtrados\n0. 0.3\n",
            "* 5. SKIN TENSION\nExtrados\n0 0 0 0\n7 1 9 1\n6 1 9 1\n80 1 80 1\n90 1 90 1\n100 0 100 0\n",
            "* 5. SKIN TENSION\nExtrados\n0 0 0 0\n7 1 9 1\n15 26 20 1\n80 1 80 1\n90 1 90 1\n100 0 100 0\n",
            "* 31. NEW SKIN TENSION MODULE\n1\n1\n1 1e30 1e30 2 1\n1 0 0 0 0\n2 90 0 100 0\n",
        ] {
            assert!(SkinTension::read(&Sections::new(text)).is_err());
        }
    }
}
