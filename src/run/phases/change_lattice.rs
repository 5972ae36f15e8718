//! Phase `change_lattice`, from grid to grid of a sequence; and time steps that follow the speed of a fall within a march.

use super::lattice::Lattice;
use super::stand::Next;
use crate::plan::Plan;
use crate::run::{Observer, Run, RunError};

impl Run<'_> {
    /// True after a sample on a coarser grid whose flow has settled.
    pub(super) fn coarse_grid_is_done(&self) -> bool {
        self.lattice
            .coarse_grid_is_done(&self.simulation, &self.record)
    }

    /// After a sample in a fall: goes on with another time step if it is time to. [`Lattice::note`] sums these changes up.
    pub(super) fn follow_speed(&mut self) -> Result<bool, RunError> {
        match self.lattice.next_step(&self.simulation)? {
            Some(next) => self.go_on_on(next).map(|()| true),
            None => Ok(false),
        }
    }

    /// Goes on on the next finer grid of the sequence.
    pub(super) fn change_grid(&mut self, observer: &mut dyn Observer) -> Result<Next, RunError> {
        self.go_on_on(self.lattice.finer())?;
        observer.lattice_changed();
        self.record.grid_changes(self.simulation.time_s());
        let air = &self.simulation.scene().air;
        let grid = air.as_ref().map_or_else(String::new, |air| {
            let [nx, ny, nz] = air.cells;
            format!(
                "; {nx} x {ny} x {nz} cells, steps of {:.3e} s from here",
                air.units.time_step_s
            )
        });
        let text = format!(
            "t = {:.4} s: the flow has settled on the coarser grid{grid}",
            self.simulation.time_s()
        );
        observer.note(&text);
        self.notes.push(text);
        Ok(Next::Phase)
    }

    fn go_on_on(&mut self, lattice: Lattice) -> Result<(), RunError> {
        let scene = lattice.scene(self.case);
        let plan = Plan::new(&scene, self.simulation.plan().placement.clone());
        self.whole = false;
        self.simulation.change_lattice(scene, plan)?;
        self.whole = true;
        self.lattice = lattice;
        Ok(())
    }
}
