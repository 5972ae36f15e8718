//! Frames, collections and pictures of a run.

use std::path::{Path, PathBuf};

use glam::DVec3;

use super::run_folder::RunFolder;
use super::verify::Lost;
use super::written::{Written, bodies_name, canopy_name, flow_levels_name, flow_name};
use super::{RunError, animation};
use crate::case::Scene;
use crate::case::scene::{BodyKind, Flow};
use crate::checkpoint::Writer;
use crate::frame::{FlowQuantity, Frame};
use crate::measure::Record;
use crate::measure::shared::{DRAG_COEFFICIENT, LIFT_COEFFICIENT, PROJECTED_DIAMETER_RATIO};
use crate::measure::wing_wind::VOLUME_RATIO;
use crate::output::{
    FRAMES_FOLDER, OutputError, Pvd, prepare_directory, write_atomically, write_bodies_vtp,
    write_canopy_vtp, write_flow,
};
use crate::render::{self, PictureOptions, Section};
use crate::simulation::Simulation;

/// Fabric alone whose height is less than this share of its width and length is seen from further above.
const FLAT: f64 = 0.25;

/// Least speed that pictures of a fall are scaled with, per speed of release.
const SLOWEST_SCALE: f64 = 0.05;

/// Files of one kind, numbered, and the collection that lists them.
struct Frames {
    collection: Pvd,
    /// Times of all that were written, also of those that were lost since [s].
    times_s: Vec<f64>,
    name: fn(usize) -> String,
}

impl Frames {
    /// Goes on behind those that were written at `times_s`; lost ones keep their numbers, but are not listed.
    fn create(
        path: &Path,
        times_s: &[f64],
        name: fn(usize) -> String,
        lost: &Lost,
    ) -> Result<Self, OutputError> {
        let mut collection = Pvd::create(path)?;
        for (index, &time_s) in times_s.iter().enumerate() {
            let name = name(index);
            if !lost.has(&name) {
                collection.append(time_s, &name)?;
            }
        }
        Ok(Self {
            collection,
            times_s: times_s.to_vec(),
            name,
        })
    }

    /// True if the last one shows that time.
    fn shows(&self, time_s: f64) -> bool {
        self.times_s.last() == Some(&time_s)
    }

    /// Name of the next one.
    fn next(&self) -> String {
        (self.name)(self.times_s.len())
    }

    /// Lists the next one, which is written; what cannot be listed goes.
    fn add(&mut self, time_s: f64) -> Result<(), OutputError> {
        let name = self.next();
        if let Err(error) = self.collection.append(time_s, &name) {
            let _ = std::fs::remove_file(self.collection.path().with_file_name(name));
            return Err(error);
        }
        self.times_s.push(time_s);
        Ok(())
    }
}

/// Files of a run.
pub(super) struct Files<'a> {
    pub(super) folder: RunFolder<'a>,
    canopies: Option<Frames>,
    flows: Option<Frames>,
    bodies: Option<Frames>,
    /// Pictures drawn at the times that the case asks for.
    pub(super) timed_pictures: usize,
    pub(super) last_picture: Option<PathBuf>,
    /// Frames of the animation so far, each a file until they become one.
    pub(super) animation_frames: usize,
}

impl<'a> Files<'a> {
    pub(super) fn create(
        folder: RunFolder<'a>,
        scene: &Scene,
        (written, lost): (&Written, &Lost),
    ) -> Result<Self, OutputError> {
        // Every kind of frame has its files there.
        prepare_directory(&folder.join(FRAMES_FOLDER))?;
        let frames = |name: &str, times_s: &[f64], file_name: fn(usize) -> String| {
            Frames::create(&folder.join(name), times_s, file_name, lost)
        };
        let canopies = match scene.body {
            Some(_) => Some(frames("canopy.pvd", &written.canopy_times_s, canopy_name)?),
            None => None,
        };
        let flows = match &scene.air {
            Some(air) => {
                let name = if air.boxes.is_empty() {
                    flow_name
                } else {
                    flow_levels_name
                };
                Some(frames("flow.pvd", &written.flow_times_s, name)?)
            }
            None => None,
        };
        let bodies = if scene.rigid_bodies.is_empty() {
            None
        } else {
            Some(frames("bodies.pvd", &written.bodies_times_s, bodies_name)?)
        };
        Ok(Self {
            folder,
            canopies,
            flows,
            bodies,
            timed_pictures: written.timed_pictures,
            last_picture: None,
            animation_frames: written.animation_frames,
        })
    }

    pub(super) fn save(&self, out: &mut Writer) -> std::io::Result<()> {
        let times = |frames: &Option<Frames>| -> Vec<f64> {
            frames.iter().flat_map(|f| f.times_s.clone()).collect()
        };
        out.put("canopy_times", &times(&self.canopies))?;
        out.put("flow_times", &times(&self.flows))?;
        out.put("bodies_times", &times(&self.bodies))?;
        out.put("timed_pictures", &[self.timed_pictures as u64])?;
        out.put("animation_frames", &[self.animation_frames as u64])
    }

    pub(super) fn canopy(&mut self, simulation: &Simulation) -> Result<(), OutputError> {
        let Some(frames) = &mut self.canopies else {
            return Ok(());
        };
        let frame = simulation.structure_frame();
        // The last state may have been written at its cadence already.
        let written = simulation.scene().equilibrium.is_none() && frames.shows(frame.time_s);
        if let Some(structure) = frame.structure.as_ref().filter(|_| !written) {
            let path = self.folder.join(frames.next());
            write_canopy_vtp(&path, structure, self.folder.stamp(frame.time_s))?;
            frames.add(frame.time_s)?;
        }
        Ok(())
    }

    pub(super) fn bodies(&mut self, simulation: &Simulation) -> Result<(), OutputError> {
        let Some(frames) = &mut self.bodies else {
            return Ok(());
        };
        let frame = simulation.structure_frame();
        let written = frames.shows(frame.time_s);
        if let Some(bodies) = frame.bodies.as_ref().filter(|_| !written) {
            let path = self.folder.join(frames.next());
            write_bodies_vtp(&path, bodies, self.folder.stamp(frame.time_s))?;
            frames.add(frame.time_s)?;
        }
        Ok(())
    }

    pub(super) fn flow(&mut self, simulation: &Simulation) -> Result<(), RunError> {
        let Some(frames) = &mut self.flows else {
            return Ok(());
        };
        if frames.shows(simulation.time_s()) {
            return Ok(());
        }
        let frame = simulation.frame(true)?;
        if let Some(fluid) = &frame.fluid {
            let path = self.folder.join(frames.next());
            write_flow(&path, fluid, self.folder.stamp(frame.time_s))?;
            frames.add(frame.time_s)?;
        }
        Ok(())
    }

    /// Draws the scene as it is now, under the next free number.
    pub(super) fn picture(
        &mut self,
        simulation: &Simulation,
        record: &Record,
    ) -> Result<(), RunError> {
        let scene = simulation.scene();
        let frame = simulation.frame(true)?;
        let mut options = picture_options(simulation, record, &frame);
        // The first quantities have the plain name; scenes without fabric or without air have one picture.
        let number = self.timed_pictures;
        let has_fabric = (frame.structure.as_ref()).is_some_and(|s| !s.triangles.is_empty());
        let fabrics = &scene.output.picture_fabric[..];
        let fabrics = if has_fabric { fabrics } else { &fabrics[..1] };
        let flows = &scene.output.picture_flow[..];
        let (fabric, flow) = (fabrics[0], flows[0]);
        let further = (fabrics[1..]
            .iter()
            .map(|&other| (other, flow, other.name())))
        .chain(
            flows[1..]
                .iter()
                .map(|&other| (fabric, other, other.name())),
        );
        let mut all: Vec<_> = further
            .map(|(fabric, flow, name)| (fabric, flow, format!("snapshot_{number:03}_{name}.png")))
            .collect();
        all.push((fabric, flow, format!("snapshot_{number:03}.png")));
        if let Some(section) = section_through_the_middle(scene, &frame) {
            options.section = Some(section);
            for &flow in flows {
                show_flow(&mut options, flow, simulation);
                let name = format!("snapshot_{number:03}_section_{}.png", flow.name());
                self.draw_into(&self.folder.join(name), &frame, &options)?;
            }
            options.section = None;
        }
        for (fabric, flow, name) in all {
            options.fabric = fabric;
            show_flow(&mut options, flow, simulation);
            let path = self.folder.join(name);
            self.draw_into(&path, &frame, &options)?;
            self.last_picture = Some(path);
        }
        Ok(())
    }

    /// Draws and writes the wing as it stands under a multiple of its loads.
    pub(super) fn loaded_wing(
        &mut self,
        simulation: &Simulation,
        load_factor: f64,
    ) -> Result<(), RunError> {
        let frame = simulation.structure_frame();
        let scene = simulation.scene();
        let options = PictureOptions {
            title: Some(scene.title.clone()),
            caption: Some(format!("load factor {load_factor}")),
            time: scene.time.is_some(),
            fabric: scene.output.picture_fabric[0],
            ..PictureOptions::default()
        };
        if let Some(structure) = &frame.structure {
            let path = self.folder.join(super::tables::load_test::SHAPE);
            write_canopy_vtp(&path, structure, self.folder.stamp(frame.time_s))?;
        }
        let path = self.folder.join(super::tables::load_test::PICTURE);
        self.draw_into(&path, &frame, &options)
    }

    /// Draws the scene as it is now as the next frame of the animation.
    pub(super) fn animation_frame(
        &mut self,
        simulation: &Simulation,
        record: &Record,
    ) -> Result<(), RunError> {
        let frame = simulation.frame(true)?;
        let mut options = picture_options(simulation, record, &frame);
        let scene = simulation.scene();
        options.fabric = scene.output.picture_fabric[0];
        show_flow(&mut options, scene.output.picture_flow[0], simulation);
        [options.width_px, options.height_px] = animation::SIZE_PX;
        let path = self
            .folder
            .join(animation::frame_name(self.animation_frames));
        self.draw_into(&path, &frame, &options)?;
        self.animation_frames += 1;
        Ok(())
    }

    fn draw_into(
        &mut self,
        path: &Path,
        frame: &Frame,
        options: &PictureOptions,
    ) -> Result<(), RunError> {
        let image = render::rasterise(&render::picture_of(frame, options))?;
        let bytes = render::png_bytes(&image)?;
        let bytes = self.folder.provenance().put_into_png(&bytes);
        write_atomically(path, |out| out.write_all(&bytes))?;
        Ok(())
    }
}

/// Sets what the slice of air shows: on a scale that is the same for all pictures of a run, but in a fall on that of its present speed.
fn show_flow(options: &mut PictureOptions, quantity: FlowQuantity, simulation: &Simulation) {
    let scene = simulation.scene();
    let wind_m_s = scene.air.as_ref().map(|air| match &scene.descent {
        Some(_) => simulation
            .wind_speed_m_s()
            .max(SLOWEST_SCALE * air.wind_or_reference_m_s()),
        None => air.wind_or_reference_m_s(),
    });
    options.flow = quantity;
    options.flow_range = scene
        .air
        .as_ref()
        .zip(wind_m_s)
        .and_then(|(air, wind_m_s)| {
            let speed = match air.flow {
                // Air speeds up beside a canopy.
                Flow::WindTunnel { .. } => 1.4 * wind_m_s,
                Flow::TaylorGreen { speed_m_s, .. } => speed_m_s,
            };
            match quantity {
                FlowQuantity::Speed => Some([0.0, speed]),
                FlowQuantity::Pressure => {
                    let pressure = 0.5 * air.units.density_kg_m3 * speed * speed;
                    Some([-pressure, pressure])
                }
                FlowQuantity::Vorticity => None,
            }
        });
    options.arrow_speed_m_s = wind_m_s.filter(|_| scene.output.picture_arrows);
}

/// Caption, view and framing of a scene's pictures.
fn picture_options(simulation: &Simulation, record: &Record, frame: &Frame) -> PictureOptions {
    let scene = simulation.scene();
    let mut caption = String::new();
    for (column, label) in [
        (&LIFT_COEFFICIENT, "C_L"),
        (&DRAG_COEFFICIENT, "C_D"),
        (&PROJECTED_DIAMETER_RATIO, "D_p/D_0"),
        (&VOLUME_RATIO, "volume/design"),
    ] {
        if let Some(value) = record.latest(column).filter(|v| v.is_finite()) {
            caption.push_str(&format!("{label} {value:.2}  "));
        }
    }
    let mut options = PictureOptions {
        title: Some(scene.title.clone()),
        caption: Some(caption).filter(|c| !c.is_empty()),
        time: scene.time.is_some(),
        ..PictureOptions::default()
    };
    if scene
        .body
        .as_ref()
        .is_some_and(|body| matches!(body.kind, BodyKind::Cable { .. }))
    {
        // A plane curve, seen squarely.
        (options.azimuth_deg, options.elevation_deg) = (0.0, 0.0);
    }
    if let Some(structure) = frame.structure.as_ref().filter(|_| frame.fluid.is_none()) {
        let places = || structure.positions_m.iter();
        let extent = |axis: usize| {
            let ends = places().fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], p| {
                [low.min(p[axis]), high.max(p[axis])]
            });
            ends[1] - ends[0]
        };
        if extent(2) < FLAT * extent(0).min(extent(1)) {
            options.elevation_deg = 55.0;
        }
    }
    if scene.body.is_none() {
        // A body is small in its tunnel: its wake matters.
        options.whole_domain = !scene.rigid_bodies.is_empty();
    }
    if let (Some(body), Some(structure)) = (&scene.body, &frame.structure)
        && let BodyKind::Canopy(canopy) = &body.kind
    {
        // The same box for all pictures of a run, so that the camera stands still.
        let confluence = canopy.confluence_m(&structure.positions_m);
        let reach = canopy.nominal_diameter_m;
        options.framing_box_m = Some([
            confluence - DVec3::new(0.1, 0.6, 0.6) * reach,
            confluence + DVec3::new(2.3, 0.6, 0.6) * reach,
        ]);
    }
    if let Some(wing) = scene.wing()
        && let Some(tunnel) = &wing.tunnel
    {
        // Of the fabric as designed, with some wake.
        let fabric = &tunnel.designed_m[..wing.built.hang_points[0] as usize];
        let (low, high) = fabric.iter().fold(
            (DVec3::INFINITY, DVec3::NEG_INFINITY),
            |(low, high), place| (low.min(*place), high.max(*place)),
        );
        let chord = wing.built.measures.largest_chord_m;
        options.framing_box_m = Some([
            low - DVec3::new(0.3, 0.0, 0.3) * chord,
            high + DVec3::new(0.8, 0.0, 0.4) * chord,
        ]);
    }
    options
}

/// The middle of the middle cell of a wing in the wind, or of that right of the middle.
fn section_through_the_middle(scene: &Scene, frame: &Frame) -> Option<Section> {
    let known = scene.wing().filter(|wing| wing.tunnel.is_some())?;
    let wing = &known.built;
    let structure = frame.structure.as_ref()?;
    let skin = wing.middle_skin_m(wing.cells / 2, &structure.positions_m);
    Some(Section {
        y_m: skin.iter().map(|p| p.y).sum::<f64>() / skin.len() as f64,
        outlines_m: vec![skin],
    })
}
