//! Where a device may make steps by itself ([`super::device_alone`]), and when it makes them with the host.

use super::cloth_engine::ClothEngine;
use super::coupled::Coupled;
use crate::case::Scene;
use crate::checkpoint::{CheckpointError, Reader, Writer};
use crate::cpu::cloth::Cloth;
use crate::cpu::cloth::driver::STEP_PATIENCE;
use crate::gpu::DeviceError;
use crate::plan::{Plan, STEPS_OF_A_SERIES};
use crate::solve::lbfgs::Outcome;

/// Most steps of a series: it reaches over no border, which are so many steps apart. Lattices of all levels stand at one time there.
pub(super) const MOST: u64 = STEPS_OF_A_SERIES;

/// Cells that markers have room to move in during a series, and times as fast as they are now they may become for it. So they may always move by a quarter of a cell in a
/// step, in the mean, which is what `ripstop check` allows.
pub(super) const ROOM: u32 = 16;
pub(super) const FASTER: f64 = 2.0;

/// Room that is enough for a whole series; with less a series has fewer steps. So fabric may always move by 3/16 of a cell in a step; the wind usually moves by 0.08.
pub(super) const ENOUGH: u32 = 12;

/// A solve that took so many evaluations or more was hard: from the next border on so many steps are made with the host.
const HARD: usize = STEP_PATIENCE / 5 * 4;
const STEPS_AFTER_HARD: u64 = 2 * MOST;

/// Section of a checkpoint with the steps that are made with the host.
const SECTION: &str = "own_steps_with_host";

/// What a device makes steps of by itself.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(super) enum Kind {
    /// Walls that nobody solves for.
    #[default]
    Walls,
    /// Fabric with markers.
    Markers,
    /// Fabric that cuts links.
    Cuts,
}

/// Where the device may make steps by itself.
#[derive(Debug, Default)]
pub(super) struct OwnSteps {
    /// What it makes them of.
    pub kind: Kind,
    /// Step at which the last series began.
    pub began: u64,
    /// Step up to which it has made them; `None` where all are accounted for.
    pub made: Option<u64>,
    /// Steps that are made with the host after hard solves: the first, and the one behind the last.
    with_host: [u64; 2],
}

impl OwnSteps {
    /// `None` where the device needs the host in every step. A device with markers has to place them at its nodes itself.
    pub(super) fn new(
        (scene, plan): (&Scene, &Plan),
        coupled: Option<&mut Coupled>,
        (engine, cloth): (&mut ClothEngine, Option<&Cloth>),
    ) -> Result<Option<Self>, DeviceError> {
        if !plan.may_make_series(scene) {
            return Ok(None);
        }
        if plan.answers_on_device() {
            return Ok(Some(Self::default()));
        }
        let (follows, kind) = match (coupled, engine.nodes_on_device(), cloth) {
            (Some(Coupled::Kernel(kernel)), Some(nodes), _) => {
                (kernel.follow(nodes)?, Kind::Markers)
            }
            (Some(Coupled::Links(links)), _, Some(cloth)) => {
                (links.follow(cloth, engine)?, Kind::Cuts)
            }
            _ => return Ok(None),
        };
        Ok(follows.then(|| Self {
            kind,
            ..Self::default()
        }))
    }

    /// True if a step is to be made with the host, after a hard solve.
    pub const fn need_host(&self, step: u64) -> bool {
        self.with_host[0] <= step && step < self.with_host[1]
    }

    /// Notes how the solve of a step ended before the next border.
    pub(super) fn note(&mut self, first: u64, outcome: &Outcome) {
        if outcome.stop.reached() && outcome.evaluations < HARD {
            return;
        }
        if first > self.with_host[1] {
            self.with_host[0] = first;
        }
        self.with_host[1] = first + STEPS_AFTER_HARD;
    }

    pub(super) fn save(&self, out: &mut Writer) -> std::io::Result<()> {
        out.put(SECTION, &self.with_host)
    }

    pub(super) fn restore(&mut self, from: &Reader) -> Result<(), CheckpointError> {
        // A run whose device needed its host knows nothing of it.
        if from.has(SECTION) {
            self.with_host
                .copy_from_slice(&from.take_exactly::<u64>(SECTION, 2)?);
        }
        Ok(())
    }

    /// True until all steps that the device has made are accounted for.
    pub(super) const fn are_ahead(&self) -> bool {
        self.made.is_some()
    }
}
