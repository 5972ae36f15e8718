//! Where nodes stand along the chord: the same places on every rib.

use super::plan::{Fineness, Plan, WingFault};
use super::section::Side;

/// Points at which the outline is measured.
const SAMPLES: usize = 2000;

/// How much shorter edges are at the nose than elsewhere, and how far from it that is felt, per chord.
const NOSE: (f64, f64) = (2.0, 0.05);

/// Places of the nodes on both sides, from 0 to 1, `[along_chord + 1]` each.
#[derive(Debug, Clone)]
pub struct Places {
    /// On the upper side.
    pub upper: Vec<f64>,
    /// On the lower side.
    pub lower: Vec<f64>,
}

impl Places {
    /// Divides both sides of the middle profile evenly along its outline, finer at the nose, with nodes where lines are attached and
    /// intakes end.
    pub fn new(plan: &Plan, fineness: Fineness) -> Result<Self, WingFault> {
        let rows = plan.rows.iter();
        let mut named: Vec<f64> = rows
            .flat_map(|row| row.attachments().map(|(_, place)| place))
            .collect();
        named.sort_by(f64::total_cmp);
        named.dedup();
        if let Some(intakes) = plan.intakes {
            named.extend([intakes.from, intakes.to]);
        }
        Ok(Self {
            upper: divide(plan, Side::Upper, Vec::new(), fineness.along_chord)?,
            lower: divide(plan, Side::Lower, named, fineness.along_chord)?,
        })
    }

    /// Of one side.
    #[must_use]
    pub fn of(&self, side: Side) -> &[f64] {
        match side {
            Side::Upper => &self.upper,
            Side::Lower => &self.lower,
        }
    }

    /// The node nearest to a place.
    #[must_use]
    pub fn nearest(&self, side: Side, place: f64) -> usize {
        let places = self.of(side);
        let next = places.partition_point(|x| *x < place).min(places.len() - 1);
        if next > 0 && place - places[next - 1] < places[next] - place {
            next - 1
        } else {
            next
        }
    }

    /// The nodes nearest to both ends of a width about a place; at least one edge on each side of it, where the chord goes on.
    #[must_use]
    pub fn around(&self, side: Side, place: f64, width: f64) -> [usize; 2] {
        let middle = self.nearest(side, place);
        let last = self.of(side).len() - 1;
        let first = self
            .nearest(side, place - 0.5 * width)
            .min(middle.saturating_sub(1));
        let end = self.nearest(side, place + 0.5 * width).max(middle + 1);
        [first, end.min(last)]
    }
}

fn divide(
    plan: &Plan,
    side: Side,
    mut named: Vec<f64>,
    edges: usize,
) -> Result<Vec<f64>, WingFault> {
    let profile = &plan.profiles[plan.stations[0].profile];
    // Weighted length of the outline up to every sample.
    let place = |i: usize| (i as f64 / SAMPLES as f64).powi(2);
    let mut lengths = vec![0.0];
    for i in 0..SAMPLES {
        let (a, b) = (place(i), place(i + 1));
        let rise = profile.height(side, b) - profile.height(side, a);
        let weight = 1.0 + NOSE.0 * (-0.5 * (a + b) / NOSE.1).exp();
        lengths.push(lengths[i] + weight * rise.hypot(b - a));
    }
    let length_at = |x: f64| {
        let i = ((x.max(0.0).sqrt() * SAMPLES as f64) as usize).min(SAMPLES - 1);
        let share = (x - place(i)) / (place(i + 1) - place(i));
        lengths[i] + (lengths[i + 1] - lengths[i]) * share
    };
    let place_at = |length: f64| {
        let i = lengths.partition_point(|l| *l <= length).clamp(1, SAMPLES) - 1;
        let share = (length - lengths[i]) / (lengths[i + 1] - lengths[i]);
        place(i) + (place(i + 1) - place(i)) * share
    };
    named.extend([0.0, 1.0]);
    named.sort_by(f64::total_cmp);
    named.dedup_by(|a, b| (*a - *b).abs() < 1e-6);
    let intervals = named.len() - 1;
    if edges < intervals {
        return Err(WingFault::TooCoarse {
            along_chord: edges,
            places: intervals,
            side: match side {
                Side::Upper => "upper",
                Side::Lower => "lower",
            },
        });
    }
    let ends: Vec<f64> = named.iter().map(|&x| length_at(x)).collect();
    // One edge each, the others one by one where edges are longest.
    let mut counts = vec![1; intervals];
    for _ in intervals..edges {
        let longest = |i: usize| (ends[i + 1] - ends[i]) / counts[i] as f64;
        let most = (0..intervals)
            .max_by(|&a, &b| longest(a).total_cmp(&longest(b)))
            .unwrap_or(0);
        counts[most] += 1;
    }
    let mut places = vec![0.0];
    for i in 0..intervals {
        for k in 1..counts[i] {
            let share = k as f64 / counts[i] as f64;
            places.push(place_at(ends[i] + (ends[i + 1] - ends[i]) * share));
        }
        places.push(named[i + 1]);
    }
    Ok(places)
}
