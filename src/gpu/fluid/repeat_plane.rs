//! Starts that do not vary along z: one plane is worked out on the host, and the device repeats it. For benchmarks of boxes so large that
//! the host would work longer on the start than the device on the steps.

use super::Fluid;
use crate::gpu::error::DeviceError;
use crate::gpu::shaders::{self, parameters};
use crate::lattice::DIRECTION_COUNT;
use crate::lattice::start::Start;

parameters! {
    /// Which elements are repeated.
    RepeatParameters {
        /// Element at which the first plane begins.
        first: u32,
        /// Elements from plane to plane.
        stride: u32,
        /// Elements to write, after the first plane.
        elements: u32,
        /// Unused.
        padding: u32,
    }
}

impl Fluid {
    /// Takes the populations of a start of one plane for every plane, before the first step. The box must repeat along all axes.
    pub fn fill_planes_alike(&mut self, plane: &Start) -> Result<(), DeviceError> {
        let grid = self.grid;
        let [pipeline] = self.device.pipelines(
            &shaders::REPEAT_PLANE[self.storage as usize],
            ["repeat_plane"],
            &[],
        )?;
        let parameters = self.device.uniform::<RepeatParameters>("repeated plane")?;
        for array in 0..DIRECTION_COUNT {
            let direction = crate::lattice::opposite(array);
            let (first, data) = self.first_planes(plane, direction, 1);
            self.write_populations(array, &data);
            // The last plane of a shifted array ends early: what is beyond are ghosts.
            let after = grid.total - (first + grid.stride_z).min(grid.total);
            let elements = after.min((grid.cells[2] - 1) * grid.stride_z);
            let bound = self.device.bind(
                &pipeline,
                &[
                    ("repeated", &self.populations[array]),
                    ("repeat", &parameters),
                ],
            )?;
            self.device.write(
                &parameters,
                0,
                &[RepeatParameters {
                    first: first as u32,
                    stride: grid.stride_z as u32,
                    elements: elements as u32,
                    padding: 0,
                }],
            );
            let mut commands = self.device.record("repeat_plane");
            bound.dispatch(
                &mut commands.pass("repeat_plane"),
                self.device.workgroups(elements as u64),
            );
            self.device.submit(commands);
        }
        self.device.check()
    }
}
