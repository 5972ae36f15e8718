//! A lattice with boxes of finer cells in it, which may hold further ones.
//!
//! All follows from the steps of the finest lattice of the first boxes: two of its steps, then one of the lattice around it, then both exchange
//! what they know of each other ([`crate::lattice::nest`]); and so on outwards. After the exchange both stand at one time, and every cell is whole;
//! in between, shells are spoilt.

use super::air::{AirEngine, apart};
use super::markers::MarkerEngine;
use crate::cpu::fluid::transfer;
use crate::gpu::DeviceError;
use crate::gpu::fluid::transfer as on_device;
use crate::lattice::nest::Nest;

/// A lattice and the boxes in it.
#[derive(Debug)]
pub struct Levels {
    engine: AirEngine,
    /// All that acts on the air lies in the first.
    boxes: Vec<(Tie, Self)>,
    /// Uniform acceleration of the steps of the first box since this lattice's last.
    gained: Option<[f64; 3]>,
}

/// What ties a box to the lattice around it, on the engine of both.
#[derive(Debug)]
enum Tie {
    CpuF32(transfer::Tie<f32>),
    CpuF64(transfer::Tie<f64>),
    Gpu(Box<on_device::Tie>),
}

impl Tie {
    fn new(nest: Nest, coarse: &AirEngine, fine: &AirEngine) -> Result<Self, DeviceError> {
        match (coarse, fine) {
            (AirEngine::CpuF32(_), AirEngine::CpuF32(_)) => {
                Ok(Self::CpuF32(transfer::Tie::new(nest)))
            }
            (AirEngine::CpuF64(_), AirEngine::CpuF64(_)) => {
                Ok(Self::CpuF64(transfer::Tie::new(nest)))
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
    /// A lattice without boxes.
    #[must_use]
    pub const fn new(engine: AirEngine) -> Self {
        Self {
            engine,
            boxes: Vec::new(),
            gained: None,
        }
    }

    /// The same with a box of finer cells on the same engine. An error if it does not fit ([`Nest::fits`]), if its set-up is not that of half the
    /// cells' size (τ − ½ twice as large, operator and eddy viscosity alike), or if the eddy viscosity has a stage of its own.
    pub fn with(mut self, nest: Nest, mut inner: Self) -> Result<Self, DeviceError> {
        let (coarse, fine) = (self.engine.setup(), inner.engine.setup());
        let viscous = [coarse, fine].map(|setup| setup.relaxation_time - 0.5);
        let alike = coarse.operator == fine.operator
            && coarse.eddy_viscosity == fine.eddy_viscosity
            && (viscous[1] - 2.0 * viscous[0]).abs() <= 1e-9 * viscous[1]
            && nest.fine_cells() == fine.cells;
        let held = (coarse.eddy_viscosity).is_some_and(|model| model.gradient_model().is_some());
        if !alike || held || !nest.fits(coarse.cells) {
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

    /// One step of the finest lattice, under a uniform acceleration [cells per step²] and the forces of the markers, and of those around it what is
    /// due. True if this one has made a step, too: then all of its boxes stand at its time.
    pub fn collide_stream(
        &mut self,
        acceleration: Option<[f64; 3]>,
        markers: Option<&MarkerEngine>,
    ) -> Result<bool, DeviceError> {
        let mut boxes = self.boxes.iter_mut();
        let Some((_, first)) = boxes.next() else {
            self.engine.collide_stream(acceleration, markers)?;
            return Ok(true);
        };
        let stepped = first.collide_stream(acceleration, markers)?;
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
        Ok(true)
    }

    /// A step of this lattice, and all steps in its boxes, under an acceleration per own step.
    pub fn whole_step(&mut self, acceleration: Option<[f64; 3]>) -> Result<(), DeviceError> {
        let times = 2f64.powi(self.depth());
        let finest = acceleration.map(|a| a.map(|a| a / times));
        while !self.collide_stream(finest, None)? {}
        Ok(())
    }

    /// Levels of the first boxes below this one.
    fn depth(&self) -> i32 {
        self.boxes.first().map_or(0, |(_, inner)| 1 + inner.depth())
    }
}
