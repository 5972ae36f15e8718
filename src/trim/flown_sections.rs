//! Polars of the flown sections: by the viscous method, for every profile with its trailing edge turned down by several angles.
//!
//! A brake turns the rear quarter of a section down. How far it is turned follows from the flown outline. Let the chord run from the nose to the trailing edge, h be the hinge's place on it and w the length over which the
//! outline bends. A turn δ about the hinge then raises the mean line there by h (1 − h − w/2) tan δ against the designed one. Polars and potential flow are
//! taken between those of the two nearest angles. Angles of attack are those of the turned chord.
//!
//! To the drag of the boundary layers come that of an intake, 0.07 of its height per chord (Babinsky 1999, as P. Heatwole's thesis, 2022, quotes it), and
//! that of seams, wrinkles and pores, 0.004 (Ware & Hassell 1969, from the same): measured shares, not of these sections. Behind an intake the layer is turbulent.

use std::sync::{Arc, OnceLock};

use glam::{DVec2, DVec3};
use rayon::prelude::*;

use crate::aero::AeroError;
use crate::aero::polar::{Polar, SectionFlow};
use crate::aero::section::Conditions;
use crate::aero::surface::PanelSurface;
use crate::aero::viscous_polar::viscous_polar;
use crate::geometry::profile;
use crate::geometry::wing::section::{Profile, Side};

/// Points per side that stand for a profile.
const PROFILE_POINTS: usize = 100;

/// Turns of the trailing edge whose polars are computed, downwards [°].
const TURNS_DEG: [f64; 5] = [-8.0, 0.0, 8.0, 16.0, 24.0];

/// Where the trailing edge turns, and over which length it bends, per chord.
const HINGE: f64 = 0.75;
const BEND: f64 = 0.1;

/// Drag of an intake over its height per chord.
const INTAKE_DRAG: f64 = 0.07;

/// What the polars of a wing's sections follow from.
#[derive(Debug, Clone)]
pub struct SectionSettings {
    /// Polars that are given, by the number of the profile; `None`: computed.
    pub polars: Vec<Option<Polar>>,
    /// Reynolds number of computed polars.
    pub reynolds: f64,
    /// Exponent of the amplification at which a laminar layer turns turbulent.
    pub critical_amplification: f64,
    /// x/c above and below at which layers are turbulent at the latest.
    pub transition: [Option<f64>; 2],
    /// Drag coefficient of seams, wrinkles and pores.
    pub surface_drag: f64,
    /// Front and rear edge of the intakes, per chord.
    pub intake: Option<[f64; 2]>,
    /// What was computed, shared by all that were cloned: no setting.
    computed: Arc<Vec<[Computed; TURNS_DEG.len()]>>,
}

/// A section at one turn of its trailing edge.
type Member = (Polar, SectionFlow);

/// What came of one, once it was asked for.
type Computed = OnceLock<Result<Member, AeroError>>;

/// A place between two profiles: their numbers, and the share of the second.
pub type Between = ([usize; 2], f64);

impl PartialEq for SectionSettings {
    fn eq(&self, other: &Self) -> bool {
        let of = |s: &Self| {
            (
                s.reynolds,
                s.critical_amplification,
                s.transition,
                s.surface_drag,
                s.intake,
            )
        };
        self.polars == other.polars && of(self) == of(other)
    }
}

impl SectionSettings {
    /// Settings of as many profiles as there are polars or places for them.
    #[must_use]
    pub fn new(polars: Vec<Option<Polar>>, reynolds: f64) -> Self {
        let computed = polars.iter().map(|_| Default::default()).collect();
        Self {
            polars,
            reynolds,
            critical_amplification: 9.0,
            transition: [None; 2],
            surface_drag: 0.0,
            intake: None,
            computed: Arc::new(computed),
        }
    }

    /// Polars and potential flow of strips, each between two profiles and with its trailing edge turned down by an angle [rad].
    pub(super) fn of_strips(
        &self,
        profiles: &[Profile],
        strips: &[(Between, f64)],
    ) -> Result<Vec<Member>, AeroError> {
        let mut needed: Vec<(usize, usize)> = strips
            .iter()
            .flat_map(|((numbers, _), turn)| {
                let (turns, _) = place(*turn);
                numbers
                    .iter()
                    .flat_map(move |n| turns.map(|turn| (*n, turn)))
            })
            .collect();
        needed.sort_unstable();
        needed.dedup();
        needed
            .into_par_iter()
            .try_for_each(|(number, turn)| self.member(profiles, number, turn).map(|_| ()))?;
        strips
            .iter()
            .map(|(([a, b], share), turn)| {
                let ([low, high], part) = place(*turn);
                let of = |number: usize| -> Result<Member, AeroError> {
                    let [low, high] = [low, high].map(|turn| self.member(profiles, number, turn));
                    Ok(mixed(low?, high?, part))
                };
                Ok(if a == b {
                    of(*a)?
                } else {
                    mixed(&of(*a)?, &of(*b)?, *share)
                })
            })
            .collect()
    }

    fn member(
        &self,
        profiles: &[Profile],
        number: usize,
        turn: usize,
    ) -> Result<&Member, AeroError> {
        let cell = &self.computed[number][turn];
        cell.get_or_init(|| self.compute(&profiles[number], number, TURNS_DEG[turn].to_radians()))
            .as_ref()
            .map_err(Clone::clone)
    }

    fn compute(
        &self,
        profile: &Profile,
        number: usize,
        turn_rad: f64,
    ) -> Result<Member, AeroError> {
        let given = self.polars.get(number).and_then(Option::as_ref);
        // What is given is that of the section as it is drawn.
        let turn_rad = if given.is_some() { 0.0 } else { turn_rad };
        let outline = turned(&outline(profile), turn_rad);
        let flow = SectionFlow::of(&Arc::new(profile::Profile::new(outline.clone())?))?;
        if let Some(polar) = given {
            return Ok((polar.clone(), flow));
        }
        let conditions = Conditions {
            reynolds: self.reynolds,
            critical_amplification: self.critical_amplification,
            forced_transition: self.transition,
        };
        let intake = self.intake.map_or(0.0, |[from, to]| {
            let lip = |x: f64| DVec2::new(x, profile.height(Side::Lower, x));
            INTAKE_DRAG * lip(from).distance(lip(to))
        });
        let computed = viscous_polar(&outline, &conditions, self.surface_drag + intake);
        let computed = computed.map_err(|why| {
            AeroError::Polar(format!(
                "of profile {}, trailing edge turned by {:.0} degrees: {why}; give [equilibrium.trim.polars]",
                number + 1,
                turn_rad.to_degrees()
            ))
        })?;
        Ok((computed.polar, flow))
    }
}

/// Numbers of the turns that an angle lies between, and the share of the second; where one has no share, the other twice: it is not asked for.
fn place(turn_rad: f64) -> ([usize; 2], f64) {
    let turn = turn_rad.to_degrees();
    let last = TURNS_DEG.len() - 1;
    let before = TURNS_DEG.partition_point(|t| *t <= turn).clamp(1, last) - 1;
    let share = (turn - TURNS_DEG[before]) / (TURNS_DEG[before + 1] - TURNS_DEG[before]);
    if share <= 0.0 {
        ([before; 2], 0.0)
    } else if share >= 1.0 {
        ([before + 1; 2], 0.0)
    } else {
        ([before, before + 1], share)
    }
}

/// Whether the polars that are computed hold at a turn of the trailing edge; beyond, those of the last one stand in.
pub(super) fn is_within_turns(turn_rad: f64) -> bool {
    let [first, .., last] = TURNS_DEG;
    (first..=last).contains(&turn_rad.to_degrees())
}

fn mixed(a: &Member, b: &Member, share: f64) -> Member {
    (a.0.between(&b.0, share), a.1.between(&b.1, share))
}

/// From the trailing edge along the lower side around the nose back to it, over the chord.
fn outline(profile: &Profile) -> Vec<DVec2> {
    let point = |side: Side, i: usize| {
        let angle = std::f64::consts::PI * i as f64 / PROFILE_POINTS as f64;
        let x = 0.5 * (1.0 - angle.cos());
        DVec2::new(x, profile.height(side, x))
    };
    let lower = (1..=PROFILE_POINTS).rev().map(|i| point(Side::Lower, i));
    let upper = (0..=PROFILE_POINTS).map(|i| point(Side::Upper, i));
    lower.chain(upper).collect()
}

/// An outline whose trailing edge is turned down, over its new chord.
fn turned(outline: &[DVec2], turn_rad: f64) -> Vec<DVec2> {
    let down = |x: f64| {
        let behind = (x - HINGE).max(0.0);
        let bent = behind.min(BEND);
        turn_rad.tan() * (0.5 * bent * bent / BEND + behind - bent)
    };
    let chord = DVec2::new(1.0, -down(1.0));
    let back = DVec2::new(chord.x, -chord.y) / chord.length_squared();
    outline
        .iter()
        .map(|p| (*p - DVec2::Y * down(p.x)).rotate(back))
        .collect()
}

/// By how much the trailing edge of a strip of a flown surface is turned down against profiles as they are designed [rad].
pub(super) fn turn_rad(
    surface: &PanelSurface,
    strip: usize,
    profiles: &[Profile],
    between: Between,
) -> f64 {
    let edge = |i: usize| {
        surface
            .node_m(i, strip)
            .midpoint(surface.node_m(i, strip + 1))
    };
    let per_side = surface.chordwise / 2;
    let (tail, nose) = (edge(0), edge(per_side));
    let chord = tail - nose;
    let up = chord.cross(surface.span_m(strip)).normalize_or_zero();
    let length = chord.length();
    let local = |point: DVec3| {
        let off = point - nose;
        DVec2::new(off.dot(chord) / (length * length), off.dot(up) / length)
    };
    let height = |points: &mut dyn Iterator<Item = usize>| {
        let mut before = DVec2::ZERO;
        for i in points {
            let point = local(edge(i));
            if point.x >= HINGE {
                let share = (HINGE - before.x) / (point.x - before.x).max(f64::MIN_POSITIVE);
                return before.y + share * (point.y - before.y);
            }
            before = point;
        }
        before.y
    };
    let lower = height(&mut (0..per_side).rev());
    let upper = height(&mut (per_side + 1..=surface.chordwise));
    let mean = |number: usize| {
        let profile = &profiles[number];
        0.5 * (profile.height(Side::Lower, HINGE) + profile.height(Side::Upper, HINGE))
    };
    let ([a, b], share) = between;
    let designed = mean(a) + share * (mean(b) - mean(a));
    let raised = 0.5 * (lower + upper) - designed;
    (raised / (HINGE * (1.0 - HINGE - 0.5 * BEND))).atan()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::aero::surface::{Station, Wing};

    /// A trailing edge that is turned is found to be, within 8 % and half a degree, and keeps its chord.
    #[test]
    fn turns_are_found() {
        let profile = Profile::naca("2417").unwrap();
        for degrees in [-6.0f64, 0.0, 5.0, 20.0] {
            let points = turned(&outline(&profile), degrees.to_radians());
            let last = points[points.len() - 1];
            assert!(last.distance(DVec2::X) < 1e-12, "{last}");
            let station = |y: f64| Station {
                position_m: DVec3::Y * y,
                chord_m: 2.0,
                twist_rad: 0.1,
                roll_rad: 0.3,
                profile: Arc::new(profile::Profile::new(points.clone()).unwrap()),
            };
            let wing = Wing {
                stations: vec![station(0.0), station(1.0)],
                chord_fraction: 0.25,
                is_symmetric: false,
            };
            let surface = wing.panels(30).unwrap();
            let found =
                turn_rad(&surface, 0, std::slice::from_ref(&profile), ([0, 0], 0.0)).to_degrees();
            assert!(
                (found - degrees).abs() < 0.4 + 0.08 * degrees.abs(),
                "{degrees}: {found}"
            );
        }
    }

    #[test]
    fn turns_beyond_the_polars_are_known() {
        for (degrees, within) in [
            (-8.5, false),
            (-7.9, true),
            (0.0, true),
            (23.9, true),
            (35.0, false),
        ] {
            assert_eq!(
                is_within_turns(f64::to_radians(degrees)),
                within,
                "{degrees}"
            );
        }
        assert!(!is_within_turns(f64::NAN));
    }

    /// A turned trailing edge lifts at a smaller angle and has more drag; an intake adds its drag; given polars stand for all turns.
    #[test]
    fn brakes_lift_and_hold_back() {
        let profiles = [Profile::naca("2417").unwrap()];
        let mut settings = SectionSettings::new(vec![None], 1.5e6);
        let strips = [0.0f64, 12.0].map(|degrees| (([0, 0], 0.0), degrees.to_radians()));
        let found = settings.of_strips(&profiles, &strips).unwrap();
        let [straight, braked] = &found[..] else {
            panic!()
        };
        assert!(braked.1.zero_lift_rad < straight.1.zero_lift_rad - 0.05);
        assert!(braked.0.lift(0.0).0 > straight.0.lift(0.0).0 + 0.3);
        // At the same small lift a braked section has more drag.
        let at_lift = |polar: &Polar| {
            let angles = (-120..120).map(|k| 0.001 * f64::from(k));
            let nearest = angles.min_by(|a, b| {
                let off = |angle: &f64| (polar.lift(*angle).0 - 0.1).abs();
                off(a).total_cmp(&off(b))
            });
            polar.drag(nearest.unwrap())
        };
        let drags = [straight, braked].map(|member| at_lift(&member.0));
        assert!(drags[1] > 1.1 * drags[0], "{drags:?}");
        settings = SectionSettings::new(vec![None], 1.5e6);
        settings.intake = Some([0.004, 0.03]);
        settings.surface_drag = 0.004;
        let with = settings.of_strips(&profiles, &strips[..1]).unwrap();
        let more = with[0].0.drag(0.05) - straight.0.drag(0.05);
        assert!((0.005..0.008).contains(&more), "{more}");
        let given = straight.0.clone();
        let settings = SectionSettings::new(vec![Some(given.clone())], 1.5e6);
        let found = settings.of_strips(&profiles, &strips).unwrap();
        assert_eq!(found[1].0.lift(0.05), given.lift(0.05));
    }
}
