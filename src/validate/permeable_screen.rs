//! A permeable screen across a duct: the velocity of the air through it against the pressure difference, Ergun's law.
//!
//! The duct repeats along all axes. A uniform force per mass drives the air along x; once the flow is steady, force times length is the
//! pressure difference across the screen exactly, whatever the scheme does, and the mean velocity of the air is to be
//! v = 2Δp/(r + √(r² + 4 s Δp)). What is more is the slip that one pass leaves, (1 − 3a/8) Δp/(2a) in lattice units. The screen is a rigid
//! surface, or a sheet of taut fabric that the air holds back inside the fabric's own implicit step.

use glam::DVec3;

use super::flows::{periodic, states};
use super::report::Gate;
use super::session::{Session, Stop};
use crate::cloth::Structure;
use crate::cloth::rims::RimInsets;
use crate::cpu::cloth::{
    Cloth, InitialHessian, MarkerReaction, SolverSettings, StepInput, TriangleReaction,
};
use crate::cut_links::Passage;
use crate::fabric::Fabric;
use crate::fabric::permeability::Permeability;
use crate::geometry::sheet::{self, FabricModel, SheetShape};
use crate::immersed::markers::{self, Marker};
use crate::immersed::permeable::{Permeable, Resistance};
use crate::lattice::Operator;
use crate::simulation::{AirEngine, CutSurface, MarkerEngine};
use crate::solve::lbfgs::HISTORY;

/// Cells along and across the duct.
const CELLS: [usize; 3] = [24, 6, 6];

/// Where the screen is along x, between two planes of cells.
const SCREEN_X: f64 = 11.3;

/// Viscous and inertial resistance [lattice units].
const LAW: Permeability = Permeability {
    viscous_pa_s_m: 0.02,
    inertial_kg_m3: 1.0,
};

/// Pressure differences, over two decades [lattice units]; dynamic pressure at the usual 0.06 is 1.8e-3.
const PRESSURES: [f64; 3] = [2e-5, 2e-4, 2e-3];

/// Steps until the flow has settled.
const STEPS: usize = 3000;

/// Largest relative error of the velocity (gate I8).
const BAND: f64 = 0.03;

/// The same at cut links, which leave no slip: half of this small sheet's nodes lie on its edge, and stand for another area than for links.
const BAND_OF_LINKS: f64 = 0.02;

/// Usual over-relaxation, and that which leaves no slip on a flat sheet.
const OVER_RELAXATIONS: [f64; 2] = [1.6, 8.0 / 3.0];

pub(super) fn compute(session: &mut Session) -> Result<(), Stop> {
    for (fabric, what) in [(false, "rigid"), (true, "fabric")] {
        for pressure in PRESSURES {
            let velocity = velocity(session, pressure, &Scheme::Links, fabric)?;
            let exact = LAW.through_velocity_m_s(pressure);
            session
                .row(
                    CELLS,
                    format!("{what}, cut links, pressure {pressure:.0e}: velocity"),
                    velocity,
                )
                .reference(exact, "Ergun's law")
                .gate(Gate::Within(BAND_OF_LINKS));
        }
    }
    for (fabric, what) in [(false, "rigid"), (true, "fabric")] {
        for a in OVER_RELAXATIONS {
            for pressure in PRESSURES {
                let velocity = velocity(session, pressure, &Scheme::Kernel(a), fabric)?;
                let exact = LAW.through_velocity_m_s(pressure);
                session
                    .row(
                        CELLS,
                        format!("{what}, a = {a:.2}, pressure {pressure:.0e}: velocity"),
                        velocity,
                    )
                    .reference(exact, "Ergun's law")
                    .gate(Gate::Within(BAND));
            }
        }
    }
    Ok(())
}

/// A sheet across the duct, held at its edge, tight enough not to bulge; a cell, a step and the density of the air are the units.
fn screen() -> Result<Structure, Stop> {
    let [_, ny, nz] = CELLS;
    let shape = SheetShape {
        size_m: [ny as f64, nz as f64],
        divisions: [ny, nz],
        corner_m: DVec3::new(SCREEN_X + 0.5, 0.0, 0.0),
        across: DVec3::Y,
        down: DVec3::Z,
    };
    let fabric = Fabric {
        thickness_m: 1.0,
        density_kg_m3: 0.5,
        warp_modulus_pa: 100.0,
        weft_modulus_pa: 100.0,
        poisson_ratio: 0.3,
        shear_modulus_pa: 40.0,
        cubic_shear_compliance_1_pa3: None,
        residual_stiffness: 1e-3,
        initial_strain: [0.05; 2],
        yield_stress_pa: None,
    };
    let mut structure = sheet::build(&shape, &fabric, FabricModel::Membrane)
        .ok_or_else(|| Stop::Refused("the sheet across the duct cannot be built".to_owned()))?;
    for (held, place) in structure.held.iter_mut().zip(&structure.positions_m) {
        *held = [[place.y, ny as f64], [place.z, nz as f64]]
            .iter()
            .any(|[at, size]| *at <= 0.0 || at >= size);
    }
    Ok(structure)
}

/// The screen that cuts links.
struct CutScreen {
    cloth: Cloth,
    surface: CutSurface,
    free: bool,
}

impl CutScreen {
    fn new(air: &AirEngine, free: bool) -> Result<Self, Stop> {
        let structure = screen()?;
        let triangles: Vec<[u32; 3]> = structure.triangles.iter().map(|t| t.nodes).collect();
        let passage = Passage::Fabric([LAW.viscous_pa_s_m, LAW.inertial_kg_m3]);
        let passages = vec![passage; triangles.len()];
        let areas: Vec<f64> = structure.triangles.iter().map(|t| t.rest_area_m2).collect();
        let surface = CutSurface::new(air, triangles, structure.node_count(), (0, None));
        Ok(Self {
            surface: surface.permeable(&passages, &areas),
            cloth: Cloth::new(structure),
            free,
        })
    }

    /// One step of the coupling.
    fn exchange(&mut self, air: &mut AirEngine) -> Result<(), Stop> {
        let half = DVec3::splat(0.5);
        let positions: Vec<DVec3> = self.cloth.positions_m.iter().map(|x| *x - half).collect();
        let left = |_| Stop::Refused("the screen left the duct".to_owned());
        self.surface.find_links(&positions).map_err(left)?;
        self.surface.read_links(air)?;
        self.surface.fetch_links(air, &self.cloth.velocities_m_s)?;
        if self.free {
            let count = self.surface.triangles().len() as u32;
            let mut reactions: Vec<_> = (0..count).map(TriangleReaction::none).collect();
            for (cut, reaction) in self.surface.reactions() {
                reactions[cut.triangle as usize].add(
                    cut.weights,
                    reaction.leaving,
                    [reaction.stiffness, reaction.push],
                );
            }
            let input = StepInput {
                time_step_s: Some(1.0),
                cut_triangles: &reactions,
                ..StepInput::default()
            };
            self.cloth.solve_cloth(&input, &SETTINGS);
        }
        self.surface.bounce(air, &self.cloth.velocities_m_s)?;
        Ok(())
    }
}

/// The screen with its markers.
struct Screen {
    cloth: Cloth,
    markers: Vec<Marker>,
    immersed: MarkerEngine,
    free: bool,
}

impl Screen {
    fn new(air: &AirEngine, over_relaxation: f64, free: bool) -> Result<Self, Stop> {
        let structure = screen()?;
        let markers = markers::place(structure.extents(&RimInsets::NONE), 1.0);
        let areas = markers.iter().map(|marker| marker.area_m2).collect();
        Ok(Self {
            immersed: MarkerEngine::new(air, areas, over_relaxation)?,
            cloth: Cloth::new(structure),
            markers,
            free,
        })
    }

    fn at(&self, marker: &Marker, field: &[DVec3]) -> DVec3 {
        let nodes = self.cloth.structure.triangles[marker.triangle as usize].nodes;
        nodes
            .iter()
            .zip(marker.weights)
            .map(|(&node, weight)| field[node as usize] * weight)
            .sum()
    }

    /// What a marker lets pass now.
    fn permeable(&self, k: usize) -> Permeable {
        let marker = &self.markers[k];
        let triangle = &self.cloth.structure.triangles[marker.triangle as usize];
        let [a, b, c] = triangle.nodes.map(|n| self.cloth.positions_m[n as usize]);
        let doubled = (b - a).cross(c - a);
        let area = marker.area_m2 * 0.5 * doubled.length() / triangle.rest_area_m2;
        let stiffness = self.immersed.stiffness(k) / area;
        Permeable {
            normal: doubled.normalize_or_zero().to_array(),
            resistance: Resistance {
                viscous: LAW.viscous_pa_s_m / stiffness,
                inertial: LAW.inertial_kg_m3 / stiffness,
            },
        }
    }

    /// One step of the coupling.
    fn exchange(&mut self, air: &AirEngine) -> Result<(), Stop> {
        let half = DVec3::splat(0.5);
        let positions: Vec<[f64; 3]> = self
            .markers
            .iter()
            .map(|marker| (self.at(marker, &self.cloth.positions_m) - half).to_array())
            .collect();
        let left = |_| Stop::Refused("the screen left the duct".to_owned());
        self.immersed.send_markers(air, &positions)?.map_err(left)?;
        self.immersed.interpolate(air, &positions)?.map_err(left)?;
        self.immersed.fetch_air_velocities()?;
        let permeable: Vec<Permeable> =
            (0..self.markers.len()).map(|k| self.permeable(k)).collect();
        let velocities = self.immersed.air_velocities().to_vec();
        if self.free {
            let reactions: Vec<MarkerReaction> = self
                .markers
                .iter()
                .enumerate()
                .map(|(k, marker)| MarkerReaction {
                    triangle: marker.triangle,
                    weights: marker.weights,
                    stiffness_kg_s: self.immersed.stiffness(k),
                    air_velocity_m_s: DVec3::from_array(velocities[k]),
                    across: None,
                })
                .collect();
            let input = StepInput {
                time_step_s: Some(1.0),
                markers: &reactions,
                permeable: &permeable,
                ..StepInput::default()
            };
            self.cloth.solve_cloth(&input, &SETTINGS);
        }
        let targets: Vec<[f64; 3]> = self
            .markers
            .iter()
            .enumerate()
            .map(|(k, marker)| {
                let own = self.at(marker, &self.cloth.velocities_m_s).to_array();
                let through = permeable[k].through(own, velocities[k]);
                std::array::from_fn(|a| own[a] + through[a])
            })
            .collect();
        self.immersed.send_marker_forces(&targets);
        self.immersed.spread(&targets);
        Ok(())
    }
}

const SETTINGS: SolverSettings = SolverSettings {
    tolerance: 1e-4,
    displacement_floor_m: 1e-9,
    evaluation_limit: 500,
    history: HISTORY,
    refresh_every: None,
    initial_hessian: InitialHessian::BlockJacobi,
};

/// How screen and air meet.
enum Scheme {
    /// Through markers of this over-relaxation.
    Kernel(f64),
    /// At cut links.
    Links,
}

enum AnyScreen {
    Kernel(Box<Screen>),
    Links(Box<CutScreen>),
}

/// Mean velocity of the air in the steady state.
fn velocity(
    session: &mut Session,
    pressure: f64,
    scheme: &Scheme,
    free: bool,
) -> Result<f64, Stop> {
    let start = LAW.through_velocity_m_s(pressure);
    let setup = periodic(CELLS, 0.6, Operator::RecursiveRegularised);
    let mut air = session.air(setup, &|_| (0.0, [start, 0.0, 0.0]))?;
    let mut screen = match scheme {
        Scheme::Kernel(over_relaxation) => {
            AnyScreen::Kernel(Box::new(Screen::new(&air, *over_relaxation, free)?))
        }
        Scheme::Links => AnyScreen::Links(Box::new(CutScreen::new(&air, free)?)),
    };
    let acceleration = Some([pressure / CELLS[0] as f64, 0.0, 0.0]);
    let mut sum = 0.0;
    for step in 0..STEPS {
        match &mut screen {
            AnyScreen::Kernel(screen) => {
                screen.exchange(&air)?;
                air.collide_stream(acceleration, Some(&screen.immersed))?;
            }
            AnyScreen::Links(screen) => {
                air.collide_stream(acceleration, None)?;
                screen.exchange(&mut air)?;
            }
        }
        if step.is_multiple_of(100) {
            session.check_interrupt()?;
        }
        // What sound is left goes back and forth in less than that.
        if step + 64 >= STEPS {
            let states = states(&air)?;
            let count = states.len() as f64;
            let momentum: f64 = states.iter().map(|(excess, u)| (1.0 + excess) * u[0]).sum();
            sum += momentum / count / 64.0;
        }
    }
    session.progress_to(session.done + 1e-6 * (STEPS * CELLS.iter().product::<usize>()) as f64);
    Ok(sum)
}
