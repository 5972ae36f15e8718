//! The plan as text, for `ripstop check`.

use std::fmt::{self, Write};

use glam::DVec3;

use super::disk::megabytes;
use super::{
    AirPlacement, ClothPlacement, Evaluations, Plan, STEPS_OF_A_SERIES, cadence, descent, disk,
    friction, levels, meshes, openings, permeability, phases, wing,
};
use crate::case::Scene;
use crate::case::coupling::{Coupling, Scheme};
use crate::case::scene::{Air, Body, BodyKind, Carrier, Flow};
use crate::cloth::patches::{Patches, REACH};
use crate::cloth::{Structure, TimeIntegration};
use crate::geometry::plate::Plate;
use crate::immersed::markers;

/// Loads and velocities of single nodes, where the case gives any.
fn write_loads(out: &mut String, structure: &Structure) -> fmt::Result {
    if !structure.loads_n.is_empty() {
        let all: DVec3 = structure.loads_n.iter().sum();
        writeln!(
            out,
            "  loads on nodes      ({:.4}, {:.4}, {:.4}) N in all",
            all.x, all.y, all.z
        )?;
    }
    let moving = structure.start_velocities_m_s.iter();
    let moving = moving.filter(|v| **v != DVec3::ZERO).count();
    if moving > 0 {
        writeln!(out, "  moving at the start {moving} nodes")?;
    }
    Ok(())
}

/// A number of any size with three digits.
fn three_digits(number: f64) -> String {
    let rounded = format!("{number:.2e}");
    match rounded.parse::<f64>() {
        Ok(plain) if (1e-3..1e6).contains(&plain) => plain.to_string(),
        _ => rounded,
    }
}

/// Numbers without dimension of a plate with the mass per area `areal_kg_m2`.
fn write_plate(out: &mut String, plate: &Plate, air: &Air, areal_kg_m2: f64) -> fmt::Result {
    let length_m = plate.size_m[0];
    let speed_m_s = air.wind_or_reference_m_s();
    let density_kg_m3 = air.units.density_kg_m3;
    let section_m2 = air.section_m2();
    let stiffness_nm = density_kg_m3 * speed_m_s.powi(2) * length_m.powi(3);
    writeln!(
        out,
        "  Reynolds number     U L/nu = {}",
        three_digits(speed_m_s * length_m / air.kinematic_viscosity_m2_s)
    )?;
    writeln!(
        out,
        "  blockage            {} % (all of the plate, which it may turn across the stream, over the section)",
        three_digits(100.0 * plate.area_m2() / section_m2)
    )?;
    writeln!(
        out,
        "  mass ratio          m* = rho_s h/(rho L) = {}",
        three_digits(areal_kg_m2 / (density_kg_m3 * length_m))
    )?;
    writeln!(
        out,
        "  bending stiffness   D/(rho U^2 L^3) = {} (D = {} N m)",
        three_digits(plate.flexural_rigidity_nm / stiffness_nm),
        three_digits(plate.flexural_rigidity_nm)
    )
}

impl Plan {
    /// A report of phases, stages, sizes, numbers that decide accuracy, and skips. `coarser` are the grids that the run begins on, coarsest first.
    #[must_use]
    pub fn report(&self, scene: &Scene, coarser: &[Scene], threads: usize) -> String {
        let mut text = format!("{}\n", scene.title);
        // Writing to a String cannot fail.
        let _ = phases::write(&mut text, scene, coarser);
        let _ = self.write_report(&mut text, scene, threads);
        text
    }

    fn write_report(&self, out: &mut String, scene: &Scene, threads: usize) -> std::fmt::Result {
        writeln!(out, "\nplacement")?;
        if scene.air.is_some() {
            let place = match self.placement.air {
                AirPlacement::Cpu(_) => format!("CPU, {threads} threads"),
                AirPlacement::Gpu(_) => self.device_name(),
            };
            writeln!(out, "  air                 {place}")?;
        }
        if let Some(body) = &scene.body {
            let place = match self.placement.cloth {
                ClothPlacement::Host if body.structure.contact.is_some() => {
                    "host memory (f64), where contact is searched for".to_owned()
                }
                ClothPlacement::Host => "host memory (f64)".to_owned(),
                ClothPlacement::Device => self.device_name(),
            };
            writeln!(out, "  fabric and cables   {place}")?;
        }
        if scene.time.is_some() {
            self.write_stages(out, scene)?;
        }
        let sizes = &self.sizes;
        if let Some(air) = &scene.air {
            let units = &air.units;
            let [nx, ny, nz] = air.cells;
            let tau = units.relaxation_time(air.kinematic_viscosity_m2_s);
            writeln!(out, "\nair")?;
            if air.boxes.is_empty() {
                writeln!(
                    out,
                    "  cells               {nx} x {ny} x {nz} = {} of {:.4} m",
                    sizes.cells, units.cell_size_m
                )?;
            } else {
                writeln!(
                    out,
                    "  cells               {} in {} lattices, of {:.4} m around the structure, {:.4} m outermost",
                    sizes.cells,
                    air.levels().len(),
                    units.cell_size_m,
                    air.outer_cell_size_m()
                )?;
                levels::write(out, self, air, threads)?;
            }
            writeln!(
                out,
                "  memory              {} ({}{})",
                megabytes(sizes.air_bytes),
                self.placement.precision_name(),
                if sizes.air_on_device {
                    ", on the device"
                } else {
                    ""
                }
            )?;
            writeln!(out, "  time step           {:.4e} s", units.time_step_s)?;
            writeln!(
                out,
                "  Mach on the lattice {:.3} (speed {} cells per step at {} m/s)",
                air.lattice_speed * 3f64.sqrt(),
                air.lattice_speed,
                air.reference_speed_m_s
            )?;
            writeln!(
                out,
                "  relaxation time     tau = 0.5 + {:.2e}{}",
                tau - 0.5,
                if air.boxes.is_empty() {
                    ""
                } else {
                    " around the structure"
                }
            )?;
            writeln!(out, "  operator            {}", air.operator.name())?;
            if let Some(eddy_viscosity) = air.eddy_viscosity {
                let model = eddy_viscosity.model;
                writeln!(
                    out,
                    "  eddy viscosity      {}, {} = {}",
                    model.name(),
                    model.symbol(),
                    eddy_viscosity.constant
                )?;
            }
            match &air.flow {
                Flow::WindTunnel {
                    speed_m_s,
                    start_time_s,
                    sponge_length_m,
                    sides,
                    inlet_profile,
                } => {
                    writeln!(
                        out,
                        "  wind                {speed_m_s} m/s, rising for {start_time_s} s before t = 0"
                    )?;
                    if let Some(profile) = inlet_profile {
                        writeln!(
                            out,
                            "  inlet profile       {:.3} of the wind in its mean, {:.3} at most",
                            profile.mean(),
                            profile.largest()
                        )?;
                    }
                    writeln!(out, "  sides               {}", sides.in_words())?;
                    if let Some(length) = sponge_length_m {
                        writeln!(out, "  outlet sponge       {length} m")?;
                    }
                }
                Flow::TaylorGreen { speed_m_s, side_m } => {
                    writeln!(
                        out,
                        "  vortices            {speed_m_s} m/s in a box of side {side_m} m"
                    )?;
                }
            }
        }
        if let Some(body) = &scene.body {
            writeln!(out, "\nstructure")?;
            writeln!(
                out,
                "  nodes, triangles, cable segments  {}, {}, {}",
                sizes.nodes, sizes.triangles, sizes.cables
            )?;
            if let BodyKind::Canopy(_) = &body.kind {
                writeln!(
                    out,
                    "  mass                {} kg: fabric, lines, belts and tapes",
                    three_digits(own_mass_kg(scene, body))
                )?;
            }
            writeln!(
                out,
                "  memory              {} (f64, on the host)",
                megabytes(sizes.structure_bytes)
            )?;
            if self.placement.cloth_on_device() {
                writeln!(
                    out,
                    "  on the device       {} (f32, positions finer)",
                    megabytes(sizes.structure_device_bytes)
                )?;
            }
            if let Some(quality) = body.quality {
                writeln!(
                    out,
                    "  triangle quality    smallest {:.3}, mean {:.3} (1 = equilateral); edges {:.4} to {:.4} m",
                    quality.smallest_shape,
                    quality.mean_shape,
                    quality.shortest_edge_m,
                    quality.longest_edge_m
                )?;
            }
            openings::write(out, scene)?;
            if let Some(contact) = body.structure.contact {
                writeln!(
                    out,
                    "  contact             pushes below {} m between the middle surfaces",
                    contact.thickness_m
                )?;
            }
            for support in &scene.supports {
                writeln!(
                    out,
                    "  moved support       {}: {} held nodes",
                    support.name,
                    support.nodes.len()
                )?;
            }
            write_loads(out, &body.structure)?;
            self.write_canopy(out, scene)?;
        }
        meshes::write(out, &scene.meshes)?;
        wing::write(out, scene)?;
        self.write_bodies(out, scene)?;
        permeability::write(out, scene)?;
        friction::write(out, scene)?;
        descent::write(out, scene)?;
        if self.steps > 0 {
            writeln!(
                out,
                "\ntime\n  steps               {} before release + {}",
                self.start_steps, self.steps
            )?;
        }
        if let (Some(time), true) = (scene.time, scene.fabric_is_solved()) {
            let order = match time.integration {
                TimeIntegration::BackwardEuler => "backward Euler, of first order",
                TimeIntegration::Bdf2 => "BDF2, of second order",
            };
            writeln!(out, "  motion of fabric    {order}")?;
        }
        if let Some(time) = scene.time
            && let Some(adaptive) = time.adaptive
        {
            writeln!(
                out,
                "  adaptive            steps of {:e} s, halved down to {:.3e} s where positions would err by more than {:e} m in one",
                time.step_s,
                adaptive.smallest_s(time.step_s),
                adaptive.tolerance_m
            )?;
        }
        if let Some(evaluations) = &self.evaluations {
            evaluations.write(out, self.evaluation_limit)?;
        }
        if self.steps > 0 && self.estimated_seconds(threads).is_none() {
            let why = match self.evaluations {
                Some(Evaluations::Unknown(_)) => "the evaluations are not",
                _ => "the speed of a device shows only when it runs",
            };
            writeln!(out, "  estimated duration  not known: {why}")?;
        }
        if let Some(seconds) = self.estimated_seconds(threads) {
            writeln!(
                out,
                "  estimated duration  about {seconds:.0} s on {threads} threads (a rough guess, not a promise)"
            )?;
        }
        writeln!(
            out,
            "  host memory in all  {}",
            megabytes(sizes.host_bytes())
        )?;
        disk::write(out, self, scene)?;
        writeln!(out, "\nskipped")?;
        for skip in &self.skips {
            writeln!(out, "  {:<45} {}", skip.what, skip.why)?;
        }
        let warnings = self.warnings(scene);
        if !warnings.is_empty() {
            writeln!(out, "\nwarnings")?;
        }
        for warning in warnings {
            writeln!(out, "  {warning}")?;
        }
        Ok(())
    }

    fn write_stages(&self, out: &mut String, scene: &Scene) -> std::fmt::Result {
        writeln!(out, "\nstages of a step")?;
        for planned in &self.stages {
            let cadence = if planned.every == 1 {
                String::new()
            } else {
                format!(" (every {} steps)", planned.every)
            };
            writeln!(
                out,
                "  {:<20} {}{cadence}",
                planned.stage.name(),
                planned.stage.flow()
            )?;
        }
        if self.may_make_series(scene) {
            let may = match self.answers_on_device() {
                true => "makes",
                false => "may make, where one workgroup solves the fabric (docs/device-time.md),",
            };
            writeln!(
                out,
                "  the device {may} up to {STEPS_OF_A_SERIES} of these steps without waiting for the host"
            )?;
        }
        Ok(())
    }

    fn device_name(&self) -> String {
        let name = self.placement.device.as_deref().unwrap_or("not named");
        format!("device {name}")
    }

    fn write_canopy(&self, out: &mut String, scene: &Scene) -> std::fmt::Result {
        let (Some(air), Some(body), Some(coupling)) = (&scene.air, &scene.body, &scene.coupling)
        else {
            return Ok(());
        };
        let cell = air.units.cell_size_m;
        let structure = &body.structure;
        let areal_kg_m2 = own_mass_kg(scene, body) / structure.rest_area_m2();
        let ratio = three_digits(areal_kg_m2 / (air.units.density_kg_m3 * cell));
        writeln!(out, "\ncoupling")?;
        self.write_scheme(out, scene, (air, coupling))?;
        cadence::write(out, scene)?;
        writeln!(
            out,
            "  mass ratio          m_s/(rho cell) = {ratio} (mass of fabric, lines and belts per area of fabric over air in one cell)"
        )?;
        if let BodyKind::Plate(plate) = &body.kind {
            let [length, width] = plate.size_m.map(|size| size / cell);
            write!(
                out,
                "  cells over plate    {length:.1} along, {width:.1} across"
            )?;
            match coupling.scheme {
                Scheme::Kernel => writeln!(
                    out,
                    "; markers stand {} cells inside its rim",
                    coupling.rim_inset_cells
                )?,
                Scheme::Links => writeln!(out)?,
            }
            write_plate(out, plate, air, areal_kg_m2)?;
        } else if coupling.scheme == Scheme::Kernel {
            writeln!(
                out,
                "  rims                markers stand {} cells inside them, on {:.0} % of the fabric",
                coupling.rim_inset_cells,
                100.0 * body.marked_share(&coupling.rim_insets(structure, air))
            )?;
        }
        if let BodyKind::Canopy(canopy) = &body.kind {
            let diameter = canopy.nominal_diameter_m;
            writeln!(
                out,
                "  cells per D_0       {:.1} (D_0 = {diameter:.4} m)",
                diameter / cell
            )?;
            let released = body.released_diameter_ratio(canopy);
            writeln!(
                out,
                "  cells across mouth  {:.1} at release (D_p/D_0 = {released:.3}), about {:.1} inflated (0.7)",
                released * diameter / cell,
                0.7 * diameter / cell
            )?;
            let section = air.section_m2();
            writeln!(
                out,
                "  blockage            S_0/section = {:.1} %",
                100.0 * canopy.nominal_area_m2 / section
            )?;
            if let Flow::WindTunnel { speed_m_s, .. } = air.flow {
                writeln!(
                    out,
                    "  Reynolds number     {:.2e}",
                    speed_m_s * diameter / air.kinematic_viscosity_m2_s
                )?;
            }
        }
        Ok(())
    }

    /// How surfaces meet the air.
    fn write_scheme(
        &self,
        out: &mut String,
        scene: &Scene,
        (air, coupling): (&Air, &Coupling),
    ) -> std::fmt::Result {
        let bytes = megabytes(self.sizes.marker_bytes);
        match coupling.scheme {
            Scheme::Kernel => {
                writeln!(
                    out,
                    "  markers             {} ({bytes})",
                    self.sizes.markers
                )?;
                writeln!(
                    out,
                    "  forcing             over-relaxation a = {}, {} pass(es)",
                    coupling.over_relaxation, coupling.passes
                )
            }
            Scheme::Links => {
                writeln!(
                    out,
                    "  cut links           about {} ({bytes}), found anew in every step that the surface moves",
                    self.sizes.links
                )?;
                let structure = scene.body.as_ref().map(|body| &body.structure);
                let patches =
                    structure.and_then(|s| Patches::new(&s.triangles, air.units.cell_size_m));
                match patches {
                    Some(patches) => writeln!(
                        out,
                        "  shared reactions    what the air does to a triangle is shared by {:.1} in the mean, within {REACH} cells",
                        patches.mean_size()
                    ),
                    None => Ok(()),
                }
            }
        }
    }

    fn write_bodies(&self, out: &mut String, scene: &Scene) -> std::fmt::Result {
        let (Some(air), Some(coupling), false) =
            (&scene.air, &scene.coupling, scene.rigid_bodies.is_empty())
        else {
            return Ok(());
        };
        let cell = air.units.cell_size_m;
        let spacing_m = coupling.marker_spacing_m(air);
        let section = air.section_m2();
        writeln!(out, "\nrigid bodies")?;
        if scene.body.is_none() {
            self.write_scheme(out, scene, (air, coupling))?;
        }
        for body in &scene.rigid_bodies {
            let markers = match coupling.scheme {
                Scheme::Kernel => {
                    let own = markers::count(body.marker_surface.extents(), spacing_m);
                    format!("{own} markers on ")
                }
                Scheme::Links => String::new(),
            };
            writeln!(
                out,
                "  {}: {markers}{} triangles, {}",
                body.name,
                body.surface.triangles.len(),
                if body.volume_m3.is_some() {
                    "closed"
                } else {
                    "open"
                }
            )?;
            writeln!(
                out,
                "    cells across      {:.1} (L = {:.4} m)",
                body.reference_length_m / cell,
                body.reference_length_m
            )?;
            writeln!(
                out,
                "    blockage          frontal area over section = {:.2} % (coefficients refer to S = {:.4e} m2)",
                100.0 * body.blocking_area_m2 / section,
                body.reference_area_m2
            )?;
            writeln!(
                out,
                "    Reynolds number   {:.3e}",
                body.reference_speed_m_s(air) * body.reference_length_m
                    / air.kinematic_viscosity_m2_s
            )?;
            if body.motion.moves() {
                let fastest = body.fastest_m_s;
                writeln!(
                    out,
                    "    moves             at most {fastest:.3} m/s, {:.3} cells per step",
                    fastest / air.units.speed_m_s()
                )?;
            } else {
                writeln!(out, "    moves             not at all")?;
            }
            if !body.faces.is_empty() {
                let faces: Vec<&str> = body.faces.iter().map(|face| face.name()).collect();
                writeln!(out, "    passes through    {}", faces.join(", "))?;
                writeln!(
                    out,
                    "    {:<18}what lies outside is left out; kernels are mirrored at sides, the last cell stands for those beyond the outlet",
                    ""
                )?;
            }
        }
        Ok(())
    }
}

/// Mass of a structure without what hangs on it.
fn own_mass_kg(scene: &Scene, body: &Body) -> f64 {
    let payload = (scene.descent.as_ref()).map_or(0.0, |descent| match descent.carrier {
        Carrier::Confluence { .. } => descent.all_masses_kg(),
        Carrier::RigidBody { .. } => 0.0,
    });
    body.structure.masses_kg.iter().sum::<f64>() - payload
}
