//! What [`crate::solve::newton`] asks of the device: products with the finest matrix of multigrid, its cycle, and trials without it.

use crate::gpu::error::DeviceError;
use crate::solve::Step;
use crate::solve::newton::{Curvature, Trial};

use super::parameters::ClothStage;
use super::points::PointSlot;
use super::slots::{ENERGY, NONE};
use super::vectors::{Slot, Space, incomplete};

impl Space<'_> {
    /// Writes what `record` makes of a vector, and brings back the product of the two.
    fn transformed(
        &mut self,
        [vector, result]: [&Slot; 2],
        record: impl FnOnce(&Self, &mut crate::gpu::commands::Commands) -> Result<(), DeviceError>,
    ) -> Result<f64, DeviceError> {
        let stage = ClothStage {
            direction: NONE,
            ..self.stage
        };
        let rows = [[vector.0, NONE, result.0, NONE]];
        let (_, products) = self.run(stage, &rows, record)?;
        products.first().map(|p| p.plain).ok_or_else(incomplete)
    }
}

impl Curvature for Space<'_> {
    fn multiply(&mut self, vector: &Slot, product: &mut Slot) -> Result<f64, DeviceError> {
        let slots = [vector.0, product.0];
        self.transformed([vector, product], |space, commands| {
            let places = slots.map(|slot| u64::from(slot) * space.workspace.vector_bytes);
            match &space.multigrid {
                Some(hessian) => {
                    hessian
                        .multigrid
                        .multiply(commands, &space.workspace.vectors, places)
                }
                // Not reached: Newton's method drives with multigrid alone.
                None => Err(DeviceError::Command("there is no matrix".to_owned())),
            }
        })
    }

    fn precondition(&mut self, vector: &Slot, result: &mut Slot) -> Result<f64, DeviceError> {
        let slots = [vector.0, result.0];
        self.transformed([vector, result], |space, commands| {
            space.precondition(commands, &[slots])
        })
    }

    fn advance(
        &mut self,
        from: &Step<'_, PointSlot, Slot>,
        point: &mut PointSlot,
        gradient: &mut Slot,
    ) -> Result<Trial, DeviceError> {
        let stage = self.stage_of_trial(from, point, [gradient, from.preconditioned]);
        let rows = [
            [ENERGY, NONE, NONE, NONE],
            [gradient.0, NONE, from.direction.0, NONE],
            [from.gradient.0, NONE, from.direction.0, NONE],
        ];
        let (length, products) = self.run(stage, &rows, |space, commands| {
            space.move_and_evaluate(commands);
            Ok(())
        })?;
        let [energy, along, before] = products[..] else {
            return Err(incomplete());
        };
        let (objective, round_off) = self.objective(&energy);
        Ok(Trial {
            objective,
            round_off,
            length,
            slope_before: before.plain,
            slope: along.plain,
        })
    }
}
