//! A heavy cable 1.2 times as long as its span, nearly inextensible (Irvine 1981, chapter 1).

use glam::DVec3;

use super::super::report::Gate;
use super::super::session::{Session, Stop};
use super::{SETTINGS, built};
use crate::cpu::cloth::{Cloth, StepInput};
use crate::geometry::cable;
use crate::lines::Cable;
use crate::measure::catenary;
use crate::measure::extremes::largest;

const LENGTH_OVER_SPAN: f64 = 1.2;

/// Density times area [kg/m].
const MASS_PER_LENGTH_KG_M: f64 = 0.1;

pub(in super::super) fn compute(session: &mut Session) -> Result<(), Stop> {
    let weight_n_m = MASS_PER_LENGTH_KG_M * 9.81;
    let exact = catenary::solve(1.0, LENGTH_OVER_SPAN, weight_n_m);
    let exact = built(exact, "the exact catenary")?;
    let rope = Cable::linear(1e-4, MASS_PER_LENGTH_KG_M / 1e-4, 1e8);
    let ends = [DVec3::ZERO, DVec3::X];
    for segments in [25, 50, 100] {
        let structure = cable::build(ends, LENGTH_OVER_SPAN, segments, &rope);
        let mut sheet = session.sheet(Cloth::new(structure), false)?;
        let input = StepInput {
            gravity_m_s2: -9.81 * DVec3::Z,
            ..StepInput::default()
        };
        session.solve_to_rest(&mut sheet, &input, &SETTINGS)?;
        let sag = largest(sheet.cloth.positions_m.iter().map(|x| -x.z));
        let reactions = sheet.cloth.reactions_n(&input);
        let (_, pull) = reactions[0];
        let rows = [
            ("sag over span", sag, exact.sag_m),
            (
                "horizontal tension over weight of the span",
                pull.x.abs() / weight_n_m,
                exact.horizontal_tension_n / weight_n_m,
            ),
            (
                "end tension over weight of the span",
                pull.length() / weight_n_m,
                exact.end_tension_n / weight_n_m,
            ),
        ];
        for (what, value, reference) in rows {
            let row = session
                .sheet_row(&sheet, format!("{what}, {segments} segments"), value)
                .reference(reference, "exact");
            if segments == 100 {
                row.gate(Gate::Within(1e-3));
            }
        }
    }
    Ok(())
}
