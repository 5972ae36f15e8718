//! Trim of a rigid elliptic wing: angle, speed and glide against lifting-line theory, and the loads' balance.
//!
//! The section has the polar C_l = k a₀ sin α, C_d constant, so a wing of the aspect ratio Λ has, by lifting-line theory with elliptic loading,
//! C_L = a φ with a = k a₀/(1 + k a₀/(πΛ)) and C_D = C_d + C_L²/(πΛ), acting at the quarter chord (Prandtl 1918; Katz & Plotkin 2001,
//! section 8.1). The angle follows from the moment about the hang point, by bisection of what is written out here.

use std::f64::consts::PI;

use glam::DVec3;

use super::super::report::Gate;
use super::super::session::{Session, Stop};
use crate::aero::polar::{Polar, PolarPoint, SectionFlow};
use crate::fabric::Fabric;
use crate::geometry::wing::frames::Station;
use crate::geometry::wing::plan::{Fineness, PartFabrics, Plan};
use crate::geometry::wing::section::Profile;
use crate::geometry::wing::{BuiltWing, build};
use crate::trim::balance::stream;
use crate::trim::{Flight, Glider, SectionSettings, Settings, Tolerance, TrimError};

/// Span [m].
const SPAN: f64 = 12.0;

/// Chord in the middle [m].
const CHORD: f64 = 1.9;

/// Share of potential flow's lift that the section has.
const LIFT_SHARE: f64 = 0.9;

const SECTION_DRAG: f64 = 0.02;

const PILOT_KG: f64 = 90.0;

const PILOT_AREA_M2: f64 = 0.4;

const DENSITY: f64 = 1.2;

const GRAVITY: f64 = 9.81;

/// The hang point, from the nose of the middle [m]: ahead of the quarter chord, so that lift keeps the nose down.
const HANG: DVec3 = DVec3::new(0.0, 0.2, -6.0);

/// Light, so that the wing's own weight enters without mattering.
const FABRIC: Fabric = Fabric {
    thickness_m: 5e-5,
    density_kg_m3: 760.0,
    warp_modulus_pa: 6e8,
    weft_modulus_pa: 6e8,
    poisson_ratio: 0.15,
    shear_modulus_pa: 8e7,
    cubic_shear_compliance_1_pa3: None,
    residual_stiffness: 1e-3,
    initial_strain: [0.0; 2],
    yield_stress_pa: None,
};

impl From<TrimError> for Stop {
    fn from(error: TrimError) -> Self {
        Self::Refused(error.to_string())
    }
}

fn wing(cells: usize, along_chord: usize) -> Result<BuiltWing, Stop> {
    let stations = (0..=30)
        .map(|i| {
            let share = (0.5 * PI * f64::from(i) / 30.0).sin();
            let chord_m = CHORD * (1.0 - share * share).sqrt().max(0.03);
            Station {
                span_m: 0.5 * SPAN * share,
                chord_m,
                // Straight at the quarter chord.
                sweep_m: 0.25 * (CHORD - chord_m),
                roll_rad: 0.0,
                twist_rad: 0.0,
                profile: 0,
            }
        })
        .collect();
    let profile = Profile::naca("0012");
    let profile = profile.ok_or_else(|| Stop::Refused("NACA 0012 is no profile".to_owned()))?;
    let plan = Plan {
        profiles: vec![profile],
        stations,
        cells,
        tip_cell_width_ratio: 0.3,
        rib_places_m: None,
        ballooning: [Vec::new(), Vec::new()],
        intakes: None,
        holes: Vec::new(),
        mini_ribs_from: None,
        rows: Vec::new(),
        tapes: Vec::new(),
        rods: Vec::new(),
        vh_ribs: Vec::new(),
        hang_point_m: HANG,
        pitch_guide_n_m: None,
        fabrics: PartFabrics {
            upper: FABRIC,
            lower: FABRIC,
            ribs: FABRIC,
            diagonals: FABRIC,
        },
    };
    let fineness = Fineness {
        along_chord,
        across_cell: 2,
    };
    build(&plan, fineness).map_err(|fault| Stop::Refused(fault.to_string()))
}

/// Angle between stream and chord, speed and glide ratio by lifting-line theory.
fn lifting_line(wing: &BuiltWing, section_slope: f64) -> [f64; 3] {
    let area = wing.measures.flat_area_m2;
    let ratio = wing.measures.flat_aspect_ratio();
    let slope = section_slope / (1.0 + section_slope / (PI * ratio));
    let masses = wing.structure.masses_kg.iter();
    let mass: f64 = masses.clone().sum();
    let centre: DVec3 = masses
        .zip(&wing.structure.positions_m)
        .map(|(m, p)| *m * *p)
        .sum::<DVec3>()
        / mass;
    let coefficients = |angle: f64| {
        let lift = slope * angle;
        [lift, SECTION_DRAG + lift * lift / (PI * ratio)]
    };
    let glide = |angle: f64| {
        let [lift, drag] = coefficients(angle).map(|c| c * area);
        let drag = drag + PILOT_AREA_M2;
        (drag / lift, (PILOT_KG + mass) * GRAVITY / lift.hypot(drag))
    };
    let moment = |angle: f64| {
        let [lift, drag] = coefficients(angle).map(|c| c * area);
        let along = stream(angle);
        let force = along * drag + DVec3::new(-along.z, 0.0, along.x) * lift;
        let (tangent, dynamic) = glide(angle);
        let (sin, cos) = (angle - tangent.atan()).sin_cos();
        let arm = centre - HANG;
        let of_weight = (arm.x * cos + arm.z * sin) * mass * GRAVITY;
        dynamic * (DVec3::X * 0.25 * CHORD - HANG).cross(force).y + of_weight
    };
    let (mut low, mut high) = (0.005, 0.4);
    for _ in 0..100 {
        let middle = 0.5 * (low + high);
        if moment(middle) > 0.0 {
            low = middle;
        } else {
            high = middle;
        }
    }
    let (tangent, dynamic) = glide(low);
    [low, (2.0 * dynamic / DENSITY).sqrt(), 1.0 / tangent]
}

/// What is left of force and moment over weight, and weight times height, once all loads act on the turned wing.
fn residuals(wing: &BuiltWing, glider: &Glider, flight: &Flight) -> [f64; 2] {
    let structure = &wing.structure;
    let positions = glider.turned_m(&structure.positions_m, flight.balance.turn_rad);
    let hang = HANG.with_y(0.0);
    let (mut force, mut moment) = (DVec3::ZERO, DVec3::ZERO);
    let mut add = |at: DVec3, pull: DVec3| {
        force += pull;
        moment += (at - hang).cross(pull);
    };
    let loads = &flight.loads;
    for (triangle, jump) in structure.triangles.iter().zip(&loads.jumps_pa) {
        let middle: DVec3 = triangle.nodes.map(|n| positions[n as usize]).iter().sum();
        let pull = triangle.doubled_area_vector(&positions) * (0.5 * jump);
        add(middle / 3.0, pull);
    }
    for ((at, load), mass) in positions
        .iter()
        .zip(&loads.nodal_n)
        .zip(&structure.masses_kg)
    {
        add(*at, *load - DVec3::Z * (mass * GRAVITY));
    }
    let drag = 0.5 * DENSITY * flight.balance.speed_m_s.powi(2) * PILOT_AREA_M2;
    add(
        hang,
        stream(flight.balance.glide_rad) * drag - DVec3::Z * (PILOT_KG * GRAVITY),
    );
    [
        force.length() / flight.weight_n,
        moment.length() / (flight.weight_n * HANG.z.abs()),
    ]
}

pub(in super::super) fn compute(session: &mut Session) -> Result<(), Stop> {
    let (cells, along_chord) = session.size((24, 24), (40, 40));
    let wing = wing(cells, along_chord)?;
    let section = SectionFlow::of(&super::symmetric_profile(12)?)?;
    let points = (-60..=60).map(|quarter| {
        let angle_rad = (0.25 * f64::from(quarter)).to_radians();
        PolarPoint {
            angle_rad,
            lift: LIFT_SHARE * section.slope_per_rad * angle_rad.sin(),
            drag: SECTION_DRAG,
            moment: None,
        }
    });
    let polar = Polar::new(points.collect())?;
    let settings = |panels_per_side: usize| Settings {
        density_kg_m3: DENSITY,
        pilot_mass_kg: PILOT_KG,
        pilot_drag_area_m2: PILOT_AREA_M2,
        line_drag_coefficient: 1.1,
        inside: Some(1.0),
        sections: SectionSettings::new(vec![Some(polar.clone())], 1.5e6),
        panels_per_side,
        strips: cells,
        relaxation: 1.0,
        from_coarser_meshes: false,
        tolerance: Tolerance {
            speed: 1e-3,
            glide: 1e-3,
            pitch_rad: 1e-3,
            shape: 1e-3,
            balance: 1e-3,
        },
        iteration_limit: 1,
    };
    let per_side = session.size(20, 32);
    let fly = |panels_per_side: usize| -> Result<(Flight, [f64; 2]), Stop> {
        session.check_interrupt()?;
        let settings = settings(panels_per_side);
        let glider = Glider::new(&wing, &wing.structure, &[], &settings, GRAVITY)?;
        let positions = &wing.structure.positions_m;
        let flight = glider.glide(positions, &glider.panel_nodes_m(positions), None)?;
        let residuals = residuals(&wing, &glider, &flight);
        Ok((flight, residuals))
    };
    let (coarse, _) = fly(per_side / 2)?;
    let (fine, [force, moment]) = fly(per_side)?;
    let panels = fine.panels;
    let [angle, speed, glide] = lifting_line(&wing, LIFT_SHARE * section.slope_per_rad);
    let source = "lifting-line theory";
    let of = |flight: &Flight| {
        [
            flight.balance.stream_rad,
            flight.balance.speed_m_s,
            1.0 / flight.balance.glide_rad.tan(),
        ]
    };
    // A tenth of a degree of the angle is 5 %; lifting-line theory knows neither thickness nor where pressures act.
    for (((name, value), reference), gate) in
        ["angle of attack [rad]", "speed [m/s]", "glide ratio"]
            .into_iter()
            .zip(of(&fine))
            .zip([angle, speed, glide])
            .zip([0.05, 0.03, 0.03])
    {
        session
            .aero_row(panels, name, value)
            .reference(reference, source)
            .gate(Gate::Within(gate));
    }
    for ((name, value), reference) in ["angle of attack", "speed", "glide ratio"]
        .into_iter()
        .zip(of(&coarse))
        .zip(of(&fine))
    {
        session
            .aero_row(
                coarse.panels,
                format!("{name}, half as many panels per side"),
                value,
            )
            .reference(reference, "more panels");
    }
    session
        .aero_row(
            panels,
            "lift by pressures on the fabric [N]",
            fine.pressure_lift_n,
        )
        .reference(fine.far_lift_n, "Trefftz plane")
        .gate(Gate::Within(0.03));
    session
        .aero_row(panels, "force left over weight", force)
        .gate(Gate::AtMost(1e-9));
    // The search ends at 1e-7 rad.
    session
        .aero_row(panels, "moment left over weight times height", moment)
        .gate(Gate::AtMost(1e-6));
    Ok(())
}
