//! Fabric: error against seconds and against evaluations, for two membranes with known answers, over mesh size, model and engine.
//!
//! * *Hencky's disc* (ν = 1/3, small load): deflection of the middle, w₀ = c (q a/(E h))^⅓ a, c = 0.6447764 from Hencky's equations (Hencky 1915,
//!   corrected by Fichter 1997) integrated by Runge and Kutta's method; published to four digits, 0.6448. Springs lie along the edges of the
//!   same triangles, k = E h ΣA/l² (Van Gelder 1998), which stands for ν = 1/3 alone.
//! * The *airbag* of Contri & Schrefler (1988): half its height. The error is taken against our own membrane refined without end
//!   (0.21608 m); literature has 0.2167 m. Springs are those of paper P0 on its square cells, which have C₁₂ = G in place of
//!   the fabric's Poisson ratio, and keep the residual stiffness of the membrane when they push.
//!
//! Membranes on the host are solved by Newton's method, all else by L-BFGS, both with multigrid cycles; to 1e-4 of the loads in the energy
//! norm, the disc on the host to 1e-5. Forces of a device are in `f32`. Seconds are wall time of the solve with the set-up of its levels.

use std::path::Path;
use std::sync::Arc;
use std::time::Instant;

use glam::DVec3;
use kuva::prelude::{Layout, LinePlot, Plot, ScatterPlot};

use super::{Engine, Stop, Watch, go_on, plots, write_rows};
use crate::cloth::{Spring, Structure};
use crate::cpu::cloth::{Cloth, InitialHessian, Pressure, SolverSettings, StepInput};
use crate::fabric::{Fabric, network};
use crate::geometry::{airbag, fabric_surface, surfaces};
use crate::gpu::Device;
use crate::gpu::cloth::Cloth as DeviceCloth;
use crate::plan::Precision;
use crate::solve::lbfgs::{self, HISTORY};

/// w₀ over (q a/(E h))^⅓ a for ν = 1/3.
const DEFLECTION: f64 = 0.644_776_4;

/// q a/(E h): slopes of 1 %, whose squares the theory leaves out.
const LOAD: f64 = 1e-6;

const RADIUS_M: f64 = 0.5;

/// Side, thickness and residual stiffness of the airbag.
const SIDE_M: f64 = 1.2 * std::f64::consts::FRAC_1_SQRT_2;
const THICKNESS_M: f64 = 6e-4;
const RESIDUAL: f64 = 1e-4;
const PRESSURE_PA: f64 = 5e3;

/// Half the height of the membrane bag on a mesh without end \[m\]: 0.215998, 0.216071, 0.216079 at 16, 32, 64 cells per side.
const HALF_HEIGHT_M: f64 = 0.21608;

/// Problems.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Problem {
    /// Hencky's disc.
    Disc,
    /// The square airbag.
    Airbag,
}

/// How fabric is modelled.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Model {
    /// Triangles.
    Membrane,
    /// Springs.
    Network,
}

/// One equilibrium.
#[derive(Debug, Clone, serde::Serialize)]
pub struct Point {
    /// What was computed.
    pub problem: Problem,
    /// Model of the fabric.
    pub model: Model,
    /// Who computed it, and in which arithmetic.
    pub engine: String,
    /// Rings of the disc, or cells along a side of the bag.
    pub size: usize,
    /// Nodes.
    pub nodes: usize,
    /// Deflection over its scale, or half the height [m].
    pub value: f64,
    /// Relative error.
    pub error: f64,
    /// Evaluations of energy and gradient.
    pub evaluations: usize,
    /// Wall time [s].
    pub seconds: f64,
    /// True if the tolerance was reached.
    pub converged: bool,
}

/// Computes all; writes `fabric.csv` and plots, `fabric-disc.png` and so on, into `folder`.
pub fn measure(
    full: bool,
    engines: &[Engine],
    folder: &Path,
    watch: &mut Watch,
) -> Result<Vec<Point>, Stop> {
    let sizes: [(Problem, &[usize]); 2] = if full {
        [
            (Problem::Disc, &[5, 10, 20, 40, 80, 160]),
            (Problem::Airbag, &[8, 16, 32, 64]),
        ]
    } else {
        [(Problem::Disc, &[5, 10, 20]), (Problem::Airbag, &[8, 16])]
    };
    // The fabric on the host is always in double precision.
    let mut arithmetics: Vec<Option<Arc<Device>>> = Vec::new();
    if engines.iter().any(|engine| engine.device.is_none()) {
        arithmetics.push(None);
    }
    arithmetics.extend(
        engines
            .iter()
            .find_map(|engine| engine.device.clone())
            .map(Some),
    );
    let count: usize = sizes.iter().map(|(_, sizes)| 2 * sizes.len()).sum();
    let total = (count * arithmetics.len()) as u64;
    let mut points = Vec::new();
    for (problem, sizes) in sizes {
        for model in [Model::Membrane, Model::Network] {
            for device in &arithmetics {
                for &size in sizes {
                    go_on(watch.interrupt)?;
                    points.push(point(problem, model, size, device.as_ref())?);
                    let done = points.len() as u64;
                    watch.observer.progress(done, total, "fabric");
                }
            }
        }
    }
    write_rows(&folder.join("fabric.csv"), &points)?;
    for (problem, name) in [(Problem::Disc, "disc"), (Problem::Airbag, "airbag")] {
        let file = |end: &str| folder.join(format!("fabric-{name}{end}.png"));
        plot(&file(""), &points, problem, true)?;
        plot(&file("-evaluations"), &points, problem, false)?;
    }
    Ok(points)
}

fn isotropic(modulus_pa: f64, poisson_ratio: f64, thickness_m: f64, residual: f64) -> Fabric {
    Fabric {
        thickness_m,
        density_kg_m3: 500.0,
        warp_modulus_pa: modulus_pa,
        weft_modulus_pa: modulus_pa,
        poisson_ratio,
        shear_modulus_pa: Fabric::isotropic_shear_modulus_pa(modulus_pa, poisson_ratio),
        cubic_shear_compliance_1_pa3: None,
        residual_stiffness: residual,
        initial_strain: [0.0; 2],
        yield_stress_pa: None,
    }
}

/// What is solved, what acts, and how the answer is read.
struct Setting {
    structure: Structure,
    gravity_m_s2: DVec3,
    pressure: Pressure<'static>,
    /// Half the distance of these nodes along the axis, or the place of one of them, over `scale`.
    nodes: [u32; 2],
    axis: DVec3,
    scale: f64,
    exact: f64,
}

fn disc(rings: usize, model: Model) -> Result<Setting, Stop> {
    let (modulus_pa, thickness_m) = (4e8, 1e-4);
    let fabric = isotropic(modulus_pa, 1.0 / 3.0, thickness_m, 0.0);
    let surface = surfaces::disk(RADIUS_M, RADIUS_M / rings as f64);
    let mut structure = fabric_surface::build(&surface, DVec3::Y, &fabric)
        .map_err(|index| Stop::Refused(format!("triangle {index} has no area")))?;
    if model == Model::Network {
        springs_of_triangles(&mut structure, modulus_pa * thickness_m);
    }
    let scale = LOAD.cbrt() * RADIUS_M;
    for (place, held) in structure.positions_m.iter_mut().zip(&mut structure.held) {
        let r = place.length() / RADIUS_M;
        *held = r > 1.0 - 1e-9;
        // A bulge to start from.
        place.x = 0.3 * scale * (1.0 - r * r).max(0.0);
    }
    let pressure_pa = LOAD * modulus_pa * thickness_m / RADIUS_M;
    Ok(Setting {
        structure,
        gravity_m_s2: DVec3::X * (pressure_pa / fabric.areal_density_kg_m2()),
        pressure: Pressure::None,
        nodes: [0, 0],
        axis: DVec3::X,
        scale,
        exact: DEFLECTION,
    })
}

fn bag(cells: usize, model: Model) -> Result<Setting, Stop> {
    let fabric = isotropic(5.88e8, 0.4, THICKNESS_M, RESIDUAL);
    let bag = airbag::build(SIDE_M, cells, &fabric)
        .ok_or_else(|| Stop::Refused(format!("{cells} cells are odd")))?;
    let mut structure = bag.structure;
    if model == Model::Network {
        springs_of_cells(&mut structure, &fabric, SIDE_M / cells as f64)?;
    }
    let [up, down] = bag.middles;
    Ok(Setting {
        structure,
        gravity_m_s2: DVec3::ZERO,
        pressure: Pressure::Uniform(PRESSURE_PA),
        nodes: [up, down],
        axis: DVec3::Z,
        scale: 1.0,
        exact: HALF_HEIGHT_M,
    })
}

/// Replaces the law of the triangles by springs along their edges.
fn springs_of_triangles(structure: &mut Structure, stiffness_n_m: f64) {
    let mut edges = std::collections::BTreeMap::new();
    for triangle in &structure.triangles {
        for (corner, square) in triangle.rest_squares_m2.into_iter().enumerate() {
            // The edge opposite the corner.
            let mut ends = [
                triangle.nodes[(corner + 1) % 3],
                triangle.nodes[(corner + 2) % 3],
            ];
            ends.sort_unstable();
            let edge = edges.entry(ends).or_insert((square, 0.0));
            edge.1 += triangle.rest_area_m2;
        }
    }
    structure.membrane = None;
    for (nodes, (square, area)) in edges {
        let stiffness = stiffness_n_m * area / square;
        structure.springs.push(Spring {
            nodes,
            rest_length_m: f64::sqrt(square),
            stiffness_n_m: stiffness,
            compressive_stiffness_n_m: stiffness,
        });
    }
}

/// Replaces the law of a bag's square cells by springs along their sides and both diagonals. Triangles come in fours: the first half of
/// a cell above and below, then the second half of both.
fn springs_of_cells(structure: &mut Structure, fabric: &Fabric, cell_m: f64) -> Result<(), Stop> {
    let stiffness = network::cell_stiffness(fabric, [cell_m; 2])
        .ok_or_else(|| Stop::Refused("a spring of the network would push".to_owned()))?;
    let mut sides = std::collections::BTreeMap::new();
    for halves in structure.triangles.chunks(4) {
        let [a, b, c, d] = halves else { continue };
        for [first, second] in [[a, c], [b, d]] {
            let mut nodes: Vec<u32> = first.nodes.into_iter().chain(second.nodes).collect();
            nodes.sort_unstable();
            nodes.dedup();
            for (i, &p) in nodes.iter().enumerate() {
                for &q in &nodes[i + 1..] {
                    let [p_m, q_m] = [p, q].map(|n| {
                        let place: DVec3 = structure.positions_m[n as usize];
                        place.truncate()
                    });
                    let flat_m = p_m.distance(q_m);
                    let is_diagonal = flat_m > 1.2 * cell_m;
                    let share = if is_diagonal {
                        stiffness.diagonal
                    } else {
                        0.5 * stiffness.along_x
                    };
                    let length_m = if is_diagonal {
                        cell_m * std::f64::consts::SQRT_2
                    } else {
                        cell_m
                    };
                    sides.entry([p, q]).or_insert((length_m, 0.0)).1 += share;
                }
            }
        }
    }
    structure.membrane = None;
    for (nodes, (rest_length_m, stiffness_n_m)) in sides {
        structure.springs.push(Spring {
            nodes,
            rest_length_m,
            stiffness_n_m,
            compressive_stiffness_n_m: fabric.residual_stiffness * stiffness_n_m,
        });
    }
    Ok(())
}

fn point(
    problem: Problem,
    model: Model,
    size: usize,
    device: Option<&Arc<Device>>,
) -> Result<Point, Stop> {
    let setting = match problem {
        Problem::Disc => disc(size, model)?,
        Problem::Airbag => bag(size, model)?,
    };
    let mut cloth = Cloth::new(setting.structure.clone());
    let input = StepInput {
        gravity_m_s2: setting.gravity_m_s2,
        pressure: setting.pressure,
        ..StepInput::default()
    };
    let settings = SolverSettings {
        tolerance: if device.is_some() || problem == Problem::Airbag {
            1e-4
        } else {
            1e-5
        },
        displacement_floor_m: 0.0,
        evaluation_limit: 20_000,
        history: HISTORY,
        refresh_every: Some(10),
        initial_hessian: InitialHessian::Multigrid,
    };
    let mut on_device = device
        .map(|device| DeviceCloth::new(Arc::clone(device), &cloth.structure, &[]))
        .transpose()?;
    let began = Instant::now();
    let outcome = match &mut on_device {
        Some(device) => device.solve(&mut cloth, &input, &settings)?,
        None => cloth.solve_cloth(&input, &settings),
    };
    let seconds = began.elapsed().as_secs_f64();
    let along = |node: u32| cloth.positions_m[node as usize].dot(setting.axis) / setting.scale;
    let [a, b] = setting.nodes;
    let value = if a == b {
        along(a)
    } else {
        0.5 * (along(a) - along(b))
    };
    let engine = match device {
        Some(_) => "gpu f32".to_owned(),
        None => Engine::cpu(Precision::F64).name(),
    };
    Ok(Point {
        problem,
        model,
        engine,
        size,
        nodes: cloth.structure.node_count(),
        value,
        error: (value / setting.exact - 1.0).abs(),
        evaluations: outcome.evaluations,
        seconds,
        converged: outcome.stop == lbfgs::Stop::Converged,
    })
}

impl Point {
    const fn problem_name(&self) -> &'static str {
        match self.problem {
            Problem::Disc => "disc",
            Problem::Airbag => "airbag",
        }
    }

    const fn model_name(&self) -> &'static str {
        match self.model {
            Model::Membrane => "membrane",
            Model::Network => "network",
        }
    }
}

/// The equilibria as an aligned table.
#[must_use]
pub fn table(points: &[Point]) -> String {
    let mut text =
        "problem  model     engine     size    nodes  value      error      eval.  seconds\n"
            .to_owned();
    for p in points {
        text.push_str(&format!(
            "{:7}  {:8}  {:9}  {:5}  {:7}  {:.6}  {:7.3} %  {:6}  {:.3}{}\n",
            p.problem_name(),
            p.model_name(),
            p.engine,
            p.size,
            p.nodes,
            p.value,
            100.0 * p.error,
            p.evaluations,
            p.seconds,
            if p.converged { "" } else { "  not converged" }
        ));
    }
    text
}

/// Error of one problem over what it takes; meshes of a series are joined by a line.
fn plot(path: &Path, points: &[Point], problem: Problem, over_seconds: bool) -> Result<(), Stop> {
    let mut series: Vec<(String, Vec<(f64, f64)>)> = Vec::new();
    let results = points
        .iter()
        .filter(|p| p.problem == problem && p.converged && p.error > 0.0);
    for p in results {
        let name = format!("{}, {}", p.model_name(), p.engine);
        let work = if over_seconds {
            p.seconds
        } else {
            p.evaluations as f64
        };
        let place = (work, 100.0 * p.error);
        match series.iter_mut().find(|(known, _)| *known == name) {
            Some((_, data)) => data.push(place),
            None => series.push((name, vec![place])),
        }
    }
    if series.is_empty() {
        // Logarithmic axes need a point.
        return Ok(());
    }
    let mut plots: Vec<Plot> = Vec::new();
    for (i, (name, data)) in series.into_iter().enumerate() {
        let colour = plots::COLOURS[i % plots::COLOURS.len()];
        plots.push(
            LinePlot::new()
                .with_data(data.clone())
                .with_color(colour)
                .with_legend(name)
                .into(),
        );
        plots.push(
            ScatterPlot::new()
                .with_data(data)
                .with_color(colour)
                .with_marker(plots::SHAPES[i % plots::SHAPES.len()])
                .with_size(4.0)
                .into(),
        );
    }
    let title = match problem {
        Problem::Disc => "Hencky's disc, ever finer meshes: deflection of the middle",
        Problem::Airbag => "Airbag, ever finer meshes: half its height",
    };
    let layout = Layout::auto_from_plots(&plots)
        .with_log_scale()
        .with_title(title)
        .with_x_label(if over_seconds {
            "time of the solve [s]"
        } else {
            "evaluations of energy and gradient"
        })
        .with_y_label("error [%]");
    plots::write(path, plots, layout)
}
