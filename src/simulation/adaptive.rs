//! Implicit steps of fabric alone that choose their own length.
//!
//! A step of the run, `time.step_s`, is the largest; it is halved as often as needed, and every part is a whole solve. What a part errs by, e, is told
//! by how far its positions are from those of the trapezoidal rule ([`crate::cpu::cloth::integration::error_over_difference`]; the leading term of
//! the local error; Hairer, Nørsett & Wanner, "Solving Ordinary Differential Equations I", II.4), as root mean square over the mass of the
//! nodes that can move. A part that errs more than `tolerance_m`, or that the minimiser cannot solve, is done again in halves. Once a part would
//! still be good enough at twice its length, the next is twice as long, where it begins at a multiple of that. So a run goes through
//! the same instants as with fixed steps, and what is written at these is written so, too.
//!
//! The tolerance is one of a part, not of its share of the run ("error per step", not "per unit step"): where fabric snaps taut, velocities jump, and
//! |vⁿ⁺¹ − vⁿ| does not fall with dt, but e does. Errors of smooth motion add up to T e/dt in the time T: by backward Euler, whose e goes with dt², a quarter of
//! the tolerance halves them, by BDF2, whose e goes with dt³, some three tenths.

use std::io;

use crate::case::Scene;
use crate::case::scene::AdaptiveStep;
use crate::checkpoint::{CheckpointError, Reader, Writer};
use crate::cloth::TimeIntegration;
use crate::plan::multigrid_from_s;
use crate::solve::InitialHessian;
use crate::solve::lbfgs::Stop;

/// Share of the tolerance that a part of twice the length may come to, by what smooth motion errs by.
const LENGTHEN_UP_TO: f64 = 0.8;

/// Parts after one that the minimiser could not solve before a longer one is tried.
const PARTS_AFTER_FAILURE: u64 = 16;

/// Name of the section in a checkpoint.
const SECTION: &str = "adaptive";

/// How parts of a step are chosen, and what came of it.
#[derive(Debug, Clone, Copy)]
pub struct Adaptive {
    pub(super) settings: AdaptiveStep,
    /// Power of the length that errors of smooth motion go with.
    power: f64,
    /// Length of a part from which multigrid is faster than block-Jacobi [s].
    multigrid_from_s: f64,
    /// How often a step is halved now.
    pub(super) halvings: u32,
    /// Parts to go until a longer one may be tried.
    patience: u64,
    parts: u64,
    refused: u64,
    failed: u64,
    coarse: u64,
    pub(super) most_halvings: u32,
}

/// What becomes of a part.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Verdict {
    Accepted,
    /// Accepted, and the next may be twice as long.
    Lengthened,
    /// To be done again, in parts halved so many times more.
    Refused(u32),
}

impl Adaptive {
    /// Of a scene; `None` where every step is one solve.
    pub(super) fn of(scene: &Scene) -> Option<Self> {
        let time = scene.time.filter(|_| scene.body.is_some())?;
        let settings = time.adaptive?;
        let power = match time.integration {
            TimeIntegration::BackwardEuler => 2.0,
            TimeIntegration::Bdf2 => 3.0,
        };
        let multigrid_from_s = multigrid_from_s(scene);
        Some(Self::new(settings, power, multigrid_from_s))
    }

    const fn new(settings: AdaptiveStep, power: f64, multigrid_from_s: f64) -> Self {
        Self {
            settings,
            power,
            multigrid_from_s,
            halvings: 0,
            patience: 0,
            parts: 0,
            refused: 0,
            failed: 0,
            coarse: 0,
            most_halvings: 0,
        }
    }

    /// Counts parts from here on; how they are chosen stays.
    pub(super) const fn count_anew(&mut self) {
        (self.parts, self.refused, self.failed) = (0, 0, 0);
        (self.coarse, self.most_halvings) = (0, self.halvings);
    }

    /// Parts that steps have been divided into so far.
    #[must_use]
    pub const fn parts(&self) -> u64 {
        self.parts
    }

    /// Parts that were done again in halves, those that could not be solved included.
    #[must_use]
    pub const fn refused(&self) -> u64 {
        self.refused
    }

    /// Parts that were done again since the minimiser could not solve them.
    #[must_use]
    pub const fn failed(&self) -> u64 {
        self.failed
    }

    /// Parts of the smallest length that err more than they may.
    #[must_use]
    pub const fn coarse(&self) -> u64 {
        self.coarse
    }

    /// How often a step has been halved at most.
    #[must_use]
    pub const fn most_halvings(&self) -> u32 {
        self.most_halvings
    }

    /// What a part is solved from.
    pub(super) fn initial_hessian(&self, part_s: f64) -> InitialHessian {
        if part_s < self.multigrid_from_s {
            InitialHessian::BlockJacobi
        } else {
            InitialHessian::Multigrid
        }
    }

    /// Judges a part by what the minimiser says of it and by the error of positions [m].
    pub(super) fn judge(&mut self, stop: Stop, error_m: f64) -> Verdict {
        let left = self.settings.halvings - self.halvings;
        if !stop.reached() && left > 0 {
            self.refused += 1;
            self.failed += 1;
            self.patience = PARTS_AFTER_FAILURE;
            return Verdict::Refused(1);
        }
        let share = error_m / self.settings.tolerance_m;
        if share > 1.0 && left > 0 {
            self.refused += 1;
            let halvings = share.log2() / self.power;
            let halvings = halvings.ceil().clamp(1.0, f64::from(left));
            return Verdict::Refused(halvings as u32);
        }
        self.parts += 1;
        self.coarse += u64::from(share > 1.0);
        self.patience = self.patience.saturating_sub(1);
        if share * self.power.exp2() < LENGTHEN_UP_TO && self.patience == 0 {
            Verdict::Lengthened
        } else {
            Verdict::Accepted
        }
    }

    pub(super) fn save(&self, out: &mut Writer) -> io::Result<()> {
        out.put(
            SECTION,
            &[
                u64::from(self.halvings),
                self.patience,
                self.parts,
                self.refused,
                self.failed,
                self.coarse,
                u64::from(self.most_halvings),
            ],
        )
    }

    pub(super) fn restore(&mut self, from: &Reader) -> Result<(), CheckpointError> {
        let stored: Vec<u64> = from.take_exactly(SECTION, 7)?;
        let halvings = |number: u64| {
            u32::try_from(number)
                .ok()
                .filter(|halvings| *halvings <= self.settings.halvings)
                .ok_or_else(|| from.damaged("the parts of steps are out of range".to_owned()))
        };
        let (now, most) = (halvings(stored[0])?, halvings(stored[6])?);
        (self.halvings, self.most_halvings) = (now, most);
        [self.patience, self.parts, self.refused, self.failed] =
            [stored[1], stored[2], stored[3], stored[4]];
        self.coarse = stored[5];
        Ok(())
    }
}
