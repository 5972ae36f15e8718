//! A lattice with boxes of finer cells in it, which may hold further ones.
//!
//! All follows from the steps of the finest lattice of the first boxes: two of its steps, then one of the lattice around it, then both exchange
//! what they know of each other ([`crate::lattice::nest`]); and so on outwards. After the exchange both stand at one time, and every cell is whole;
//! in between, shells are spoilt.

use std::sync::Arc;

use super::air::{AirEngine, State, apart, inner_setup, setup};
use super::markers::MarkerEngine;
use crate::case::scene::Air;
use crate::cpu::fluid::transfer;
use crate::gpu::fluid::transfer as on_device;
use crate::gpu::{Device, DeviceError};
use crate::lattice::grid::Setup;
use crate::lattice::nest::{IdleCells, Level, Nest, Refinement};
use crate::plan::Plan;

/// A lattice and the boxes in it.
#[derive(Debug)]
pub struct Levels {
    engine: AirEngine,
    /// All that acts on the air lies in the first.
    boxes: Vec<(Tie, Self)>,
    /// Uniform acceleration of the steps of the first box since this lattice's last.
    gained: Option<[f64; 3]>,
    /// Boxes have made steps that this lattice has not.
    in_between: bool,
}

/// What ties a box to the lattice around it, on the engine of both.
#[derive(Debug)]
enum Tie {
    /// Of populations in 16 bits, too: arithmetic is in single precision.
    CpuF32(transfer::Tie<f32>),
    CpuF64(transfer::Tie<f64>),
    Gpu(Box<on_device::Tie>),
}

impl Tie {
    fn new(nest: Nest, coarse: &AirEngine, fine: &AirEngine) -> Result<Self, DeviceError> {
        match (coarse, fine) {
            (AirEngine::CpuF32(coarse), AirEngine::CpuF32(_)) => {
                Ok(Self::CpuF32(transfer::Tie::new(nest, coarse)))
            }
            (AirEngine::CpuF16(coarse), AirEngine::CpuF16(_)) => {
                Ok(Self::CpuF32(transfer::Tie::new(nest, coarse)))
            }
            (AirEngine::CpuF64(coarse), AirEngine::CpuF64(_)) => {
                Ok(Self::CpuF64(transfer::Tie::new(nest, coarse)))
            }
            (AirEngine::Gpu(coarse), AirEngine::Gpu(fine)) => Ok(Self::Gpu(Box::new(
                on_device::Tie::new(coarse, fine, nest)?,
            ))),
            _ => Err(apart()),
        }
    }

    const fn nest(&self) -> &Nest {
        match self {
            Self::CpuF32(tie) => tie.nest(),
            Self::CpuF64(tie) => tie.nest(),
            Self::Gpu(tie) => tie.nest(),
        }
    }

    /// Both lattices stand at one time.
    fn exchange(
        &mut self,
        coarse: &mut AirEngine,
        fine: &mut AirEngine,
    ) -> Result<(), DeviceError> {
        match (self, coarse, fine) {
            (Self::CpuF32(tie), AirEngine::CpuF32(coarse), AirEngine::CpuF32(fine)) => {
                tie.exchange(coarse, fine);
                Ok(())
            }
            (Self::CpuF32(tie), AirEngine::CpuF16(coarse), AirEngine::CpuF16(fine)) => {
                tie.exchange(coarse, fine);
                Ok(())
            }
            (Self::CpuF64(tie), AirEngine::CpuF64(coarse), AirEngine::CpuF64(fine)) => {
                tie.exchange(coarse, fine);
                Ok(())
            }
            (Self::Gpu(tie), AirEngine::Gpu(coarse), AirEngine::Gpu(fine)) => {
                tie.exchange(coarse, fine)
            }
            _ => Err(apart()),
        }
    }
}

impl Levels {
    /// The air of a scene at its initial state, or in a `state` of every cell.
    pub(super) fn of_air(
        air: &Air,
        plan: &Plan,
        device: Option<&Arc<Device>>,
        state: Option<&State<'_>>,
    ) -> Result<Self, DeviceError> {
        let mut levels = air.levels().into_iter();
        let outermost = setup(air, plan);
        let mut build = |level: &Level, boxes: &[Refinement]| {
            let own = match level.depth {
                0 => outermost.clone(),
                _ => inner_setup(&outermost, air, level),
            };
            let own = Setup {
                idle: IdleCells::below(boxes, own.eddy_viscosity),
                ..own
            };
            AirEngine::of_level(air, (level, own), plan, device, state)
        };
        Self::from_tree(&mut levels, &air.boxes, &mut build)
    }

    /// A lattice with `boxes`, each with its own level of the list.
    fn from_tree(
        levels: &mut impl Iterator<Item = Level>,
        boxes: &[Refinement],
        build: &mut impl FnMut(&Level, &[Refinement]) -> Result<AirEngine, DeviceError>,
    ) -> Result<Self, DeviceError> {
        let missing = || DeviceError::Command("a box of finer cells has no lattice".to_owned());
        let mut found = Self::new(build(&levels.next().ok_or_else(missing)?, boxes)?);
        for Refinement { nest, inner } in boxes {
            found = found.with(*nest, Self::from_tree(levels, inner, build)?)?;
        }
        Ok(found)
    }

    /// A lattice without boxes.
    #[must_use]
    pub const fn new(engine: AirEngine) -> Self {
        Self {
            engine,
            boxes: Vec::new(),
            gained: None,
            in_between: false,
        }
    }

    /// The same with a box of finer cells on the same engine. An error if it does not fit ([`Nest::fits`]), if its set-up is not that of half the
    /// cells' size (τ − ½ twice as large, operator and eddy viscosity alike).
    pub fn with(mut self, nest: Nest, mut inner: Self) -> Result<Self, DeviceError> {
        /// Of a relaxation time near ½, and of twice another: with thin air and short steps τ − ½ itself is 1e-8.
        const ROUND_OFF: f64 = 4.0 * f64::EPSILON;
        let (coarse, fine) = (self.engine.setup(), inner.engine.setup());
        let viscous = [coarse, fine].map(|setup| setup.relaxation_time - 0.5);
        let alike = coarse.operator == fine.operator
            && coarse.eddy_viscosity == fine.eddy_viscosity
            && (viscous[1] - 2.0 * viscous[0]).abs() <= 1e-9 * viscous[1] + ROUND_OFF
            && nest.fine_cells() == fine.cells;
        if !alike || !nest.fits(coarse.cells) {
            return Err(DeviceError::Command(format!(
                "a box of {:?} cells at {:?} is no level of a lattice of {:?}",
                fine.cells, nest.first, coarse.cells
            )));
        }
        let mut tie = Tie::new(nest, &self.engine, &inner.engine)?;
        tie.exchange(&mut self.engine, &mut inner.engine)?;
        self.boxes.push((tie, inner));
        Ok(self)
    }

    /// The lattice itself.
    #[must_use]
    pub const fn engine(&self) -> &AirEngine {
        &self.engine
    }

    /// Does something with every lattice, in the order of [`Levels::engines`].
    pub(super) fn each_engine<E>(
        &mut self,
        number: &mut usize,
        act: &mut impl FnMut(usize, &mut AirEngine) -> Result<(), E>,
    ) -> Result<(), E> {
        act(*number, &mut self.engine)?;
        *number += 1;
        for (_, inner) in &mut self.boxes {
            inner.each_engine(number, act)?;
        }
        Ok(())
    }

    /// Boxes, and what is in them.
    pub fn boxes(&self) -> impl Iterator<Item = (&Nest, &Self)> {
        self.boxes.iter().map(|(tie, inner)| (tie.nest(), inner))
    }

    /// The finest lattice of the first boxes.
    #[must_use]
    pub fn finest(&self) -> &AirEngine {
        self.boxes
            .first()
            .map_or(&self.engine, |(_, inner)| inner.finest())
    }

    /// The same, to be stepped or read anew.
    pub fn finest_mut(&mut self) -> &mut AirEngine {
        match self.boxes.first_mut() {
            Some((_, inner)) => inner.finest_mut(),
            None => &mut self.engine,
        }
    }

    /// The lattice itself, whose faces are those of the air.
    pub const fn engine_mut(&mut self) -> &mut AirEngine {
        &mut self.engine
    }

    /// Cell updates of a step of this lattice and all in its boxes.
    #[must_use]
    pub fn updates(&self) -> usize {
        let inner: usize = self
            .boxes
            .iter()
            .map(|(_, inner)| 2 * inner.updates())
            .sum();
        self.engine.grid().cell_count() + inner
    }

    /// Stage `collide_stream`: one step of the finest lattice of the first boxes, under a uniform acceleration [cells per step²] and the forces of
    /// the markers. [`Levels::coarser_levels`] is to follow.
    pub fn collide_stream(
        &mut self,
        acceleration: Option<[f64; 3]>,
        markers: Option<&MarkerEngine>,
    ) -> Result<(), DeviceError> {
        let finest = self.finest_mut();
        let was_ahead = finest.is_ahead();
        finest.collide_stream(acceleration, markers)?;
        if !was_ahead {
            // A device works on it while the host prepares what comes next. Few cells may wait for that.
            finest.submit();
        }
        Ok(())
    }

    /// Stage `collide_ahead`: [`AirEngine::collide_ahead`] of the finest lattice of the first boxes.
    pub fn collide_ahead(
        &mut self,
        markers: Option<&MarkerEngine>,
        awaited: [[i32; 3]; 2],
    ) -> Result<bool, DeviceError> {
        self.finest_mut().collide_ahead(markers, awaited)
    }

    /// Stage `coarser_levels`: of the lattices around the finest one those steps that are due after its last, under the same acceleration. True if
    /// this one stands at the time of all of its boxes now.
    pub fn coarser_levels(&mut self, acceleration: Option<[f64; 3]>) -> Result<bool, DeviceError> {
        let mut boxes = self.boxes.iter_mut();
        let Some((_, first)) = boxes.next() else {
            return Ok(true);
        };
        self.in_between = true;
        let stepped = first.coarser_levels(acceleration)?;
        if let Some(acceleration) = acceleration {
            let gained = self.gained.get_or_insert_default();
            for (sum, a) in gained.iter_mut().zip(acceleration) {
                *sum += a;
            }
        }
        if !stepped || first.engine.is_odd() {
            return Ok(false);
        }
        let gained = self.gained.take();
        for (_, other) in boxes {
            for _ in 0..2 {
                other.whole_step(gained.map(|gained| gained.map(|a| 0.5 * a)))?;
            }
        }
        self.engine.collide_stream(gained, None)?;
        for (tie, inner) in &mut self.boxes {
            tie.exchange(&mut self.engine, &mut inner.engine)?;
        }
        // A device works on it while the host looks for links.
        self.engine.submit();
        self.in_between = false;
        Ok(true)
    }

    /// True if all lattices stand at one time.
    #[must_use]
    pub const fn stand_together(&self) -> bool {
        !self.in_between
    }

    /// A step of this lattice, and all steps in its boxes, under an acceleration per own step.
    pub fn whole_step(&mut self, acceleration: Option<[f64; 3]>) -> Result<(), DeviceError> {
        let times = 2f64.powi(self.depth());
        let finest = acceleration.map(|a| a.map(|a| a / times));
        loop {
            self.collide_stream(finest, None)?;
            if self.coarser_levels(finest)? {
                return Ok(());
            }
        }
    }

    /// Levels of the first boxes below this one.
    fn depth(&self) -> i32 {
        self.boxes.first().map_or(0, |(_, inner)| 1 + inner.depth())
    }
}
