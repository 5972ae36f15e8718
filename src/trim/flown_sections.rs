//! Polars of the flown sections: by the viscous method, for every profile with its trailing edge turned down by several angles.
//!
//! A brake turns the rear quarter of a section down. How far it is turned follows from the flown outline. Let the chord run from the nose to the trailing edge, h be the hinge's place on it and w the length over which the
//! outline bends. A turn δ about the hinge then raises the mean line there by h (1 − h − w/2) tan δ against the designed one. Polars and potential flow are
//! taken between those of the two nearest angles. Angles of attack are those of the turned chord.
//!
//! To the drag of the boundary layers come that of an intake, 0.07 of its height per chord (Babinsky 1999, as P. Heatwole's thesis, 2022, quotes it), and
//! that of seams, wrinkles and pores, 0.004 (Ware & Hassell 1969, from the same): measured shares, not of these sections. Behind an intake the layer is turbulent.
//! Cells without an intake have neither its drag nor its transition. A strip over cells of both kinds lies between both polars, by their areas.

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
    /// x/c above and below at which layers are turbulent at the latest; below, `None` stands for the rear edge of an intake where there is one.
    pub transition: [Option<f64>; 2],
    /// Drag coefficient of seams, wrinkles and pores.
    pub surface_drag: f64,
    /// Front and rear edge of the intakes of open cells, per chord.
    pub intake: Option<[f64; 2]>,
    /// What was computed, by profile, nose and turn, shared by all that were cloned: no setting.
    computed: Arc<Vec<[[Computed; TURNS_DEG.len()]; 2]>>,
}

/// The nose of a section.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum Nose {
    /// Without an intake.
    Closed,
    /// With one.
    Open,
}

/// What the section of a strip follows from.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct FlownStrip {
    /// Profiles that it lies between.
    pub between: Between,
    /// By how much its trailing edge is turned down [rad].
    pub turn_rad: f64,
    /// Share of its area whose cells have an intake.
    pub open_share: f64,
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

    /// Polars and potential flow of strips.
    pub(super) fn of_strips(
        &self,
        profiles: &[Profile],
        strips: &[FlownStrip],
    ) -> Result<Vec<Member>, AeroError> {
        let mut needed = Vec::new();
        for strip in strips {
            let (turns, _) = place(strip.turn_rad);
            for number in strip.between.0 {
                for nose in noses(strip.open_share) {
                    needed.extend(turns.map(|turn| (number, nose, turn)));
                }
            }
        }
        needed.sort_unstable();
        needed.dedup();
        needed
            .into_par_iter()
            .try_for_each(|which| self.member(profiles, which).map(|_| ()))?;
        strips
            .iter()
            .map(|strip| {
                let ([low, high], part) = place(strip.turn_rad);
                let of = |number: usize, nose: Nose| -> Result<Member, AeroError> {
                    let [low, high] =
                        [low, high].map(|turn| self.member(profiles, (number, nose, turn)));
                    Ok(mixed(low?, high?, part))
                };
                let ([a, b], share) = strip.between;
                let with = |nose: Nose| -> Result<Member, AeroError> {
                    Ok(if a == b {
                        of(a, nose)?
                    } else {
                        mixed(&of(a, nose)?, &of(b, nose)?, share)
                    })
                };
                let [closed, open] = noses(strip.open_share);
                Ok(if closed == open {
                    with(open)?
                } else {
                    mixed(&with(closed)?, &with(open)?, strip.open_share)
                })
            })
            .collect()
    }

    /// One by the numbers of its profile and its turn.
    fn member(
        &self,
        profiles: &[Profile],
        (number, nose, turn): (usize, Nose, usize),
    ) -> Result<&Member, AeroError> {
        let cell = &self.computed[number][nose as usize][turn];
        let turn_rad = TURNS_DEG[turn].to_radians();
        // Not within the cell's lock: a polar is computed on several threads, one of which may come for this one.
        let computed = match cell.get() {
            Some(known) => known,
            None => {
                let computed = self.compute(&profiles[number], (number, nose), turn_rad);
                cell.get_or_init(|| computed)
            }
        };
        computed.as_ref().map_err(Clone::clone)
    }

    fn compute(
        &self,
        profile: &Profile,
        (number, nose): (usize, Nose),
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
        let intake = self.intake.filter(|_| nose == Nose::Open);
        let [above, below] = self.transition;
        let conditions = Conditions {
            reynolds: self.reynolds,
            critical_amplification: self.critical_amplification,
            forced_transition: [above, below.or(intake.map(|[_, to]| to))],
        };
        let intake_drag = intake.map_or(0.0, |[from, to]| {
            let lip = |x: f64| DVec2::new(x, profile.height(Side::Lower, x));
            INTAKE_DRAG * lip(from).distance(lip(to))
        });
        let computed = viscous_polar(&outline, &conditions, self.surface_drag + intake_drag);
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

/// The noses that a strip has; where one has no share, the other twice: it is not asked for.
fn noses(open_share: f64) -> [Nose; 2] {
    if open_share <= 0.0 {
        [Nose::Closed; 2]
    } else if open_share >= 1.0 {
        [Nose::Open; 2]
    } else {
        [Nose::Closed, Nose::Open]
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

    /// A strip of the first profile.
    fn strip(turn_deg: f64, open_share: f64) -> FlownStrip {
        FlownStrip {
            between: ([0, 0], 0.0),
            turn_rad: turn_deg.to_radians(),
            open_share,
        }
    }

    /// A turned trailing edge lifts at a smaller angle and has more drag; given polars stand for all turns.
    #[test]
    fn brakes_lift_and_hold_back() {
        let profiles = [Profile::naca("2417").unwrap()];
        let settings = SectionSettings::new(vec![None], 1.5e6);
        let strips = [0.0f64, 12.0].map(|degrees| strip(degrees, 1.0));
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
        let given = straight.0.clone();
        let settings = SectionSettings::new(vec![Some(given.clone())], 1.5e6);
        let found = settings.of_strips(&profiles, &strips).unwrap();
        assert_eq!(found[1].0.lift(0.05), given.lift(0.05));
    }

    /// A closed nose has the drag of seams alone and its laminar layer; an open one that of the intake and of the turbulent layer behind it; a strip with both the mean.
    #[test]
    fn closed_noses_have_no_drag_of_intakes() {
        let profiles = [Profile::naca("2417").unwrap()];
        let plain = SectionSettings::new(vec![None], 1.5e6);
        let plain = plain.of_strips(&profiles, &[strip(0.0, 0.0)]).unwrap();
        let mut settings = SectionSettings::new(vec![None], 1.5e6);
        settings.intake = Some([0.004, 0.03]);
        settings.surface_drag = 0.004;
        let strips = [0.0, 1.0, 0.25].map(|open_share| strip(0.0, open_share));
        let found = settings.of_strips(&profiles, &strips).unwrap();
        let drag = |member: &Member| member.0.drag(0.05);
        let [closed, open, both] = [0, 1, 2].map(|k| drag(&found[k]));
        let seams = closed - drag(&plain[0]);
        assert!((seams - 0.004).abs() < 1e-12, "{seams}");
        let lip = |x: f64| DVec2::new(x, profiles[0].height(Side::Lower, x));
        let intake = 0.07 * lip(0.004).distance(lip(0.03));
        // A plate's laminar layer has 0.0011 at this Reynolds number, a turbulent one 0.0043.
        let layer = open - closed - intake;
        assert!((0.0003..0.0035).contains(&layer), "{layer} {intake}");
        let mean = closed + 0.25 * (open - closed);
        assert!((both - mean).abs() < 1e-6, "{both} {mean}");
        // Transition that is told holds everywhere.
        settings = SectionSettings::new(vec![None], 1.5e6);
        settings.intake = Some([0.004, 0.03]);
        settings.transition = [Some(0.5), Some(0.4)];
        let found = settings.of_strips(&profiles, &strips[..2]).unwrap();
        let more = drag(&found[1]) - drag(&found[0]);
        assert!((more - intake).abs() < 1e-9, "{more} {intake}");
    }
}
