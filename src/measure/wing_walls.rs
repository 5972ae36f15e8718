//! What the walls of a tunnel do to a wing in the wind: they speed the air up beside it, and keep its downwash small.
//!
//! Blockage is that of models of unusual shape, with their wake: U_corrected/U = 1 + A/(4 C), A the frontal area and C the section (Barlow,
//! Rae & Pope 1999, Low-Speed Wind Tunnel Testing, ch. 10). Maskell's term of a stalled wing is not added. Lift interference is that of the
//! mirror images of a lifting line: Δα = δ (S/C) C_L and ΔC_D = Δα C_L, C_L the corrected one (the same, and AGARDograph 109). Left out are
//! the curvature of the stream along the chord, the arc of the wing, inlet and outlet.

use super::air_around_wing::InWind;
use super::read_out::{ReadOut, results};
use super::shared::{CORRECTED_DRAG, PRESSURE_RATIO};
use super::statistics::Mean;
use super::wall_images::LiftingLine;
use crate::case::Scene;
use crate::case::scene::Flow;
use crate::output::{Quantity, Results};

results! {
    /// Beside the corrected drag and the ratio of dynamic pressures.
    RESULTS: "Wings in air without the walls of the tunnel";
    CORRECTED_LIFT: "lift_coefficient_blockage_corrected", "1", "lift coefficient without the walls of the tunnel; at an incidence that is larger by its correction";
    INCIDENCE_CORRECTION: "incidence_correction_deg", "deg", "incidence that walls stand for; what is to be added to that in the tunnel";
}

/// Largest span over the width of the tunnel: beyond, the loading no longer is that of a wing without walls.
const WIDEST: f64 = 0.8;

/// Least distance from floor and ceiling over the largest chord, so that a line stands for the wing.
const NEAREST: f64 = 1.0;

/// What a correction depends on.
#[derive(Debug, Clone, Copy)]
struct Walls {
    /// Frontal area over the section.
    blockage: f64,
    /// Factor δ of lift interference times flat area over section [rad].
    upwash: f64,
}

impl Walls {
    /// q_corrected/q.
    fn pressure_ratio(self) -> f64 {
        (1.0 + 0.25 * self.blockage).powi(2)
    }

    fn lift(self, lift: Mean) -> Mean {
        scaled(lift, 1.0 / self.pressure_ratio())
    }

    /// From the corrected lift [°].
    fn incidence_deg(self, lift: Mean) -> Mean {
        scaled(lift, self.upwash.to_degrees())
    }

    /// With the corrected lift. Errors of lift and drag may go together, so their parts of the interval add up.
    fn drag(self, drag: Mean, lift: Mean) -> Mean {
        let alone = scaled(drag, 1.0 / self.pressure_ratio());
        let slope = 2.0 * self.upwash * lift.value;
        Mean {
            value: alone.value + self.upwash * lift.value * lift.value,
            confidence: alone
                .confidence
                .and_then(|own| Some(own + (slope * lift.confidence?).abs())),
        }
    }
}

fn scaled(mean: Mean, factor: f64) -> Mean {
    Mean {
        value: mean.value * factor,
        confidence: mean.confidence.map(|c| c * factor.abs()),
    }
}

/// Coefficients without the walls of the tunnel, or why there are none; `quantity` adds what is to be said of a mean.
pub(super) fn results(
    results: &mut Results,
    (scene, known): (&Scene, &InWind),
    [lift, drag]: [Mean; 2],
    quantity: &dyn Fn(Mean) -> Quantity,
) {
    let [corrected_drag, ratio] = [&CORRECTED_DRAG, &PRESSURE_RATIO].map(|of| of.of(""));
    let mut insert = |read_out: &ReadOut, of: Quantity| results.insert(read_out, of);
    let walls = match walls(scene, known) {
        Ok(walls) => walls,
        Err(why) => {
            let missing = Quantity::missing(&format!("no correction for walls is known: {why}"));
            for read_out in [
                &CORRECTED_LIFT,
                &corrected_drag,
                &ratio,
                &INCIDENCE_CORRECTION,
            ] {
                insert(read_out, missing.clone());
            }
            return;
        }
    };
    let corrected = walls.lift(lift);
    let images = format!(
        "images of a lifting line of elliptic loading: {:.4} rad per C_L",
        walls.upwash
    );
    insert(
        &CORRECTED_LIFT,
        quantity(corrected).with_note(
            "over the ratio of dynamic pressures; its incidence is larger by its correction",
        ),
    );
    insert(
        &corrected_drag,
        quantity(walls.drag(drag, corrected)).with_note(&format!(
            "over the ratio of dynamic pressures, plus the induced drag that walls take away; {images}"
        )),
    );
    insert(
        &ratio,
        Quantity::new(walls.pressure_ratio()).with_note(&format!(
            "Barlow, Rae & Pope 1999: (1 + A/(4 C))^2, frontal area over section {:.3}",
            walls.blockage
        )),
    );
    insert(
        &INCIDENCE_CORRECTION,
        quantity(walls.incidence_deg(corrected)).with_note(&format!("{images}; in a long tunnel")),
    );
}

/// The walls around a wing as it is placed, or why no correction holds.
fn walls(scene: &Scene, known: &InWind) -> Result<Walls, &'static str> {
    if !matches!(known.air.flow, Flow::WindTunnel { speed_m_s, .. } if speed_m_s > 0.0) {
        return Err("there is no wind to refer to");
    }
    if !scene.rigid_bodies.is_empty() {
        return Err("there are several bodies");
    }
    let wing = &known.wing.built;
    let place = |node: u32| known.designed_m[node as usize];
    let [left, right] = wing.tip_noses.map(place);
    let [nose, tail] = wing.middle_chord_m(known.designed_m);
    let cell_m = known.air.units.cell_size_m;
    let section_m = [1, 2].map(|axis| known.air.cells[axis] as f64 * cell_m);
    let span_m = (right.y - left.y).abs();
    if span_m > WIDEST * section_m[0] {
        return Err("the wing spans more than 0.8 of the width of the tunnel");
    }
    // A quarter of the chord behind the nose, halfway between the middle and the tips.
    let noses_m = 0.5 * nose.z + 0.25 * (left.z + right.z);
    let height_m = noses_m + 0.25 * (tail.z - nose.z);
    let nearest_m = height_m.min(section_m[1] - height_m);
    if nearest_m < NEAREST * wing.measures.largest_chord_m {
        return Err("the wing is nearer than a chord to the floor or the ceiling");
    }
    let across_m = 0.5 * (left.y + right.y);
    if span_m > WIDEST * 2.0 * across_m.min(section_m[0] - across_m) {
        return Err("a tip is too near to a side wall");
    }
    let line = LiftingLine {
        section_m,
        span_m,
        middle_m: [across_m - 0.5 * section_m[0], height_m - 0.5 * section_m[1]],
    };
    let section_m2 = known.air.section_m2();
    Ok(Walls {
        blockage: frontal_area_m2(known) / section_m2,
        upwash: line.interference() * wing.measures.flat_area_m2 / section_m2,
    })
}

/// Area of a wing seen along the wind, as it is placed and designed, without lines: heights of its ribs times the widths between them [m²].
fn frontal_area_m2(known: &InWind) -> f64 {
    let rib = |outline: &Vec<u32>| {
        let places = || outline.iter().map(|&n| known.designed_m[n as usize]);
        let high = places().map(|p| p.z).fold(f64::NEG_INFINITY, f64::max);
        let low = places().map(|p| p.z).fold(f64::INFINITY, f64::min);
        let across = places().map(|p| p.y).sum::<f64>() / outline.len() as f64;
        (across, high - low)
    };
    let ribs: Vec<(f64, f64)> = known.wing.built.outlines.iter().map(rib).collect();
    ribs.windows(2)
        .map(|pair| (pair[1].0 - pair[0].0).abs() * 0.5 * (pair[0].1 + pair[1].1))
        .sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn mean(value: f64, confidence: f64) -> Mean {
        Mean {
            value,
            confidence: Some(confidence),
        }
    }

    /// C_L 1, C_D 0.1 of a wing with δ 0.137 on a tenth of the section, of which it blocks a twentieth.
    #[test]
    fn the_corrections_by_hand() {
        let walls = Walls {
            blockage: 0.05,
            upwash: 0.0137,
        };
        let ratio = 1.0125f64.powi(2);
        assert_eq!(walls.pressure_ratio(), ratio);
        let lift = walls.lift(mean(1.0, 0.02));
        assert!((lift.value - 1.0 / ratio).abs() < 1e-12);
        let incidence = walls.incidence_deg(lift);
        assert!((incidence.value - 0.784_95 / ratio).abs() < 1e-4);
        let drag = walls.drag(mean(0.1, 0.004), lift);
        assert!((drag.value - (0.1 / ratio + 0.0137 / ratio.powi(2))).abs() < 1e-12);
        let interval = 0.004 / ratio + 2.0 * 0.0137 * 0.02 / ratio.powi(2);
        assert!((drag.confidence.unwrap() - interval).abs() < 1e-12);
        // Without an interval of the lift, the drag has none.
        let unknown = Mean {
            value: lift.value,
            confidence: None,
        };
        assert!(walls.drag(mean(0.1, 0.004), unknown).confidence.is_none());
    }

    /// Nothing of a wing in a section without bounds.
    #[test]
    fn far_walls_do_nothing() {
        let walls = Walls {
            blockage: 0.0,
            upwash: 0.0,
        };
        let (lift, drag) = (mean(0.7, 0.1), mean(0.05, 0.01));
        assert_eq!(walls.lift(lift), lift);
        assert_eq!(walls.drag(drag, lift), drag);
        assert_eq!(walls.incidence_deg(lift), mean(0.0, 0.0));
    }
}
