//! Account of the fabric's solves: how many reached their tolerance, how far the others are from it, and whether that may be taken for a
//! result.

use std::collections::VecDeque;
use std::io;

use crate::checkpoint::{CheckpointError, Reader, Writer};
use crate::solve::lbfgs::{Outcome, Stop};

/// Solves of a window: in none of this length may more than [`UNSOLVED_SHARE`] miss their tolerance. Shorter runs are one window.
const WINDOW: u64 = 1000;

/// Share of a window that may miss its tolerance.
pub const UNSOLVED_SHARE: f64 = 0.01;

/// Solves at the end of a run of which none may miss its tolerance.
pub const LAST: u64 = 10;

const SECTION: &str = "solver_account";
const UNSOLVED_SECTION: &str = "solver_account_unsolved";

/// A solve that missed its tolerance.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Unsolved {
    /// Energy norm of what was left, over that allowed by the tolerance.
    pub residual: f64,
    /// End of its step [s].
    pub time_s: f64,
}

/// Solves since the last sample.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Interval {
    /// All.
    pub solves: u64,
    /// Those that missed their tolerance.
    pub unsolved: u64,
    /// Evaluations of the objective.
    pub evaluations: u64,
    /// Largest energy norm left, over that allowed: at most 1 if all reached their tolerance. NaN without solves.
    pub worst_residual: f64,
}

/// Counts of solves by how they ended, from the start of the run; resumed runs go on counting.
#[derive(Debug, Clone, Default)]
pub struct SolverAccount {
    solves: u64,
    evaluations: u64,
    round_off: u64,
    limit: u64,
    stalled: u64,
    worst: Option<Unsolved>,
    /// Numbers of the unsolved among the last [`WINDOW`] solves, ascending.
    recent: VecDeque<u64>,
    /// Most unsolved solves of any window so far.
    most: u64,
    interval: Interval,
    /// The last solve, which may yet be taken back and done again.
    held: Option<Outcome>,
}

impl SolverAccount {
    /// Notes how a solve ended; it counts once [`SolverAccount::settle`] is called, unless another takes its place before.
    pub(super) const fn hold(&mut self, outcome: &Outcome) {
        self.held = Some(*outcome);
    }

    /// Counts the solve that was noted last.
    pub(super) fn settle(&mut self, tolerance: f64, time_s: f64) {
        let Some(outcome) = self.held.take() else {
            return;
        };
        self.solves += 1;
        self.evaluations += outcome.evaluations as u64;
        let residual = outcome.relative_norm / tolerance;
        // Where positions or round-off end a solve, there may be nothing that the norm is relative to.
        let residual = if outcome.stop.reached() {
            residual.min(1.0)
        } else {
            residual
        };
        let interval = &mut self.interval;
        interval.worst_residual = if interval.solves == 0 {
            residual
        } else {
            interval.worst_residual.max(residual)
        };
        interval.solves += 1;
        interval.evaluations += outcome.evaluations as u64;
        self.recent
            .pop_front_if(|number| *number + WINDOW <= self.solves);
        match outcome.stop {
            Stop::Converged => return,
            Stop::RoundOff => {
                self.round_off += 1;
                return;
            }
            Stop::LimitReached => self.limit += 1,
            Stop::Stalled | Stop::Indefinite | Stop::NotFinite | Stop::Interrupted => {
                self.stalled += 1;
            }
        }
        self.interval.unsolved += 1;
        self.recent.push_back(self.solves);
        self.most = self.most.max(self.recent.len() as u64);
        if self.worst.is_none_or(|worst| residual > worst.residual) {
            self.worst = Some(Unsolved { residual, time_s });
        }
    }

    /// What happened since the last call.
    pub fn take_interval(&mut self) -> Interval {
        let interval = std::mem::take(&mut self.interval);
        if interval.solves > 0 {
            interval
        } else {
            Interval {
                worst_residual: f64::NAN,
                ..interval
            }
        }
    }

    /// Solves.
    #[must_use]
    pub const fn solves(&self) -> u64 {
        self.solves
    }

    /// Evaluations of the objective in them.
    #[must_use]
    pub const fn evaluations(&self) -> u64 {
        self.evaluations
    }

    /// Solves that ended where round-off hides what is left.
    #[must_use]
    pub const fn round_off(&self) -> u64 {
        self.round_off
    }

    /// Solves that ended at the limit of evaluations.
    #[must_use]
    pub const fn limit_reached(&self) -> u64 {
        self.limit
    }

    /// Solves that found no way down before they reached their tolerance.
    #[must_use]
    pub const fn stalled(&self) -> u64 {
        self.stalled
    }

    /// Solves that missed their tolerance.
    #[must_use]
    pub const fn unsolved(&self) -> u64 {
        self.limit + self.stalled
    }

    /// The one farthest from its tolerance.
    #[must_use]
    pub const fn worst(&self) -> Option<Unsolved> {
        self.worst
    }

    /// Largest share of unsolved solves in any window of 1000, or in the whole of a shorter run.
    #[must_use]
    pub fn worst_share(&self) -> f64 {
        if self.solves == 0 {
            0.0
        } else {
            self.most as f64 / self.solves.min(WINDOW) as f64
        }
    }

    /// Unsolved solves among the last ten.
    #[must_use]
    pub fn unsolved_at_end(&self) -> u64 {
        let recent = self.recent.iter();
        recent
            .filter(|number| **number + LAST > self.solves)
            .count() as u64
    }

    /// True if so many solves missed their tolerance that the run's numbers are not those of its equations.
    #[must_use]
    pub fn out_of_balance(&self) -> bool {
        self.worst_share() > UNSOLVED_SHARE || self.unsolved_at_end() > 0
    }

    pub(super) fn save(&self, out: &mut Writer) -> io::Result<()> {
        let worst = self.worst.unwrap_or(Unsolved {
            residual: f64::NAN,
            time_s: f64::NAN,
        });
        let interval = &self.interval;
        out.put(
            SECTION,
            &[
                self.solves,
                self.evaluations,
                self.round_off,
                self.limit,
                self.stalled,
                self.most,
                interval.solves,
                interval.unsolved,
                interval.evaluations,
                interval.worst_residual.to_bits(),
                worst.residual.to_bits(),
                worst.time_s.to_bits(),
            ],
        )?;
        let recent: Vec<u64> = self.recent.iter().copied().collect();
        out.put(UNSOLVED_SECTION, &recent)
    }

    pub(super) fn restore(from: &Reader) -> Result<Self, CheckpointError> {
        let stored: Vec<u64> = from.take_exactly(SECTION, 12)?;
        let recent: Vec<u64> = from.take(UNSOLVED_SECTION)?;
        let ascending = recent.is_sorted() && recent.len() as u64 <= WINDOW;
        if !ascending || recent.last().is_some_and(|last| *last > stored[0]) {
            return Err(from.damaged("the account of solves is out of order".to_owned()));
        }
        let residual = f64::from_bits(stored[10]);
        Ok(Self {
            solves: stored[0],
            evaluations: stored[1],
            round_off: stored[2],
            limit: stored[3],
            stalled: stored[4],
            most: stored[5],
            interval: Interval {
                solves: stored[6],
                unsolved: stored[7],
                evaluations: stored[8],
                worst_residual: f64::from_bits(stored[9]),
            },
            worst: (!residual.is_nan()).then(|| Unsolved {
                residual,
                time_s: f64::from_bits(stored[11]),
            }),
            recent: recent.into(),
            held: None,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn outcome(stop: Stop) -> Outcome {
        Outcome {
            stop,
            iterations: 1,
            evaluations: 2,
            energy_norm: 0.0,
            relative_norm: if stop == Stop::Converged { 0.005 } else { 0.05 },
            objective: 0.0,
        }
    }

    fn account(of: impl Iterator<Item = Stop>) -> SolverAccount {
        let mut account = SolverAccount::default();
        for (number, stop) in of.enumerate() {
            account.hold(&outcome(stop));
            account.settle(0.01, number as f64);
        }
        account
    }

    /// `count` solves, of which those that `fails` names reach the limit.
    fn with(count: u64, fails: impl Fn(u64) -> bool) -> SolverAccount {
        account((0..count).map(|n| {
            if fails(n) {
                Stop::LimitReached
            } else {
                Stop::Converged
            }
        }))
    }

    #[test]
    fn one_per_cent_of_a_window_may_miss_its_tolerance() {
        assert!(!with(5000, |_| false).out_of_balance());
        // Ten in a row, in a long run and in one of 1000 solves.
        assert!(!with(5000, |n| (2000..2010).contains(&n)).out_of_balance());
        assert!(!with(1000, |n| (300..310).contains(&n)).out_of_balance());
        assert!(with(5000, |n| (2000..2011).contains(&n)).out_of_balance());
        // Ten here and one 995 later lie in one window; 1000 later they do not.
        assert!(with(5000, |n| (2000..2010).contains(&n) || n == 2995).out_of_balance());
        assert!(!with(5000, |n| (2000..2010).contains(&n) || n == 3001).out_of_balance());
        // Two of 150 are more than a hundredth.
        assert!(with(150, |n| n == 3 || n == 70).out_of_balance());
    }

    #[test]
    fn the_end_must_be_solved() {
        assert!(with(5000, |n| n == 4990).out_of_balance());
        assert!(!with(5000, |n| n == 4989).out_of_balance());
    }

    #[test]
    fn the_worst_and_its_time_are_kept() {
        let account = with(500, |n| n == 7);
        let worst = account.worst().unwrap();
        assert!((worst.residual - 5.0).abs() < 1e-12 && worst.time_s == 7.0);
        assert_eq!((account.limit_reached(), account.unsolved()), (1, 1));
        assert_eq!(account.evaluations(), 1000);
    }

    #[test]
    fn a_solve_that_is_done_again_counts_once() {
        let mut account = SolverAccount::default();
        account.hold(&outcome(Stop::LimitReached));
        account.hold(&outcome(Stop::Converged));
        account.settle(0.01, 1.0);
        account.settle(0.01, 1.0);
        assert_eq!((account.solves(), account.unsolved()), (1, 0));
        let interval = account.take_interval();
        assert_eq!((interval.solves, interval.unsolved), (1, 0));
        assert!(account.take_interval().worst_residual.is_nan());
    }

    /// What round-off hides is solved as far as numbers go.
    #[test]
    fn round_off_is_no_failure() {
        let account = account((0..200).map(|_| Stop::RoundOff));
        assert_eq!((account.round_off(), account.unsolved()), (200, 0));
        assert!(!account.out_of_balance());
    }
}
