//! Compute pipelines whose bindings are known by name.

use std::collections::HashMap;

use naga::valid::{Capabilities, ModuleInfo, ValidationFlags, Validator};

use super::commands::Pass;
use super::device::Device;
use super::error::DeviceError;
use super::shaders::{Shader, WORKGROUP};

/// One entry point, ready to be dispatched.
#[derive(Debug, Clone)]
pub(super) struct Pipeline {
    name: String,
    raw: wgpu::ComputePipeline,
    /// Binding number of every name that the entry point uses.
    bindings: Vec<(String, u32)>,
}

/// A pipeline with its buffers.
#[derive(Debug, Clone)]
pub(super) struct Bound {
    pipeline: wgpu::ComputePipeline,
    group: wgpu::BindGroup,
}

/// Parses and validates a shader.
pub fn validate(shader: &Shader) -> Result<(naga::Module, ModuleInfo), String> {
    validate_source(&shader.source())
}

fn validate_source(source: &str) -> Result<(naga::Module, ModuleInfo), String> {
    let module =
        naga::front::wgsl::parse_str(source).map_err(|error| error.emit_to_string(source))?;
    // Needed by populations in 16 bits; a device without them is refused before.
    let info = Validator::new(ValidationFlags::all(), Capabilities::SHADER_FLOAT16)
        .validate(&module)
        .map_err(|error| error.emit_to_string(source))?;
    Ok((module, info))
}

/// Names and numbers of the bindings that an entry point uses, in order of their numbers.
#[must_use]
pub fn bindings(module: &naga::Module, info: &ModuleInfo, entry: &str) -> Vec<(String, u32)> {
    let Some(index) = module
        .entry_points
        .iter()
        .position(|point| point.name == entry)
    else {
        return Vec::new();
    };
    let uses = info.get_entry_point(index);
    let mut found: Vec<_> = module
        .global_variables
        .iter()
        .filter(|(handle, _)| !uses[*handle].is_empty())
        .filter_map(|(_, variable)| {
            let binding = variable.binding.as_ref()?;
            Some((variable.name.clone()?, binding.binding))
        })
        .collect();
    found.sort_by_key(|(_, number)| *number);
    found
}

impl Device {
    /// Builds the pipelines of several entry points of one shader; constants that the shader does not declare are left out.
    pub(super) fn pipelines<const N: usize>(
        &self,
        shader: &Shader,
        entries: [&str; N],
        constants: &[(&str, f64)],
    ) -> Result<[Pipeline; N], DeviceError> {
        self.pipelines_of((shader.name, shader.source()), entries, constants)
    }

    /// The same of a shader by its name and text.
    pub(super) fn pipelines_of<const N: usize>(
        &self,
        (shader, source): (&'static str, String),
        entries: [&str; N],
        constants: &[(&str, f64)],
    ) -> Result<[Pipeline; N], DeviceError> {
        let refused = |name: &str, why: String| DeviceError::Pipeline {
            name: name.to_owned(),
            why,
        };
        let (module, info) = validate_source(&source).map_err(|why| refused(shader, why))?;
        let declared: Vec<(&str, f64)> = constants
            .iter()
            .copied()
            .filter(|(name, _)| {
                module
                    .overrides
                    .iter()
                    .any(|(_, o)| o.name.as_deref() == Some(*name))
            })
            .collect();
        let raw_module = self
            .guarded(shader, || self.shader_module(shader, source))
            .map_err(|error| match error {
                DeviceError::Command(why) => refused(shader, why),
                other => other,
            })?;
        let mut made = Vec::with_capacity(N);
        for entry in entries {
            let raw = self
                .guarded(entry, || {
                    self.raw
                        .create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
                            label: Some(entry),
                            layout: None,
                            module: &raw_module,
                            entry_point: Some(entry),
                            compilation_options: wgpu::PipelineCompilationOptions {
                                constants: &declared,
                                ..Default::default()
                            },
                            cache: None,
                        })
                })
                .map_err(|error| match error {
                    DeviceError::Command(why) => refused(entry, why),
                    other => other,
                })?;
            made.push(Pipeline {
                name: entry.to_owned(),
                raw,
                bindings: bindings(&module, &info, entry),
            });
        }
        made.try_into()
            .map_err(|_| refused(shader, "entry points are missing".to_owned()))
    }

    /// A module that checks the bounds of its buffers; but `collide_stream`, where a benchmark wants to know what that costs.
    #[allow(
        unsafe_code,
        reason = "what bounds checks cost can be measured in no other way; no run takes this path (src/gpu/tuning.rs)"
    )]
    fn shader_module(&self, name: &str, source: String) -> wgpu::ShaderModule {
        let descriptor = wgpu::ShaderModuleDescriptor {
            label: Some(name),
            source: wgpu::ShaderSource::Wgsl(source.into()),
        };
        if self.tuning().bounds_checks || !name.starts_with("collide_stream") {
            return self.raw.create_shader_module(descriptor);
        }
        let checks = wgpu::ShaderRuntimeChecks {
            bounds_checks: false,
            ..wgpu::ShaderRuntimeChecks::checked()
        };
        // SAFETY: `collide_stream` reads and writes elements of cells inside the grid and of their neighbours, which the ghost layer holds; all
        // buffers have the elements of the grid with its ghosts. `cell_forces` is read inside its box only. Loops and divisions stay checked.
        unsafe { self.raw.create_shader_module_trusted(descriptor, checks) }
    }

    /// Gives a pipeline its buffers by name; names that the entry point does not use are left out.
    pub(super) fn bind(
        &self,
        pipeline: &Pipeline,
        buffers: &[(&str, &wgpu::Buffer)],
    ) -> Result<Bound, DeviceError> {
        let by_name: HashMap<&str, &wgpu::Buffer> = buffers.iter().copied().collect();
        let mut entries = Vec::with_capacity(pipeline.bindings.len());
        for (name, number) in &pipeline.bindings {
            let Some(buffer) = by_name.get(name.as_str()) else {
                return Err(DeviceError::Pipeline {
                    name: pipeline.name.clone(),
                    why: format!("no buffer is given for `{name}`"),
                });
            };
            entries.push(wgpu::BindGroupEntry {
                binding: *number,
                resource: buffer.as_entire_binding(),
            });
        }
        let group = self.guarded(&pipeline.name, || {
            self.raw.create_bind_group(&wgpu::BindGroupDescriptor {
                label: Some(&pipeline.name),
                layout: &pipeline.raw.get_bind_group_layout(0),
                entries: &entries,
            })
        })?;
        Ok(Bound {
            pipeline: pipeline.raw.clone(),
            group,
        })
    }

    /// Workgroups that cover `threads` threads, spread over two dimensions if they are many.
    pub(super) fn workgroups(&self, threads: u64) -> [u32; 2] {
        let groups = threads.div_ceil(u64::from(WORKGROUP)).max(1);
        let limit = u64::from(self.workgroup_limit());
        let rows = groups.div_ceil(limit);
        [groups.div_ceil(rows) as u32, rows as u32]
    }
}

/// A pipeline with the workgroups that it needs.
pub(super) type Counted = (Bound, [u32; 2]);

impl Bound {
    /// Records a dispatch of workgroups along x and y.
    pub(super) fn dispatch(&self, pass: &mut Pass<'_>, groups: [u32; 2]) {
        pass.dispatch(&self.pipeline, &self.group, groups);
    }

    /// The same with the workgroups that a shader writes to entry `index` of a buffer.
    pub(super) fn dispatch_indirect(
        &self,
        pass: &mut Pass<'_>,
        workgroups: &wgpu::Buffer,
        index: usize,
    ) {
        pass.dispatch_indirect(&self.pipeline, &self.group, (workgroups, index));
    }
}
