//! What a case tells of its validity before it runs.

use super::rule::Rule;
use super::subject::{Kind, Subject, subjects};
use crate::case::Scene;
use crate::case::scene::{Air, Flow, LIQUID_KG_M3, SOUND_M_S};
use crate::measure::plate::{ACROSS, ALONG};
use crate::measure::steady::{SETTLING, SHORTEST_WINDOW};
use crate::output::{Bound, Supports, ValidityRow, When};
use crate::plan::Plan;

/// Width of the kernel through which air and structure meet [cells].
const KERNEL_CELLS: f64 = 4.0;

/// Largest pressure on a canopy that opens, over the dynamic pressure: in a tunnel, and in a fall, which slows down meanwhile.
const OPENING_PRESSURE: [f64; 2] = [3.0, 1.0];

/// Name of the row that the measured strain takes the place of at the end of a run.
pub const STRAIN_TO_BE_EXPECTED: &str = "strain to be expected";

/// The air of a case, with how long it is computed.
struct Whole<'a> {
    air: &'a Air,
    steps: u64,
    sample_s: f64,
    /// Length that times refer to over the speed of the wind [s].
    unit_s: Option<f64>,
    bluff: bool,
    reynolds: f64,
    /// Of the wind, or of what moves faster [m/s].
    fastest_m_s: f64,
    /// Populations are kept in 16 bits.
    in_sixteen_bits: bool,
}

const fn of_the_air<'a>() -> [Rule<Whole<'a>>; 7] {
    [
        Rule {
            name: "physical Mach number",
            unit: "1",
            meaning: "speed of the wind, or of the fastest body, over that of sound in air at 15 degrees; the equations are those of air that is not compressed",
            bound: Bound::AtMost,
            limit: 0.3,
            supports: Supports::Everything,
            remedy: "lower the wind: compressible air is not modelled",
            value: |whole| {
                let gas = whole.air.units.density_kg_m3 < LIQUID_KG_M3;
                gas.then(|| whole.fastest_m_s / SOUND_M_S)
            },
        },
        Rule {
            name: "Mach number on the lattice",
            unit: "1",
            meaning: "speed of the wind, or of the fastest body, over that of sound on the lattice; errors grow with its square",
            bound: Bound::AtMost,
            limit: 0.3,
            supports: Supports::Everything,
            remedy: "lower resolution.lattice_speed",
            value: |whole| Some(whole.fastest_m_s / whole.air.units.speed_m_s() * 3f64.sqrt()),
        },
        Rule {
            name: "Reynolds number without added viscosity",
            unit: "1",
            meaning: "of what stands in the air; beyond the limit the flow around bluff bodies breaks down without an eddy viscosity or a stabilised operator",
            bound: Bound::AtMost,
            limit: 5e3,
            supports: Supports::Everything,
            remedy: "take resolution.operator = \"stabilised_regularised\", or add resolution.eddy_viscosity, Smagorinsky's with 0.15",
            value: |whole| {
                let added =
                    whole.air.eddy_viscosity.is_some() || whole.air.operator.stands_bluff_bodies();
                (whole.bluff && !added).then_some(whole.reynolds)
            },
        },
        Rule {
            name: "steps of the run",
            unit: "1",
            meaning: "steps of the air from release to the end",
            bound: Bound::AtLeast,
            limit: 50.0,
            supports: Supports::Everything,
            remedy: "lengthen time.end_s: the run is over before anything has happened",
            value: |whole| Some(whole.steps as f64),
        },
        Rule {
            name: "steps per length over speed",
            unit: "1",
            meaning: "steps of the air in D_0/U, chord/U, D/U",
            bound: Bound::AtLeast,
            limit: 30.0,
            supports: Supports::Everything,
            remedy: "lower resolution.lattice_speed or take more cells",
            value: |whole| Some(whole.unit_s? / whole.air.units.time_step_s),
        },
        Rule {
            name: "steps per length over speed, 16 bits",
            unit: "1",
            meaning: "steps of the air in D_0/U, chord/U, D/U: populations in 16 bits lose what changes by less than 2^-12 in a step, such as viscous decay over many cells",
            bound: Bound::AtMost,
            limit: 1000.0,
            supports: Supports::Everything,
            remedy: "take --precision f32",
            value: |whole| {
                let steps = whole.unit_s? / whole.air.units.time_step_s;
                whole.in_sixteen_bits.then_some(steps)
            },
        },
        Rule {
            name: "samples per length over speed",
            unit: "1",
            meaning: "rows of history.csv in D_0/U, chord/U, D/U; extremes and intervals are read from them",
            bound: Bound::AtLeast,
            limit: 4.0,
            supports: Supports::Everything,
            remedy: "shorten output.sample_interval_s",
            value: |whole| Some(whole.unit_s? / whole.sample_s.max(whole.air.units.time_step_s)),
        },
    ]
}

const fn of_subjects<'a>() -> [Rule<Subject<'a>>; 31] {
    [
        Rule {
            name: "cells across D_0",
            unit: "1",
            meaning: "cells over the nominal diameter, for means; drag still falls by 3 to 5 % from 16 to 48",
            bound: Bound::AtLeast,
            limit: 16.0,
            supports: Supports::Means,
            remedy: "raise resolution.cells_per_diameter",
            value: |of| (of.kind == Kind::Canopy).then(|| of.cells()),
        },
        Rule {
            name: "cells across D_0 for an opening",
            unit: "1",
            meaning: "cells over the nominal diameter; from 96 to 192 the time to open a wide mouth changes by 1 %, that of narrow ones by 6 to 22 %",
            bound: Bound::AtLeast,
            limit: 128.0,
            supports: Supports::Opening,
            remedy: "compare three lattices: ripstop sweep over resolution.cells_per_diameter",
            value: |of| (of.kind == Kind::Canopy).then(|| of.cells()),
        },
        Rule {
            name: "cells across the mouth at release",
            unit: "1",
            meaning: "cells over the diameter of the mouth; with 17 the time to open changes by 12 % on twice as fine cells, with 34 by 1 %",
            bound: Bound::AtLeast,
            limit: 33.0,
            supports: Supports::Opening,
            remedy: "raise resolution.cells_per_diameter, or release a wider mouth",
            value: |of| Some(of.mouth_m? / of.cell_m()),
        },
        Rule {
            name: "cells across the boundary layer",
            unit: "1",
            meaning: "cells over the layer of a flat plate of length D_0, where the air sticks to the fabric; with 5 times to open change by 9 % on twice as fine cells, with 17 by 2 %",
            bound: Bound::AtLeast,
            limit: 16.0,
            supports: Supports::Opening,
            remedy: "take fabric.friction = \"model\", with resolution.operator = \"stabilised_regularised\"",
            value: |of| of.boundary_layer_m().map(|layer_m| layer_m / of.cell_m()),
        },
        Rule {
            name: "cells across the narrowest hole",
            unit: "1",
            meaning: "cells over a vent; from one cell on a hole passes what it should within 20 %",
            bound: Bound::AtLeast,
            limit: 1.0,
            supports: Supports::Everything,
            remedy: "raise the resolution, close it, or give a permeability with a discharge_coefficient",
            value: |of| of.hole_cells().filter(|_| !of.cuts_links()),
        },
        Rule {
            name: "cells across the narrowest hole, cut links",
            unit: "1",
            meaning: "cells over a vent in fabric that cuts links; from two cells on a hole passes what it should within 15 %",
            bound: Bound::AtLeast,
            limit: 2.0,
            supports: Supports::Everything,
            remedy: "raise the resolution, close it, or give a permeability with a discharge_coefficient",
            value: |of| of.hole_cells().filter(|_| of.cuts_links()),
        },
        Rule {
            name: "cells across the narrowest gap or slot",
            unit: "1",
            meaning: "cells over a gap, slot or intake; from two cells on it passes what it should within 20 %",
            bound: Bound::AtLeast,
            limit: 2.0,
            supports: Supports::Everything,
            remedy: "raise the resolution, or give a permeability with a discharge_coefficient",
            value: |of| of.slot_cells().filter(|_| !of.cuts_links()),
        },
        Rule {
            name: "cells across the narrowest gap or slot, cut links",
            unit: "1",
            meaning: "cells over a gap, slot or intake in fabric that cuts links; from three cells on it passes what it should within 15 %",
            bound: Bound::AtLeast,
            limit: 3.0,
            supports: Supports::Everything,
            remedy: "raise the resolution, or give a permeability with a discharge_coefficient",
            value: |of| of.slot_cells().filter(|_| of.cuts_links()),
        },
        Rule {
            name: "cells across the chord",
            unit: "1",
            meaning: "cells over the largest chord, for drag and shape; the lift of a section at cut links scatters by 17 % with 24, by 3 and 6 % with 32 and 48",
            bound: Bound::AtLeast,
            limit: 32.0,
            supports: Supports::Means,
            remedy: "take more cells over the chord",
            value: |of| (of.kind == Kind::Wing || of.is_closed_wing()).then(|| of.cells()),
        },
        Rule {
            name: "trailing edge within the kernel",
            unit: "1",
            meaning: "share of the chord that the kernel of 4 cells blurs at the trailing edge, where the flow must leave smoothly",
            bound: Bound::AtMost,
            limit: 0.04,
            supports: Supports::Lift,
            remedy: "take lift from the panel method (equilibrium.trim): wings do not fly on such a lattice",
            value: |of| {
                (of.kind == Kind::Wing && !of.cuts_links()).then(|| KERNEL_CELLS / of.cells())
            },
        },
        Rule {
            name: "cells across the chord for lift, cut links",
            unit: "1",
            meaning: "cells over the chord of a wing that cuts links; a rigid ram-air wing's lift at 4 and 12 degrees is off by up to 6 % with 24 and 10 % with 48, a section's by 3 % with 24 to 48; one of fabric has half to nine tenths of the rigid one's with 24",
            bound: Bound::AtLeast,
            limit: 96.0,
            supports: Supports::Lift,
            remedy: "raise resolution.cells_per_chord, or take lift from the panel method (equilibrium.trim)",
            value: |of| (of.kind == Kind::Wing && of.cuts_links()).then(|| of.cells()),
        },
        Rule {
            name: "cells across the thickness",
            unit: "1",
            meaning: "cells over the thickness of what has an inside: of a body the median, of a wing of fabric the largest at its root; the kernel takes two from every side",
            bound: Bound::AtLeast,
            limit: 4.0,
            supports: Supports::Everything,
            remedy: "raise the resolution, or model it as an open surface",
            value: |of| of.thickness_cells(false),
        },
        Rule {
            name: "cells across the thickness, cut links",
            unit: "1",
            meaning: "cells over the median thickness of a body; closed wings have their lift within 4 %, at 0 to 12 degrees with 2.3, at 8 with 3.1 and 4.6",
            bound: Bound::AtLeast,
            limit: 2.0,
            supports: Supports::Everything,
            remedy: "raise the resolution, or model it as an open surface",
            value: |of| of.thickness_cells(true),
        },
        Rule {
            name: "cells across the length",
            unit: "1",
            meaning: "cells over a plate or sheet with markers; a flag's frequency errs by 17 %, a plate's bending by 12 % with 24 to 36",
            bound: Bound::AtLeast,
            limit: 48.0,
            supports: Supports::Means,
            remedy: "raise the resolution",
            value: |of| (of.kind == Kind::Sheet && !of.cuts_links()).then(|| of.cells()),
        },
        Rule {
            name: "cells across the length, cut links",
            unit: "1",
            meaning: "cells over a plate or sheet that cuts links; a flag's frequency errs by 19 % with 16, by 1 % with 20 and 24",
            bound: Bound::AtLeast,
            limit: 20.0,
            supports: Supports::Means,
            remedy: "raise the resolution",
            value: |of| (of.kind == Kind::Sheet && of.cuts_links()).then(|| of.cells()),
        },
        Rule {
            name: "cells across the body",
            unit: "1",
            meaning: "cells over the reference length; the drag of a sphere errs by 7 % with 8, 2 % with 12",
            bound: Bound::AtLeast,
            limit: 12.0,
            supports: Supports::Everything,
            remedy: "raise the resolution",
            value: |of| matches!(of.kind, Kind::Round | Kind::Rigid).then(|| of.cells()),
        },
        Rule {
            name: "cells across a flat body, cut links",
            unit: "1",
            meaning: "cells over a disk or plate across the stream; its drag hangs on where it stands between them, by 16, 8 and 1.5 % with 8, 16 and 24",
            bound: Bound::AtLeast,
            limit: 24.0,
            supports: Supports::Means,
            remedy: "raise the resolution, or take coupling.scheme = \"kernel\"",
            value: |of| (of.is_flat() && of.is_bluff() && of.cuts_links()).then(|| of.cells()),
        },
        Rule {
            name: "overlap with another body",
            unit: "1",
            meaning: "share of the body's surface that lies inside another body, or on its surface, at the start; both would share the force arbitrarily",
            bound: Bound::AtMost,
            limit: 0.0,
            supports: Supports::Everything,
            remedy: "move one of them, or join them in one mesh",
            value: |of| of.overlap(),
        },
        Rule {
            name: "distance to the inlet",
            unit: "1",
            meaning: "from the inlet to the middle, over the diameter across the stream (0.7 D_0 of a canopy); 2 add 5 % to the drag",
            bound: Bound::AtLeast,
            limit: 2.0,
            supports: Supports::Everything,
            remedy: "move it downstream, or the inlet away from it",
            value: |of| (of.kind != Kind::Wing).then(|| of.inlet()),
        },
        Rule {
            name: "distance to the sponge or outlet",
            unit: "1",
            meaning: "from the middle to the sponge, or the outlet, over the diameter across the stream; 1 adds 7 % to the drag",
            bound: Bound::AtLeast,
            limit: 1.5,
            supports: Supports::Everything,
            remedy: "lengthen the box downstream",
            value: |of| {
                // A body may pass through the outlet by intent, but not a sponge.
                let through = of.passed[0][1] && !of.sponge();
                (of.kind != Kind::Wing && !through).then(|| of.outlet())
            },
        },
        Rule {
            name: "distance to the side walls",
            unit: "1",
            meaning: "from the nearest side wall at the start, over the diameter across the stream, or the larger extent of plates and sheets; sides that it passes through or stands on do not count",
            bound: Bound::AtLeast,
            limit: 0.5,
            supports: Supports::Everything,
            remedy: "widen air.wind_tunnel.size_m, or keep away from the wall",
            value: |of| of.wall().filter(|_| of.kind != Kind::Wing),
        },
        Rule {
            name: "blockage",
            unit: "1",
            meaning: "nominal area of a canopy over the section of the box: its drag is corrected for the walls up to here",
            bound: Bound::AtMost,
            limit: 0.1,
            supports: Supports::Means,
            remedy: "widen air.wind_tunnel.size_m, or take the corrected coefficient",
            value: |of| (of.kind == Kind::Canopy).then(|| of.blockage()),
        },
        Rule {
            name: "blockage of the body",
            unit: "1",
            meaning: "frontal area over the section of the box, of a plate across the stream all of its area; 5 % add 7 % to the drag",
            bound: Bound::AtMost,
            limit: 0.05,
            supports: Supports::Means,
            remedy: "widen air.wind_tunnel.size_m, or take the corrected coefficient where there is one",
            value: Subject::blockage_of_a_body,
        },
        Rule {
            name: "length of the box",
            unit: "1",
            meaning: "length of the box of air over the nominal diameter",
            bound: Bound::AtLeast,
            limit: 5.0,
            supports: Supports::Means,
            remedy: "lengthen air.wind_tunnel.size_m",
            value: |of| (of.kind == Kind::Canopy).then(|| of.box_m(0) / of.length_m),
        },
        Rule {
            name: "length of the run",
            unit: "1",
            meaning: "D_0/U from release to the end: the opening takes 2, the wake settles for 18, means need 6",
            bound: Bound::AtLeast,
            limit: 2.0 + SETTLING + SHORTEST_WINDOW,
            supports: Supports::Means,
            remedy: "lengthen time.end_s",
            value: |of| {
                let canopy = of.kind == Kind::Canopy && of.scene.descent.is_none();
                let end_s = of.scene.time.as_ref()?.end_s;
                canopy.then(|| end_s * of.speed_m_s() / of.length_m)
            },
        },
        Rule {
            name: "length of the run, along the stream",
            unit: "1",
            meaning: "L/U from t = 0 to the end, of sheets, and plates along the stream: a flag's first swings last to 16, five of its periods take 20",
            bound: Bound::AtLeast,
            limit: ALONG[0] + ALONG[1],
            supports: Supports::Means,
            remedy: "lengthen time.end_s",
            value: |of| of.length_of_run(true),
        },
        Rule {
            name: "length of the run, across the stream",
            unit: "1",
            meaning: "b/U from t = 0 to the end, of plates across the stream with the lesser side b: the wake settles for 30, as a rigid body's, means need 20",
            bound: Bound::AtLeast,
            limit: ACROSS[0] + ACROSS[1],
            supports: Supports::Means,
            remedy: "lengthen time.end_s",
            value: |of| of.length_of_run(false),
        },
        Rule {
            name: "length of the run over settling",
            unit: "1",
            meaning: "time from t = 0 to the end over what a rigid body's flow takes to settle and its mean needs",
            bound: Bound::AtLeast,
            limit: 1.0,
            supports: Supports::Means,
            remedy: "lengthen time.end_s",
            value: |of| Some(of.scene.time.as_ref()?.end_s / of.settling_s?),
        },
        Rule {
            name: "Knudsen number on the lattice",
            unit: "1",
            meaning: "mean free path of the lattice's gas over the length, 1.25 Ma/Re: where it is large, air slips along walls; a sphere at Re 1 has 2 to 3 % less drag with 0.022, 12 to 16 % less with 0.087",
            bound: Bound::AtMost,
            limit: 0.025,
            supports: Supports::Everything,
            remedy: "lower resolution.lattice_speed",
            value: |of| Some(of.knudsen()),
        },
        Rule {
            name: "Reynolds number of a smooth round body",
            unit: "1",
            meaning: "beyond 2e5 the boundary layer of a sphere or cylinder turns turbulent and its drag falls: no layer is resolved or modelled",
            bound: Bound::AtMost,
            limit: 2e5,
            supports: Supports::Everything,
            remedy: "stay below the drag crisis, or compare with nothing beyond it",
            value: |of| (of.kind == Kind::Round).then(|| of.reynolds()),
        },
        Rule {
            name: STRAIN_TO_BE_EXPECTED,
            unit: "1",
            meaning: "pressure of an opening, 3 times the dynamic one (1 in a fall), on half the radius, over the membrane stiffness; laws are those of small strain",
            bound: Bound::AtMost,
            limit: 0.1,
            supports: Supports::Everything,
            remedy: "lower the wind, or check fabric.youngs_modulus_pa and fabric.thickness_m",
            value: expected_strain,
        },
    ]
}

/// σ/E of a sphere of half the diameter under the pressure of an opening.
fn expected_strain(of: &Subject) -> Option<f64> {
    let membrane = of.scene.body.as_ref()?.structure.membrane.as_ref()?;
    if of.kind != Kind::Canopy {
        return None;
    }
    let softest = membrane.stretching_stiffness_n_m();
    let pressure_pa = OPENING_PRESSURE[usize::from(!of.held)] * of.dynamic_pressure_pa();
    let tension_n_m = 0.5 * pressure_pa * 0.5 * of.across_m;
    Some(tension_n_m / softest)
}

/// Rows that the case alone tells.
#[must_use]
pub fn beforehand(scene: &Scene, plan: &Plan) -> Vec<ValidityRow> {
    let mut rows = Vec::new();
    let Some(air) = scene.air.as_ref() else {
        return rows;
    };
    if !matches!(air.flow, Flow::WindTunnel { .. }) {
        return rows;
    }
    let subjects = subjects(scene);
    let longest = subjects
        .iter()
        .max_by(|a, b| a.length_m.total_cmp(&b.length_m));
    let whole = Whole {
        air,
        steps: plan.steps,
        sample_s: scene.output.sample_interval_s,
        unit_s: longest.map(|of| of.length_m / of.speed_m_s()),
        bluff: subjects.iter().any(|of| of.kind != Kind::Sheet),
        reynolds: longest.map_or(0.0, Subject::reynolds),
        fastest_m_s: subjects
            .iter()
            .map(Subject::speed_m_s)
            .fold(air.wind_or_reference_m_s(), f64::max),
        in_sixteen_bits: plan.placement.air.is_in_sixteen_bits(),
    };
    let when = When::Beforehand;
    rows.extend(
        of_the_air()
            .iter()
            .filter_map(|rule| rule.row(&whole, ("", ""), when)),
    );
    for subject in &subjects {
        let names = (subject.name.as_str(), subject.prefix.as_str());
        rows.extend(
            of_subjects()
                .iter()
                .filter_map(|rule| rule.row(subject, names, when)),
        );
    }
    rows
}
