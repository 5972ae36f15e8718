//! Notices a flow that is about to break down, from what a few looks at the air found one after the other.
//!
//! Measured on spheres: breakdown begins at the surface or in its shear layer. Slip grows exponentially for 0.7 D/U before; the fastest
//! cell goes from 1.4 to 2.3 times the wind and to infinity within 0.3 D/U. So looks at the cells around the markers are about 0.1 D/U
//! apart; looks at all cells are rarer and know no growth.
//!
//! No checkpoint holds a watch: a resumed run begins a new one, and notices growth three looks later at most.

use crate::lattice::grid::{CellState, Extremes};

/// Speed at which the air counts as diverged [cells per step]: Mach 0.69, far beyond what the method represents.
pub const SPEED_LIMIT: f64 = 0.4;

/// The same in reference speeds. Flow around bodies reaches 1.5 to 2.
pub const REFERENCE_SPEEDS: f64 = 6.0;

/// Growth of the fastest cell from look to look, twice in succession, that counts as breaking down.
const SPEED_GROWTH: f64 = 1.5;

/// Slower cells may become faster as they like [reference speeds].
const FAST: f64 = 2.5;

/// Growth of the slip from look to look, three times in succession, that counts as breaking down.
const SLIP_GROWTH: f64 = 2.0;

/// Slip that is too small to matter, and slip from which on growth counts [reference speeds]. Bodies that are set in motion begin with none.
const SLIPS: [f64; 2] = [0.02, 0.2];

/// Looks that are kept: growth of the slip takes four.
const KEPT: usize = 4;

/// Distance between looks around the markers [D/U].
const LOOK_INTERVAL: f64 = 0.1;

/// Fewest steps between them: a look costs up to a step of the cells it reads, and a device is waited for.
const FEWEST_STEPS: u64 = 10;
const FEWEST_STEPS_ON_DEVICE: u64 = 64;

/// Steps between looks at all cells, at most: half a per cent of a step each where a look costs half a step.
const WHOLE_INTERVAL: u64 = 128;

/// A look at the air, as far as it is kept.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Look {
    /// Step after which it was.
    pub step: u64,
    /// Time since release [s].
    pub time_s: f64,
    /// The fastest cell.
    pub fastest: CellState,
    /// Fastest of the wind, the speed that the lattice is scaled with and all markers [cells per step].
    pub reference_speed: f64,
    /// Root mean square slip at the markers over that speed; `None` where it was not read.
    pub slip_ratio: Option<f64>,
}

impl Look {
    /// Speed of the fastest cell over the reference speed.
    #[must_use]
    pub fn speed_ratio(&self) -> f64 {
        self.fastest.speed / self.reference_speed
    }
}

/// What a look found, and what holds when it does.
#[derive(Debug, Clone, Copy)]
pub struct Found {
    /// Step after which it was.
    pub step: u64,
    /// Time since release [s].
    pub time_s: f64,
    /// The cells that stand out.
    pub extremes: Extremes,
    /// As in [`Look`].
    pub reference_speed: f64,
    /// As in [`Look`].
    pub slip_ratio: Option<f64>,
    /// True once the wind has risen: reference speeds count.
    pub released: bool,
    /// True once the release, or a change of the lattice, is long enough ago for growth to count.
    pub settled: bool,
}

impl Found {
    fn look(&self, fastest: CellState) -> Look {
        Look {
            step: self.step,
            time_s: self.time_s,
            fastest,
            reference_speed: self.reference_speed,
            slip_ratio: self.slip_ratio,
        }
    }
}

/// By what a flow shows that it breaks down.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Sign {
    /// Cells are no longer finite.
    NotFinite,
    /// A density is too far from that of undisturbed air.
    Density,
    /// A cell is faster than [`SPEED_LIMIT`].
    TooFast,
    /// A cell is faster than [`REFERENCE_SPEEDS`].
    ManyReferenceSpeeds,
    /// The fastest cell became faster by these factors.
    SpeedGrows([f64; 2]),
    /// The slip grew by these factors.
    SlipGrows([f64; 3]),
}

/// A flow that breaks down.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Alarm {
    /// How it shows.
    pub sign: Sign,
    /// The cell to blame: as it was at the last look at which all was finite.
    pub state: CellState,
    /// Step of that look.
    pub step: u64,
    /// Reference speed then [cells per step].
    pub reference_speed: f64,
}

/// The last looks, and when the next are due.
#[derive(Debug, Clone, Default)]
pub struct Watch {
    /// Around the markers, the oldest first.
    near: Vec<Look>,
    /// The last one at all cells.
    whole: Option<Look>,
    next_near: u64,
    next_whole: u64,
}

/// Steps from one look around the markers to the next: for a structure `size` cells large, at `speed` cells per step, in a box with so
/// large a `share` of all cells. A look costs up to a step of its cells: one per cent, and less where the box is small.
#[must_use]
pub fn steps_between(size: f64, speed: f64, share: f64, on_device: bool) -> u64 {
    let fewest = if on_device {
        FEWEST_STEPS_ON_DEVICE
    } else {
        FEWEST_STEPS
    };
    let by_time = (LOOK_INTERVAL * size / speed).ceil();
    let by_cost = (WHOLE_INTERVAL as f64 * share).ceil();
    fewest.max(by_time.max(by_cost) as u64)
}

impl Watch {
    /// True if a look at all cells is due.
    #[must_use]
    pub const fn whole_is_due(&self, step: u64) -> bool {
        step >= self.next_whole
    }

    /// True if a look of either kind is due.
    #[must_use]
    pub const fn is_due(&self, step: u64) -> bool {
        step >= self.next_near || self.whole_is_due(step)
    }

    /// Looks around the markers, the oldest first.
    #[must_use]
    pub fn looks(&self) -> &[Look] {
        &self.near
    }

    /// Without markers only looks at all cells are due.
    pub const fn no_markers(&mut self) {
        self.next_near = u64::MAX;
    }

    /// Takes a look around the markers; the next is due after so many steps.
    pub fn add_near(&mut self, found: &Found, steps: u64) -> Option<Alarm> {
        self.next_near = found.step + steps;
        let alarm = beyond_limits(found, self.near.last());
        let (None, Some(fastest)) = (alarm, found.extremes.fastest) else {
            return alarm;
        };
        if self.near.len() == KEPT {
            self.near.remove(0);
        }
        self.near.push(found.look(fastest));
        let sign = self.growth().filter(|_| found.settled)?;
        Some(Alarm {
            sign,
            state: fastest,
            step: found.step,
            reference_speed: found.reference_speed,
        })
    }

    /// Takes a look at all cells.
    pub fn add_whole(&mut self, found: &Found) -> Option<Alarm> {
        self.next_whole = found.step + WHOLE_INTERVAL;
        // Around the markers all is well, and rare looks know little of what is elsewhere: a cell that is too fast now says more.
        let too_fast = |state: CellState| state.speed >= SPEED_LIMIT;
        let is_known = found.extremes.fastest.is_some_and(too_fast);
        let before = self.whole.as_ref().filter(|_| !is_known);
        let alarm = beyond_limits(found, before);
        self.whole = found.extremes.fastest.map(|fastest| found.look(fastest));
        alarm
    }

    /// How the last looks grew, if too much.
    fn growth(&self) -> Option<Sign> {
        let last = self.near.last()?;
        if let [.., a, b, c] = &self.near[..] {
            let grew = [
                b.fastest.speed / a.fastest.speed,
                c.fastest.speed / b.fastest.speed,
            ];
            if last.speed_ratio() > FAST && grew.iter().all(|factor| *factor > SPEED_GROWTH) {
                return Some(Sign::SpeedGrows(grew));
            }
        }
        let slips: Vec<f64> = self
            .near
            .iter()
            .filter_map(|look| look.slip_ratio)
            .collect();
        if let [a, b, c, d] = slips[..] {
            let grew = [b / a, c / b, d / c];
            let large = a > SLIPS[0] && d > SLIPS[1];
            if large && grew.iter().all(|factor| *factor > SLIP_GROWTH) {
                return Some(Sign::SlipGrows(grew));
            }
        }
        None
    }
}

/// A cell that no flow may have, whatever was before. Where cells are no longer finite, the cell to blame is the fastest one of the look
/// `before`: what is not finite spreads by a cell per step in all directions, and what is next to it is fast, too.
fn beyond_limits(found: &Found, before: Option<&Look>) -> Option<Alarm> {
    let Extremes { fastest, farthest } = found.extremes;
    let alarm = |sign, state| Alarm {
        sign,
        state,
        step: found.step,
        reference_speed: found.reference_speed,
    };
    if !farthest.is_finite() {
        let now = alarm(Sign::NotFinite, fastest.unwrap_or(farthest));
        return Some(before.map_or(now, |look| Alarm {
            sign: Sign::NotFinite,
            state: look.fastest,
            step: look.step,
            reference_speed: look.reference_speed,
        }));
    }
    let fastest = fastest?;
    if fastest.speed >= SPEED_LIMIT {
        return Some(alarm(Sign::TooFast, fastest));
    }
    if !farthest.is_sound(SPEED_LIMIT) {
        return Some(alarm(Sign::Density, farthest));
    }
    let limit = REFERENCE_SPEEDS * found.reference_speed;
    if found.released && limit > 0.0 && fastest.speed > limit {
        return Some(alarm(Sign::ManyReferenceSpeeds, fastest));
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;

    const REFERENCE: f64 = 0.1;

    fn state(x: usize, speed: f64) -> CellState {
        CellState {
            cell: [x, 7, 8],
            density_excess: 0.01,
            speed,
        }
    }

    /// A look after `step` whose fastest cell [step, 7, 8] moves at so many reference speeds.
    fn found(step: u64, speed_ratio: f64, slip_ratio: Option<f64>) -> Found {
        let fastest = state(step as usize, speed_ratio * REFERENCE);
        Found {
            step,
            time_s: step as f64,
            extremes: Extremes {
                fastest: Some(fastest),
                farthest: fastest,
            },
            reference_speed: REFERENCE,
            slip_ratio,
            released: true,
            settled: true,
        }
    }

    /// The first alarm of a history, and the number of its look.
    fn first_alarm(looks: impl Iterator<Item = Found>) -> Option<(usize, Alarm)> {
        let mut watch = Watch::default();
        looks
            .enumerate()
            .find_map(|(i, found)| Some((i, watch.add_near(&found, 10)?)))
    }

    fn of_speeds(ratios: &[f64]) -> Option<(usize, Alarm)> {
        let looks = ratios.iter().enumerate();
        first_alarm(looks.map(|(i, ratio)| found(10 * i as u64, *ratio, None)))
    }

    fn of_slips(ratios: &[f64]) -> Option<(usize, Alarm)> {
        let looks = ratios.iter().enumerate();
        first_alarm(looks.map(|(i, ratio)| found(10 * i as u64, 1.4, Some(*ratio))))
    }

    #[test]
    fn a_speed_that_grows_twice_is_noticed() {
        let (look, alarm) = of_speeds(&[1.4, 1.4, 1.45, 2.3, 3.6]).unwrap();
        assert_eq!((look, alarm.state.cell), (4, [40, 7, 8]));
        assert!(matches!(alarm.sign, Sign::SpeedGrows([a, b]) if a > 1.5 && b > 1.5));
        // Once is a gust; slow air may do as it likes; a slow rise is none.
        for quiet in [
            &[1.4, 1.4, 2.6, 2.7, 2.6][..],
            &[0.1, 0.3, 0.9, 2.0, 2.4],
            &[1.4, 1.9, 2.6, 3.5],
            &[1.4, 2.6, 1.6, 2.6, 1.6],
        ] {
            assert_eq!(of_speeds(quiet), None, "{quiet:?}");
        }
    }

    #[test]
    fn slip_that_grows_exponentially_is_noticed() {
        let (look, alarm) = of_slips(&[0.03, 0.03, 0.04, 0.09, 0.19, 0.4]).unwrap();
        assert_eq!(look, 5);
        assert!(matches!(alarm.sign, Sign::SlipGrows(_)), "{alarm:?}");
        for quiet in [
            // Set in motion from rest.
            &[0.0, 0.001, 0.01, 0.1, 0.3, 0.3][..],
            &[0.03, 0.05, 0.085, 0.145, 0.25, 0.4],
            &[0.021, 0.045, 0.095, 0.195, 0.15],
            &[0.3, 0.3, 0.5, 0.3],
        ] {
            assert_eq!(of_slips(quiet), None, "{quiet:?}");
        }
    }

    #[test]
    fn growth_counts_once_the_flow_has_settled() {
        let unsettled = |i: u64, ratio: f64| Found {
            settled: false,
            ..found(10 * i, ratio, Some(ratio * 0.1))
        };
        let ratios = [0.3, 0.7, 1.5, 3.5, 3.6];
        let looks = (0..).zip(ratios);
        assert_eq!(first_alarm(looks.map(|(i, r)| unsettled(i, r))), None);
        assert!(of_speeds(&ratios).is_some());
    }

    #[test]
    fn limits_hold_without_a_history() {
        let sign = |found: Found| first_alarm([found].into_iter()).map(|(_, alarm)| alarm.sign);
        assert_eq!(sign(found(10, 3.9, None)), None);
        assert_eq!(sign(found(10, 4.1, None)), Some(Sign::TooFast));
        let slow = Found {
            reference_speed: 0.02,
            ..found(10, 1.3, None)
        };
        assert_eq!(sign(slow), Some(Sign::ManyReferenceSpeeds));
        // Not while the wind rises, nor without a reference.
        for quiet in [
            Found {
                released: false,
                ..slow
            },
            Found {
                reference_speed: 0.0,
                ..slow
            },
        ] {
            assert_eq!(sign(quiet), None);
        }
        let mut thin = found(10, 1.0, None);
        thin.extremes.farthest.density_excess = -0.6;
        assert_eq!(sign(thin), Some(Sign::Density));
    }

    /// Not the first cell that is not finite, which is the first of all once that has spread.
    #[test]
    fn the_fastest_cell_before_is_to_blame() {
        let mut broken = found(30, 3.0, None);
        broken.extremes.farthest = CellState {
            cell: [0; 3],
            density_excess: f64::NAN,
            speed: f64::NAN,
        };
        let looks = [found(10, 1.4, None), found(20, 1.6, None), broken];
        let (look, alarm) = first_alarm(looks.into_iter()).unwrap();
        assert_eq!((look, alarm.sign, alarm.step), (2, Sign::NotFinite, 20));
        assert_eq!(alarm.state.cell, [20, 7, 8]);
        // Without a look before, the fastest that is left; without one, what there is.
        let (_, alarm) = first_alarm([broken].into_iter()).unwrap();
        assert_eq!(alarm.state.cell, [30, 7, 8]);
        broken.extremes.fastest = None;
        let mut watch = Watch::default();
        assert_eq!(watch.add_whole(&broken).unwrap().state.cell, [0; 3]);
        // Far from markers a cell that is too fast now says more than a look long ago.
        for (ratio, blamed) in [(3.0, 10), (4.5, 30)] {
            let mut watch = Watch::default();
            assert_eq!(watch.add_whole(&found(10, 1.4, None)), None);
            broken.extremes.fastest = Some(state(30, ratio * REFERENCE));
            let alarm = watch.add_whole(&broken).unwrap();
            assert_eq!(alarm.state.cell[0], blamed);
        }
    }

    #[test]
    fn looks_are_as_frequent_as_they_are_cheap() {
        // 16 cells at 0.15 cells per step, in a box of one per cent of the air.
        assert_eq!(steps_between(16.0, 0.15, 0.01, false), 11);
        assert_eq!(steps_between(8.0, 0.1, 0.01, false), 10);
        assert_eq!(steps_between(8.0, 0.1, 0.01, true), 64);
        assert_eq!(steps_between(8.0, 0.1, 0.6, false), 77);
        assert_eq!(steps_between(64.0, 0.08, 0.1, true), 80);
        let mut watch = Watch::default();
        assert!(watch.is_due(1) && watch.whole_is_due(1));
        assert_eq!(watch.add_near(&found(1, 1.0, None), 11), None);
        assert_eq!(watch.add_whole(&found(1, 1.0, None)), None);
        assert!(!watch.is_due(11) && watch.is_due(12));
        assert!(!watch.whole_is_due(128) && watch.whole_is_due(129));
        watch.no_markers();
        assert!(!watch.is_due(128) && watch.is_due(129));
    }
}
