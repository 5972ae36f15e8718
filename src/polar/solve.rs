//! The wing at every angle of attack.

use glam::DVec3;

use super::sections::{SectionsOfWing, sections};
use crate::aero::AeroError;
use crate::aero::decambering::{AGREEMENT, Branch, Decambering, Section, ViscousFlow};
use crate::aero::potential_flow::{self, MEMORY_LIMIT, PotentialFlow};
use crate::aero::surface::{PanelSurface, Station, Wing};
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
    /// Length along the span's polygon of the case [m].
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

/// Panels, the caps' included, and strips of what is computed: of half of a symmetric wing in a stream along it, else of the whole.
#[must_use]
pub fn panels_and_strips(case: &BareWing) -> [usize; 2] {
    let wing = &case.wing;
    let in_sideslip = case.sideslip_deg != 0.0;
    // A tip that ends in a point needs no cap.
    let cap = |tip: Option<&Station>| usize::from(tip.is_some_and(|tip| tip.chord_m > 0.0));
    let [first, last] = [wing.stations.first(), wing.stations.last()].map(cap);
    let (strips, caps) = match (wing.is_symmetric, in_sideslip) {
        (true, false) => (case.strips, last),
        (true, true) => (2 * case.strips, 2 * last),
        (false, _) => (case.strips, first + last),
    };
    [case.panels_per_side * (2 * strips + caps), strips]
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
        let drag_n = dynamic_pa * drag_area_m2(sections, surface, viscous, j);
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

/// Drag of a strip's section over the dynamic pressure [m²].
fn drag_area_m2(
    sections: &SectionsOfWing,
    surface: &PanelSurface,
    viscous: &ViscousFlow,
    strip: usize,
) -> f64 {
    let drag = sections.strips[strip].0.drag(viscous.effective_rad[strip]);
    surface.chord_m(strip) * sections.widths_m[strip] * drag
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
    let far = viscous.flow.trefftz_forces(surface, case.density_kg_m3);
    let of_strip = |j: usize| drag_area_m2(sections, surface, viscous, j);
    let half_m2: f64 = (0..surface.spanwise).map(of_strip).sum();
    let halves = if surface.is_symmetric { 2.0 } else { 1.0 };
    let near = viscous
        .flow
        .pressure_forces(surface, case.density_kg_m3, case.moment_point_m);
    let sections_n_m = moment_of_sections(case, sections, surface, viscous);
    let moment = (near.moment_n_m + sections_n_m) / (area * case.reference_chord_m);
    let profile_drag = halves * half_m2 / case.reference_area_m2;
    Coefficients {
        lift: far.lift_n / area,
        induced_drag: far.induced_drag_n / area,
        profile_drag,
        // The drag of sections acts along the stream, which comes from the side in sideslip.
        side_force: near.force_n.y / area
            + profile_drag * viscous.flow.stream_m_s.normalize_or_zero().y,
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
                width_m: sections.widths_m[j],
                reynolds: sections.reynolds[j],
                lift: lifts[j],
                drag: polar.drag(angle),
                effective_rad: angle,
                is_below_stall: polar.is_below_stall(angle),
            }
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::*;
    use crate::aero::polar::{Polar as PolarOfSection, PolarPoint};
    use crate::case::bare_wing::{BareProfile, SectionPolar};
    use crate::geometry::profile::Profile;

    /// Drag coefficient of all sections.
    const DRAG: f64 = 0.01;

    /// A polar whose lift runs through three points at −0.2, 0 and 0.2 rad.
    fn polar(lifts: [f64; 3]) -> SectionPolar {
        let points = [-0.2, 0.0, 0.2].into_iter().zip(lifts);
        let points = points.map(|(angle_rad, lift)| PolarPoint {
            angle_rad,
            lift,
            drag: DRAG,
            moment: None,
        });
        SectionPolar::Given(PolarOfSection::new(points.collect()).unwrap())
    }

    /// A wing of equal strips through points along its span, each with its chord [m]; the last station has the second profile.
    fn wing(points: &[([f64; 2], f64)], is_symmetric: bool, polars: [SectionPolar; 2]) -> BareWing {
        let outline = Arc::new(Profile::naca("0012").unwrap());
        let stations = points.iter().map(|&([y, z], chord_m)| Station {
            position_m: DVec3::new(0.0, y, z),
            chord_m,
            twist_rad: 0.0,
            roll_rad: 0.0,
            profile: Arc::clone(&outline),
        });
        let mut wing = Wing {
            stations: stations.collect(),
            chord_fraction: 0.25,
            is_symmetric,
        };
        wing.roll_along_span();
        let profiles = polars.map(|polar| BareProfile {
            name: "given".to_owned(),
            outline: Arc::clone(&outline),
            polar,
        });
        let mut station_profiles = vec![0; points.len()];
        station_profiles[points.len() - 1] = 1;
        BareWing {
            reference_area_m2: wing.flat_area_m2(),
            wing,
            station_profiles,
            profiles: profiles.into(),
            speed_m_s: 10.0,
            density_kg_m3: 1.2,
            viscosity_m2_s: 1.5e-5,
            angles_deg: vec![4.0],
            sideslip_deg: 0.0,
            reference_chord_m: 1.0,
            moment_point_m: DVec3::ZERO,
            panels_per_side: 6,
            strips: 3,
            tip_clustering: 0.0,
        }
    }

    /// A strip across a corner of the span is as wide as the wing is long there, and the strips beyond it lie where the wing has them.
    #[test]
    fn strips_are_measured_along_the_wing() {
        // 3 m outwards, 3 m down; along the second half the lift coefficient rises from 0 to 1.
        let points = [([0.0, 0.0], 1.0), ([3.0, 0.0], 1.0), ([3.0, -3.0], 1.0)];
        let found = sections(&wing(&points, true, [polar([0.0; 3]), polar([1.0; 3])])).unwrap();
        for width in &found.widths_m {
            assert!((width - 2.0).abs() < 1e-12, "{:?}", found.widths_m);
        }
        // Middles are 1, 3 and 5 m along.
        for ((polar, _), expected) in found.strips.iter().zip([0.0, 0.0, 2.0 / 3.0]) {
            let lift = polar.lift(0.05).0;
            assert!((lift - expected).abs() < 1e-9, "{lift} {expected}");
        }
    }

    /// An arch in two strips is as long as its own polygon. Sections of one drag coefficient make it the wing's, on the area laid flat.
    #[test]
    fn an_arch_of_few_strips_has_its_drag() {
        let arch: Vec<([f64; 2], f64)> = (0..=24)
            .map(|k| {
                let (sin, cos) = (f64::from(k) * 2.5).to_radians().sin_cos();
                ([5.0 * sin, 5.0 * (cos - 1.0)], 1.0)
            })
            .collect();
        let lifts = [-0.9, 0.1, 1.1];
        let mut case = wing(&arch, true, [polar(lifts), polar(lifts)]);
        case.strips = 2;
        let found = solve(&case).unwrap();
        let point = &found.points[0];
        let length: f64 = point.strips.iter().map(|strip| strip.width_m).sum();
        // 24 chords of 2.5°.
        let expected = 24.0 * 10.0 * 1.25f64.to_radians().sin();
        assert!((length / expected - 1.0).abs() < 1e-12, "{length}");
        let drag = point.coefficients.unwrap().profile_drag;
        assert!((drag / DRAG - 1.0).abs() < 2e-3, "{drag}");
    }

    /// Panels and strips that are told beforehand are those of the surface: a cap at every tip that does not end in a point.
    #[test]
    fn panels_are_counted_before_they_are_made() {
        let whole = |left_m: f64, right_m: f64| {
            vec![
                ([-3.0, 0.0], left_m),
                ([0.0, 0.0], 1.0),
                ([3.0, 0.2], right_m),
            ]
        };
        let half = |tip_m: f64| vec![([0.0, 0.0], 1.0), ([3.0, 0.2], tip_m)];
        for (points, is_symmetric, sideslip_deg, caps) in [
            (half(0.6), true, 0.0, 1),
            (half(0.6), true, 5.0, 2),
            (half(0.0), true, 0.0, 0),
            (half(0.0), true, 5.0, 0),
            (whole(0.6, 0.8), false, 0.0, 2),
            (whole(0.6, 0.8), false, 5.0, 2),
            (whole(0.6, 0.0), false, 0.0, 1),
            (whole(0.0, 0.8), false, 0.0, 1),
        ] {
            let lifts = [-0.9, 0.1, 1.1];
            let mut case = wing(&points, is_symmetric, [polar(lifts), polar(lifts)]);
            case.sideslip_deg = sideslip_deg;
            let told = panels_and_strips(&case);
            let found = solve(&case).unwrap();
            let strips = found.points[0].strips.len();
            assert_eq!(told, [found.panels, strips], "{points:?}");
            assert_eq!(found.panels, 6 * (2 * strips + caps), "{points:?}");
        }
    }
}
