//! The rasteriser of a device: the same draw list as in software, with a depth buffer and four samples per pixel.
//!
//! Camera, checks, lighting, colours, line widths and the order of drawing are those of [`crate::render::raster`]; text and
//! legends are drawn by the same functions on the finished pixels. To a person both pictures are the same. They differ in that
//!
//! * the four samples of a pixel lie where the device has them, rather than on a square, and a surface is lit once per pixel
//!   rather than once per sample;
//! * the ends of a line hide what is behind them as squares, not as half-discs, and stretches of one line do not hide each other;
//! * a line is dimmed by just those translucent slices that are in front of it, and opaque slices are drawn before translucent
//!   ones, so that sheets that cross each other are right wherever one of them is opaque;
//! * an infinite value of a slice is a hole, and surfaces and slices end at a depth of 10²⁵ m;
//! * devices round differently from each other: the bytes are always alike on the same device only.

use std::ops::Range;

use image::RgbImage;

use super::device::{Device, TRANSFER_BYTES};
use super::error::DeviceError;
use super::transfer::Staging;
use crate::render::RenderError;
use crate::render::annotate::draw_annotations;
use crate::render::picture::{Picture, PixelRect};
use crate::render::raster::{empty_page, prepare};

mod cutting;
pub mod geometry;
mod pipelines;

use geometry::{Geometry, RasterSheet};
use pipelines::{COLOUR_FORMAT, DEPTH_FORMAT, Pipelines, SAMPLE_COUNT};

/// Why a device did not draw a picture.
#[derive(Debug, thiserror::Error)]
pub enum RasterError {
    /// The picture cannot be drawn by anyone.
    #[error(transparent)]
    Picture(#[from] RenderError),
    /// The device failed.
    #[error(transparent)]
    Device(#[from] DeviceError),
}

/// A device ready to draw pictures.
#[derive(Debug)]
pub struct Rasteriser {
    pipelines: Pipelines,
}

/// Draws one picture. For several, a [`Rasteriser`] saves their preparation.
///
/// # Errors
///
/// As [`Rasteriser::new`] and [`Rasteriser::draw`].
pub fn rasterise(device: &Device, picture: &Picture) -> Result<RgbImage, RasterError> {
    Rasteriser::new(device)?.draw(device, picture)
}

impl Rasteriser {
    /// Builds the pipelines.
    ///
    /// # Errors
    ///
    /// [`DeviceError`] where the device refuses them.
    pub fn new(device: &Device) -> Result<Self, DeviceError> {
        Ok(Self {
            pipelines: Pipelines::new(device)?,
        })
    }

    /// Draws a picture on the device that this was built for.
    ///
    /// # Errors
    ///
    /// [`RasterError::Picture`] where the software rasteriser fails as well, and [`RasterError::Device`] for a viewport beyond
    /// the device's limits and for a device that fails.
    pub fn draw(&self, device: &Device, picture: &Picture) -> Result<RgbImage, RasterError> {
        let prepared = prepare(picture)?;
        check_size(device, picture.viewport)?;
        let geometry = Geometry::new(picture, &prepared);
        let buffers = Buffers::new(device, &self.pipelines.bindings, &geometry)?;
        let target = self.paint(device, picture.viewport, &geometry, &buffers)?;
        let mut image = empty_page(picture);
        read_back(device, &target, picture.viewport, &mut image)?;
        draw_annotations(&mut image, picture);
        Ok(image)
    }

    /// Records and submits the drawing; the texture will hold the viewport.
    fn paint(
        &self,
        device: &Device,
        port: PixelRect,
        geometry: &Geometry,
        buffers: &Buffers,
    ) -> Result<wgpu::Texture, DeviceError> {
        let attachment = wgpu::TextureUsages::RENDER_ATTACHMENT;
        let texture = |label, format, samples, usage| {
            let doing = format!(
                "allocating the {label} of {}×{} px",
                port.width, port.height
            );
            device.guarded(&doing, || {
                device.raw.create_texture(&wgpu::TextureDescriptor {
                    label: Some(label),
                    size: wgpu::Extent3d {
                        width: port.width,
                        height: port.height,
                        depth_or_array_layers: 1,
                    },
                    mip_level_count: 1,
                    sample_count: samples,
                    dimension: wgpu::TextureDimension::D2,
                    format,
                    usage,
                    view_formats: &[],
                })
            })
        };
        let colours = texture("picture's samples", COLOUR_FORMAT, SAMPLE_COUNT, attachment)?;
        let depths = texture("picture's depths", DEPTH_FORMAT, SAMPLE_COUNT, attachment)?;
        let usage = attachment | wgpu::TextureUsages::COPY_SRC;
        let target = texture("picture", COLOUR_FORMAT, 1, usage)?;
        device.guarded("drawing a picture", || {
            let [colours, depths, resolved] = [&colours, &depths, &target]
                .map(|texture| texture.create_view(&Default::default()));
            let mut commands = device.record("picture");
            let mut pass = commands.raw.begin_render_pass(&wgpu::RenderPassDescriptor {
                label: Some("picture"),
                color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                    view: &colours,
                    depth_slice: None,
                    resolve_target: Some(&resolved),
                    ops: wgpu::Operations {
                        load: wgpu::LoadOp::Clear(wgpu::Color::BLACK),
                        store: wgpu::StoreOp::Discard,
                    },
                })],
                depth_stencil_attachment: Some(wgpu::RenderPassDepthStencilAttachment {
                    view: &depths,
                    depth_ops: Some(wgpu::Operations {
                        // Farthest.
                        load: wgpu::LoadOp::Clear(0.0),
                        store: wgpu::StoreOp::Discard,
                    }),
                    stencil_ops: None,
                }),
                timestamp_writes: None,
                occlusion_query_set: None,
                multiview_mask: None,
            });
            self.record(&mut pass, geometry, buffers);
            drop(pass);
            device.submit(commands);
        })?;
        Ok(target)
    }

    fn record(&self, pass: &mut wgpu::RenderPass<'_>, geometry: &Geometry, buffers: &Buffers) {
        let pipelines = &self.pipelines;
        pass.set_bind_group(0, &buffers.group, &[]);
        pass.set_pipeline(&pipelines.background);
        pass.draw(0..3, 0..1);

        let [translucent, opaque, behind] = geometry.sheet_ranges.clone();
        let sheets = |pass: &mut wgpu::RenderPass<'_>, pipeline, corners: Range<u32>| {
            if !corners.is_empty() {
                pass.set_pipeline(pipeline);
                pass.set_vertex_buffer(0, buffers.sheets.slice(..));
                pass.draw(corners, 0..1);
            }
        };
        sheets(pass, &pipelines.sheet_behind, behind);
        if !geometry.surfaces.is_empty() {
            pass.set_pipeline(&pipelines.surface);
            pass.set_vertex_buffer(0, buffers.surfaces.slice(..));
            pass.draw(0..geometry.surfaces.len() as u32, 0..1);
        }
        sheets(pass, &pipelines.sheet_opaque, opaque);
        sheets(pass, &pipelines.sheet_translucent, translucent);

        if !geometry.edges.is_empty() {
            pass.set_pipeline(&pipelines.line);
            pass.set_vertex_buffer(0, buffers.edges.slice(..));
            pass.draw(STRIP, 0..geometry.edges.len() as u32);
        }
        pass.set_vertex_buffer(0, buffers.lines.slice(..));
        for stretches in &geometry.line_ranges {
            if !stretches.is_empty() {
                for pipeline in [&pipelines.line, &pipelines.line_core] {
                    pass.set_pipeline(pipeline);
                    pass.draw(STRIP, stretches.clone());
                }
            }
        }
    }
}

/// Corners of the strip of a stretch of line.
const STRIP: Range<u32> = 0..8;

/// What is drawn, on the device.
struct Buffers {
    surfaces: wgpu::Buffer,
    edges: wgpu::Buffer,
    lines: wgpu::Buffer,
    sheets: wgpu::Buffer,
    group: wgpu::BindGroup,
}

impl Buffers {
    fn new(
        device: &Device,
        layout: &wgpu::BindGroupLayout,
        geometry: &Geometry,
    ) -> Result<Self, DeviceError> {
        let view = device.uniform::<geometry::RasterView>("view")?;
        device.write(&view, 0, &[geometry.view]);
        // A binding must have room for one element at least.
        let sheets = device.storage(
            "slices",
            (size_of::<RasterSheet>() * geometry.sheets.len().max(1)) as u64,
        )?;
        device.write(&sheets, 0, &geometry.sheets);
        let values = device.storage_of("values of slices", &geometry.values)?;
        let colours = device.storage_of("colours of slices", &geometry.colours)?;
        let group = device.guarded("binding a picture's buffers", || {
            let entries = [&view, &sheets, &values, &colours];
            let entries: [_; 4] = std::array::from_fn(|k| wgpu::BindGroupEntry {
                binding: k as u32,
                resource: entries[k].as_entire_binding(),
            });
            device.raw.create_bind_group(&wgpu::BindGroupDescriptor {
                label: Some("picture"),
                layout,
                entries: &entries,
            })
        })?;
        Ok(Self {
            surfaces: vertices(device, "surfaces", &geometry.surfaces)?,
            edges: vertices(device, "edges", &geometry.edges)?,
            lines: vertices(device, "lines", &geometry.lines)?,
            sheets: vertices(device, "corners of slices", &geometry.sheet_vertices)?,
            group,
        })
    }
}

fn vertices<T: bytemuck::Pod>(
    device: &Device,
    label: &str,
    data: &[T],
) -> Result<wgpu::Buffer, DeviceError> {
    let usage = wgpu::BufferUsages::VERTEX | wgpu::BufferUsages::COPY_DST;
    let buffer = device.buffer(label, size_of_val(data) as u64, usage)?;
    device.write(&buffer, 0, data);
    Ok(buffer)
}

fn check_size(device: &Device, port: PixelRect) -> Result<(), DeviceError> {
    let limit = device.texture_limit();
    let needed = port.width.max(port.height);
    if needed > limit {
        return Err(DeviceError::Limit {
            what: format!("a view of {}×{} px", port.width, port.height),
            needed: needed.into(),
            limit: limit.into(),
            limit_name: "max_texture_dimension_2d [px]",
            device: device.info().name.clone(),
            remedy: "draw a smaller picture, or draw it in software",
        });
    }
    Ok(())
}

/// Copies the drawn pixels into the viewport.
fn read_back(
    device: &Device,
    target: &wgpu::Texture,
    port: PixelRect,
    image: &mut RgbImage,
) -> Result<(), DeviceError> {
    let row_bytes = (4 * port.width).next_multiple_of(wgpu::COPY_BYTES_PER_ROW_ALIGNMENT);
    let band = (TRANSFER_BYTES / u64::from(row_bytes)).clamp(1, u64::from(port.height)) as u32;
    let staging = Staging::new(device, u64::from(row_bytes) * u64::from(band))?;
    for first in (0..port.height).step_by(band as usize) {
        let rows = first..(first + band).min(port.height);
        device.guarded("reading a picture back", || {
            let mut commands = device.record("picture");
            staging.copy_rows(&mut commands, target, rows.clone(), row_bytes);
            device.submit(commands);
        })?;
        staging.read(device, |bytes| {
            for (row, line) in rows.zip(bytes.chunks_exact(row_bytes as usize)) {
                for (column, pixel) in (0..port.width).zip(line.chunks_exact(4)) {
                    let colour = image::Rgb([pixel[0], pixel[1], pixel[2]]);
                    image.put_pixel(port.x + column, port.y + row, colour);
                }
            }
        })?;
    }
    Ok(())
}

#[cfg(test)]
#[path = "raster_tests.rs"]
mod tests;
