//! Parts of stage `solve_cloth` that run over elements and then gather at nodes: energy with its gradient
//! (`shaders/nodal_forces.wgsl`) and the initial Hessian (`shaders/initial_hessian.wgsl`).
//!
//! One dispatch per kind of element that the structure has, then one over the nodes; nothing is added atomically.

use crate::gpu::commands::Pass;
use crate::gpu::device::Device;
use crate::gpu::error::DeviceError;
use crate::gpu::pipeline::{Bound, Pipeline};
use crate::gpu::shaders::Shader;

use super::elements::Kind;

/// Dispatches over elements, then one that gathers them at the nodes.
#[derive(Debug, Clone)]
pub(super) struct Gathering {
    elements: Vec<(Pipeline, [u32; 2])>,
    nodes: (Pipeline, [u32; 2]),
}

/// The same with its buffers.
#[derive(Debug)]
pub(super) struct BoundGathering(Vec<(Bound, [u32; 2])>);

impl Gathering {
    /// Pipelines `<kind>_<what>` of all kinds and `gather_<what>` of a shader.
    pub fn new(
        device: &Device,
        shader: &Shader,
        what: &str,
        kinds: &[Kind],
        nodes: usize,
        constants: &[(&str, f64)],
    ) -> Result<Self, DeviceError> {
        let pipeline = |name: &str| {
            let entry = format!("{name}_{what}");
            let [pipeline] = device.pipelines(shader, [entry.as_str()], constants)?;
            Ok::<_, DeviceError>(pipeline)
        };
        let mut elements = Vec::new();
        for kind in kinds {
            elements.push((pipeline(kind.name)?, device.workgroups(kind.count as u64)));
        }
        Ok(Self {
            elements,
            nodes: (pipeline("gather")?, device.workgroups(nodes as u64)),
        })
    }

    /// The same elements, gathered by another entry point of the shader.
    pub fn gathered_by(
        &self,
        device: &Device,
        shader: &Shader,
        entry: &str,
        constants: &[(&str, f64)],
    ) -> Result<Self, DeviceError> {
        let [pipeline] = device.pipelines(shader, [entry], constants)?;
        Ok(Self {
            elements: self.elements.clone(),
            nodes: (pipeline, self.nodes.1),
        })
    }

    /// Gives the pipelines their buffers.
    pub fn bind(
        &self,
        device: &Device,
        buffers: &[(&str, &wgpu::Buffer)],
    ) -> Result<BoundGathering, DeviceError> {
        let mut bound = Vec::new();
        for (pipeline, groups) in self.elements.iter().chain([&self.nodes]) {
            bound.push((device.bind(pipeline, buffers)?, *groups));
        }
        Ok(BoundGathering(bound))
    }
}

impl BoundGathering {
    /// Dispatches in all.
    pub const fn len(&self) -> usize {
        self.0.len()
    }

    /// Their workgroups.
    pub fn groups(&self) -> impl Iterator<Item = [u32; 2]> {
        self.0.iter().map(|(_, groups)| *groups)
    }

    /// Records all dispatches, their workgroups from entry `first` of a buffer on.
    pub fn dispatch_indirect(&self, pass: &mut Pass<'_>, workgroups: &wgpu::Buffer, first: usize) {
        for (k, (bound, _)) in self.0.iter().enumerate() {
            bound.dispatch_indirect(pass, workgroups, first + k);
        }
    }

    /// Records all dispatches.
    pub fn dispatch(&self, pass: &mut Pass<'_>) {
        for (bound, groups) in &self.0 {
            bound.dispatch(pass, *groups);
        }
    }
}
