//! The render pipelines of a picture and their bindings.

use super::geometry::{LineInstance, SheetVertex, SurfaceVertex};
use crate::gpu::device::Device;
use crate::gpu::error::DeviceError;
use crate::gpu::pipeline::validate;
use crate::gpu::shaders::RASTER;

/// Colours are blended and averaged as sRGB bytes, as the software rasteriser does, so the format must not convert them.
pub(super) const COLOUR_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Rgba8Unorm;

/// Format of depths, which are stored with 1 nearest, so that single precision is densest where it is needed.
pub(super) const DEPTH_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Depth32Float;

/// Samples of a pixel.
pub(super) const SAMPLE_COUNT: u32 = 4;

/// Pipelines, in the order in which a picture uses them.
#[derive(Debug)]
pub(super) struct Pipelines {
    pub bindings: wgpu::BindGroupLayout,
    pub background: wgpu::RenderPipeline,
    pub sheet_behind: wgpu::RenderPipeline,
    pub surface: wgpu::RenderPipeline,
    pub sheet_opaque: wgpu::RenderPipeline,
    pub sheet_translucent: wgpu::RenderPipeline,
    pub line: wgpu::RenderPipeline,
    pub line_core: wgpu::RenderPipeline,
}

/// How a pipeline treats depth and colour.
#[derive(Debug, Clone, Copy)]
struct Rule {
    compare: wgpu::CompareFunction,
    writes_depth: bool,
    writes_colour: bool,
}

/// Drawn over whatever there is.
const OVER_ALL: Rule = Rule {
    compare: wgpu::CompareFunction::Always,
    writes_depth: false,
    writes_colour: true,
};

/// Hidden by what is as near, hides what is behind.
const SOLID: Rule = Rule {
    compare: wgpu::CompareFunction::Greater,
    writes_depth: true,
    writes_colour: true,
};

/// Hidden by what is as near, hides nothing.
const VEIL: Rule = Rule {
    writes_depth: false,
    ..SOLID
};

/// Hidden by what is nearer, hides nothing.
const MARK: Rule = Rule {
    compare: wgpu::CompareFunction::GreaterEqual,
    ..VEIL
};

/// Hides what is behind without being seen itself.
const MASK: Rule = Rule {
    writes_depth: true,
    writes_colour: false,
    ..MARK
};

const SURFACE: wgpu::VertexBufferLayout = wgpu::VertexBufferLayout {
    array_stride: size_of::<SurfaceVertex>() as u64,
    step_mode: wgpu::VertexStepMode::Vertex,
    attributes: &wgpu::vertex_attr_array![0 => Float32x3, 1 => Float32x3, 2 => Unorm8x4],
};

const SHEET: wgpu::VertexBufferLayout = wgpu::VertexBufferLayout {
    array_stride: size_of::<SheetVertex>() as u64,
    step_mode: wgpu::VertexStepMode::Vertex,
    attributes: &wgpu::vertex_attr_array![0 => Float32x3, 1 => Uint32],
};

const LINE: wgpu::VertexBufferLayout = wgpu::VertexBufferLayout {
    array_stride: size_of::<LineInstance>() as u64,
    step_mode: wgpu::VertexStepMode::Instance,
    attributes: &wgpu::vertex_attr_array![
        0 => Float32x4, 1 => Float32x2, 2 => Float32x2, 3 => Unorm8x4
    ],
};

fn refused(name: &str) -> impl FnOnce(DeviceError) -> DeviceError + '_ {
    move |error| match error {
        DeviceError::Command(why) => DeviceError::Pipeline {
            name: name.to_owned(),
            why,
        },
        other => other,
    }
}

impl Pipelines {
    pub fn new(device: &Device) -> Result<Self, DeviceError> {
        validate(&RASTER).map_err(|why| DeviceError::Pipeline {
            name: RASTER.name.to_owned(),
            why,
        })?;
        let (module, bindings, layout) = device
            .guarded(RASTER.name, || {
                let module = device
                    .raw
                    .create_shader_module(wgpu::ShaderModuleDescriptor {
                        label: Some(RASTER.name),
                        source: wgpu::ShaderSource::Wgsl(RASTER.source().into()),
                    });
                let bindings = bind_group_layout(device);
                let layout = device
                    .raw
                    .create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
                        label: Some(RASTER.name),
                        bind_group_layouts: &[Some(&bindings)],
                        immediate_size: 0,
                    });
                (module, bindings, layout)
            })
            .map_err(refused(RASTER.name))?;
        let triangles = wgpu::PrimitiveTopology::TriangleList;
        let strip = wgpu::PrimitiveTopology::TriangleStrip;
        let make = |part: &str, buffer: Option<wgpu::VertexBufferLayout>, topology, rule| {
            pipeline(device, &module, &layout, part, buffer, topology, rule)
        };
        Ok(Self {
            background: make("background", None, triangles, OVER_ALL)?,
            sheet_behind: make("sheet", Some(SHEET), triangles, OVER_ALL)?,
            surface: make("surface", Some(SURFACE), triangles, SOLID)?,
            sheet_opaque: make("sheet", Some(SHEET), triangles, SOLID)?,
            sheet_translucent: make("sheet", Some(SHEET), triangles, VEIL)?,
            line: make("line", Some(LINE), strip, MARK)?,
            line_core: make("line_core", Some(LINE), strip, MASK)?,
            bindings,
        })
    }
}

fn bind_group_layout(device: &Device) -> wgpu::BindGroupLayout {
    let storage = wgpu::BufferBindingType::Storage { read_only: true };
    let entry = |binding, visibility, ty| wgpu::BindGroupLayoutEntry {
        binding,
        visibility,
        ty: wgpu::BindingType::Buffer {
            ty,
            has_dynamic_offset: false,
            min_binding_size: None,
        },
        count: None,
    };
    let fragment = wgpu::ShaderStages::FRAGMENT;
    device
        .raw
        .create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
            label: Some(RASTER.name),
            entries: &[
                entry(
                    0,
                    wgpu::ShaderStages::VERTEX_FRAGMENT,
                    wgpu::BufferBindingType::Uniform,
                ),
                entry(1, fragment, storage),
                entry(2, fragment, storage),
                entry(3, fragment, storage),
            ],
        })
}

/// The pipeline of the entry points `part_vertex` and `part_fragment`.
fn pipeline(
    device: &Device,
    module: &wgpu::ShaderModule,
    layout: &wgpu::PipelineLayout,
    part: &str,
    buffer: Option<wgpu::VertexBufferLayout>,
    topology: wgpu::PrimitiveTopology,
    rule: Rule,
) -> Result<wgpu::RenderPipeline, DeviceError> {
    let [vertex, fragment] = ["vertex", "fragment"].map(|stage| format!("{part}_{stage}"));
    let buffers = [buffer];
    let used = if buffers[0].is_some() { 1 } else { 0 };
    let descriptor = wgpu::RenderPipelineDescriptor {
        label: Some(part),
        layout: Some(layout),
        vertex: wgpu::VertexState {
            module,
            entry_point: Some(&vertex),
            compilation_options: wgpu::PipelineCompilationOptions::default(),
            buffers: &buffers[..used],
        },
        primitive: wgpu::PrimitiveState {
            topology,
            ..Default::default()
        },
        depth_stencil: Some(wgpu::DepthStencilState {
            format: DEPTH_FORMAT,
            depth_write_enabled: Some(rule.writes_depth),
            depth_compare: Some(rule.compare),
            stencil: wgpu::StencilState::default(),
            bias: wgpu::DepthBiasState::default(),
        }),
        multisample: wgpu::MultisampleState {
            count: SAMPLE_COUNT,
            ..Default::default()
        },
        fragment: Some(wgpu::FragmentState {
            module,
            entry_point: Some(&fragment),
            compilation_options: wgpu::PipelineCompilationOptions::default(),
            targets: &[Some(wgpu::ColorTargetState {
                format: COLOUR_FORMAT,
                blend: Some(wgpu::BlendState::ALPHA_BLENDING),
                write_mask: if rule.writes_colour {
                    wgpu::ColorWrites::ALL
                } else {
                    wgpu::ColorWrites::empty()
                },
            })],
        }),
        multiview_mask: None,
        cache: None,
    };
    device
        .guarded(part, || device.raw.create_render_pipeline(&descriptor))
        .map_err(refused(part))
}
