//! The wing at every angle of attack.

use glam::DVec3;

use super::sections::{SectionsOfWing, sections};
use crate::aero::AeroError;
use crate::aero::decambering::{AGREEMENT, Branch, Decambering, Section, ViscousFlow};
use crate::aero::potential_flow::{self, MEMORY_LIMIT, PotentialFlow};
use crate::aero::surface::{PanelSurface, Wing};
use crate::case::bare_wing::BareWing;

/// Lift coefficients of both branches farther apart than this belong to two solutions. Viscosity that was needed where a search began moves the one solution that there is by up to 0.003.
const TWO_BRANCHES: f64 = 1e-2;

/// Coefficients of a wing, on its reference area and chord.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Coefficients {
    /// Across the stream, in the plane of stream and z axis.
    pub lift: f64,
    /// Of the far wake.
    pub induced_drag: f64,
    /// Of the sections.
    pub profile_drag: f64,
    /// Force to the right.
    pub side_force: f64,
    /// Moment that lifts the left tip.
    pub rolling_moment: f64,
    /// Moment that lifts the nose.
    pub pitching_moment: f64,
    /// Moment that turns the nose to the right.
    pub yawing_moment: f64,
}

impl Coefficients {
    /// Induced drag and that of the sections.
    #[must_use]
    pub fn drag(&self) -> f64 {
        self.induced_drag + self.profile_drag
    }
}

/// A strip at one angle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StripLoad {
    /// Middle of the strip's quarter line [m].
    pub place_m: DVec3,
    /// Chord [m].
    pub chord_m: f64,
    /// Length along the span [m].
    pub width_m: f64,
    /// Reynolds number on its chord.
    pub reynolds: f64,
    /// Lift coefficient on its chord.
    pub lift: f64,
    /// Drag coefficient of its section.
    pub drag: f64,
    /// Effective angle of its section [rad].
    pub effective_rad: f64,
    /// Whether the section is at or below its highest lift.
    pub is_below_stall: bool,
}

/// The wing at one angle.
#[derive(Debug, Clone)]
pub struct Point {
    /// Angle of attack [°].
    pub angle_deg: f64,
    /// On the branch that follows from small angles; where that has ended, on the separated one; `None` where sections and wing do not agree.
    pub coefficients: Option<Coefficients>,
    /// On the separated branch, where it is another one.
    pub separated: Option<Coefficients>,
    /// Largest difference of a strip's lift coefficient from its polar's.
    pub residual: f64,
    /// Share of the area whose sections are beyond their highest lift.
    pub stalled_share: f64,
    /// Whether every section is at an angle that its polar covers.
    pub is_covered: bool,
    /// Strips, in the order of the stations.
    pub strips: Vec<StripLoad>,
}

/// What comes of a sweep.
#[derive(Debug, Clone)]
pub struct Polar {
    /// A point for every angle, by growing angle.
    pub points: Vec<Point>,
    /// Panels, the caps' included.
    pub panels: usize,
    /// Whether strips lie below the least Reynolds number of computed polars.
    pub below_range: bool,
    /// Whether all of those reach beyond the highest lift.
    pub sections_stall: bool,
}

/// Memory of the matrix of so many panels and strips [bytes].
#[must_use]
pub const fn matrix_bytes(panels: usize, strips: usize) -> u64 {
    potential_flow::memory_bytes(panels, strips)
}

/// Computes all angles.
///
/// # Errors
///
/// When the wing makes no surface, or one that is too large.
pub fn solve(case: &BareWing) -> Result<Polar, AeroError> {
    let whole;
    let case = if case.wing.is_symmetric && case.sideslip_deg != 0.0 {
        whole = both_halves(case);
        &whole
    } else {
        case
    };
    let sections = sections(case)?;
    let surface = sections.wing.panels(case.panels_per_side)?;
    let mut points = Vec::with_capacity(case.angles_deg.len());
    for &angle_deg in &case.angles_deg {
        points.push(point(case, &sections, &surface, angle_deg)?);
    }
    Ok(Polar {
        points,
        panels: surface.panels.len(),
        below_range: sections.below_range,
        sections_stall: sections.stalls,
    })
}

/// The whole of a wing that is given by its right half.
fn both_halves(case: &BareWing) -> BareWing {
    let right = &case.wing.stations;
    let left = right.iter().skip(1).rev().map(|station| {
        let mut station = station.clone();
        station.position_m.y = -station.position_m.y;
        station.roll_rad = -station.roll_rad;
        station
    });
    let numbers = &case.station_profiles;
    BareWing {
        wing: Wing {
            stations: left.chain(right.iter().cloned()).collect(),
            is_symmetric: false,
            ..case.wing.clone()
        },
        station_profiles: (numbers.iter().skip(1).rev())
            .chain(numbers)
            .copied()
            .collect(),
        strips: 2 * case.strips,
        ..case.clone()
    }
}

fn point(
    case: &BareWing,
    sections: &SectionsOfWing,
    surface: &PanelSurface,
    angle_deg: f64,
) -> Result<Point, AeroError> {
    let (angle, sideslip) = (angle_deg.to_radians(), case.sideslip_deg.to_radians());
    let direction = DVec3::new(
        angle.cos() * sideslip.cos(),
        -sideslip.sin(),
        angle.sin() * sideslip.cos(),
    );
    let stream = case.speed_m_s * direction;
    let flow = PotentialFlow::new(surface, direction, MEMORY_LIMIT)?;
    let of_strips = sections
        .strips
        .iter()
        .map(|(polar, flow)| Section { polar, flow: *flow });
    let decambering = Decambering::new(&flow, of_strips.collect())?;
    let [attached, separated] = [
        decambering
            .solve(&[stream], Branch::Attached, case.density_kg_m3)?
            .remove(0),
        decambering
            .solve(&[stream], Branch::Separated, case.density_kg_m3)?
            .remove(0),
    ];
    // Beyond the end of the first branch only the other one is left.
    let chosen = if attached.residual < AGREEMENT {
        &attached
    } else {
        &separated
    };
    let strips = loads(sections, surface, chosen);
    let area = |strip: &&StripLoad| strip.chord_m * strip.width_m;
    let all: f64 = strips.iter().map(|s| area(&s)).sum();
    let stalled = strips.iter().filter(|s| !s.is_below_stall);
    let of = |flow: &ViscousFlow| {
        (flow.residual < AGREEMENT).then(|| coefficients(case, sections, surface, flow))
    };
    let (first, second) = (of(chosen), of(&separated));
    let is_other = |other: &Coefficients| {
        first.is_some_and(|first| (first.lift - other.lift).abs() > TWO_BRANCHES)
    };
    Ok(Point {
        angle_deg,
        separated: second.filter(is_other),
        coefficients: first,
        residual: chosen.residual,
        // Of nothing, the sum is −0.
        stalled_share: stalled.map(|s| area(&s)).fold(0.0, |sum, a| sum + a) / all,
        is_covered: chosen.is_covered,
        strips,
    })
}

/// What polars of the sections add to the moments of the pressures of potential flow [N m]: those of their drag along the stream, at the quarter of the chord, and the
/// difference between their own moments about it and those of the pressures.
fn moment_of_sections(
    case: &BareWing,
    sections: &SectionsOfWing,
    surface: &PanelSurface,
    viscous: &ViscousFlow,
) -> DVec3 {
    let stream = viscous.flow.stream_m_s;
    let dynamic_pa = 0.5 * case.density_kg_m3 * stream.length_squared();
    let pressures = viscous.flow.pressure_coefficients(surface);
    let along = stream.normalize_or_zero();
    let of_drag = |j: usize| {
        let area_m2 = surface.chord_m(j) * surface.span_m(j).length();
        let drag_n = dynamic_pa * area_m2 * sections.strips[j].0.drag(viscous.effective_rad[j]);
        (quarter_m(surface, j) - case.moment_point_m).cross(along * drag_n)
    };
    let of_strip = |j: usize| {
        let moment = sections.strips[j].0.moment(viscous.effective_rad[j])?;
        let span = surface.span_m(j);
        let quarter = quarter_m(surface, j);
        let first = j * surface.chordwise;
        let panels = surface.panels[first..first + surface.chordwise].iter();
        let potential: f64 = panels
            .zip(&pressures[first..])
            .map(|(panel, pressure)| {
                let force = -dynamic_pa * pressure * panel.area_m2;
                (panel.centre_m - quarter)
                    .cross(force)
                    .dot(span.normalize_or_zero())
            })
            .sum();
        let section = dynamic_pa * surface.chord_m(j).powi(2) * span.length() * moment;
        Some((section - potential) * span.normalize_or_zero())
    };
    let half: DVec3 = (0..surface.spanwise)
        .map(|j| of_drag(j) + of_strip(j).unwrap_or_default())
        .sum();
    if surface.is_symmetric {
        // The other half adds as much about the span, and takes away what is about the other axes.
        DVec3::Y * (2.0 * half.y)
    } else {
        half
    }
}

/// The quarter of a strip's chord, in its middle [m].
fn quarter_m(surface: &PanelSurface, strip: usize) -> DVec3 {
    let edge = |i: usize| {
        surface
            .node_m(i, strip)
            .midpoint(surface.node_m(i, strip + 1))
    };
    edge(surface.chordwise / 2).lerp(edge(0), 0.25)
}

fn coefficients(
    case: &BareWing,
    sections: &SectionsOfWing,
    surface: &PanelSurface,
    viscous: &ViscousFlow,
) -> Coefficients {
    let stream = viscous.flow.stream_m_s;
    let dynamic_pa = 0.5 * case.density_kg_m3 * stream.length_squared();
    let area = dynamic_pa * case.reference_area_m2;
    let [lift, induced, profile] = viscous.lift_and_drags_n(surface, case.density_kg_m3);
    let near = viscous
        .flow
        .pressure_forces(surface, case.density_kg_m3, case.moment_point_m);
    let sections_n_m = moment_of_sections(case, sections, surface, viscous);
    let moment = (near.moment_n_m + sections_n_m) / (area * case.reference_chord_m);
    Coefficients {
        lift: lift / area,
        induced_drag: induced / area,
        profile_drag: profile / area,
        side_force: near.force_n.y / area,
        rolling_moment: -moment.x,
        pitching_moment: moment.y,
        yawing_moment: -moment.z,
    }
}

fn loads(
    sections: &SectionsOfWing,
    surface: &PanelSurface,
    viscous: &ViscousFlow,
) -> Vec<StripLoad> {
    let lifts = viscous.flow.section_lift_coefficients(surface);
    (0..surface.spanwise)
        .map(|j| {
            let angle = viscous.effective_rad[j];
            let polar = &sections.strips[j].0;
            StripLoad {
                place_m: quarter_m(surface, j),
                chord_m: surface.chord_m(j),
                width_m: surface.span_m(j).length(),
                reynolds: sections.reynolds[j],
                lift: lifts[j],
                drag: polar.drag(angle),
                effective_rad: angle,
                is_below_stall: polar.is_below_stall(angle),
            }
        })
        .collect()
}
