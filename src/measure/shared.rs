//! Read-outs that several kinds of scenes have.

use super::read_out::{ReadOut, When, results};
use super::strengths::{Carrier, strengths_n};
use crate::case::Scene;
use crate::case::coupling::Scheme;
use crate::frame::CableKind;

/// Markers leave slip; at cut links the wall's velocity is met at the cut.
pub(super) static BY_MARKERS: When<Scene> = When {
    words: "where markers act on the air",
    holds: |scene| {
        scene
            .coupling
            .is_some_and(|coupling| coupling.scheme == Scheme::Kernel)
    },
};

fn has(scene: &Scene, kind: CableKind) -> bool {
    let structure = scene.body.as_ref().map(|body| &body.structure);
    structure.is_some_and(|structure| structure.cables.iter().any(|cable| cable.kind == kind))
}

pub(super) static BELTS: When<Scene> = When {
    words: "with belts",
    holds: |scene| has(scene, CableKind::Belt),
};

/// True if the breaking load of a cable of the kind is told.
fn tells_strength(scene: &Scene, of: Carrier) -> bool {
    let structure = scene.body.as_ref().map(|body| &body.structure);
    structure.is_some_and(|structure| strengths_n(structure, of).flatten().next().is_some())
}

pub(super) static LINE_STRENGTHS: When<Scene> = When {
    words: "with lines whose breaking load is told",
    holds: |scene| tells_strength(scene, Carrier::Lines),
};

pub(super) static TAPE_STRENGTHS: When<Scene> = When {
    words: "with belts whose breaking load is told",
    holds: |scene| tells_strength(scene, Carrier::Tapes),
};

pub(super) static VENT_LINES: When<Scene> = When {
    words: "with vent lines",
    holds: |scene| has(scene, CableKind::VentLine),
};

pub(super) static RISERS: When<Scene> = When {
    words: "with risers",
    holds: |scene| has(scene, CableKind::Riser),
};

macro_rules! rows {
    ( $( $handle:ident: $name:literal, $unit:literal, $meaning:literal; )+ ) => {
        $(
            #[doc = concat!("Read-out: ", $meaning, ".")]
            pub(crate) static $handle: ReadOut = ReadOut::new($name, $unit, $meaning);
        )+
    };
}

rows! {
    TIME: "time_s", "s", "time since release";
    WIND_SPEED: "wind_speed_m_s", "m/s", "speed of the wind at the inlet";
    IMPULSE_MARKERS: "impulse_markers_n_s", "N s", "impulse of the air along x by markers, or at cut links; since release, of bodies alone along the drag";
    IMPULSE_MOMENTUM_BOX: "impulse_momentum_box_n_s", "N s", "the same by the momentum of a box of air";
    SLIP_RATIO: "slip_ratio", "1", "mean slip of the air past the surface over the reference speed";
    MASS_DEFECT: "mass_defect", "1", "defect of the mass balance of the momentum box; over its mass; blank once a surface that cuts links has left the box";
    FORCE_X: "force_x_n", "N", "force along the wind; mean since the last sample";
    FORCE_Y: "force_y_n", "N", "force along y; mean since the last sample";
    FORCE_Z: "force_z_n", "N", "force along z; mean since the last sample";
    KINETIC_ENERGY: "fabric_kinetic_energy_j", "J", "kinetic energy of fabric and cables";
    TENSION_MAX: "tension_max_n_m", "N/m", "largest principal tension of the fabric";
    FASTEST_NODE: "fastest_node_m_s", "m/s", "speed of the fastest node";
    VON_MISES_MAX: "von_mises_max_pa", "Pa", "largest von Mises stress of the fabric";
    SHEAR_STRESS_MAX: "shear_stress_max_pa", "Pa", "largest shear stress; between warp and weft";
    STRESS_MAX: "stress_max_pa", "Pa", "largest principal stress of the fabric";
    DRAG_COEFFICIENT: "drag_coefficient", "1", "drag coefficient; drag by markers, or at cut links, over ½ ρ U² and the reference area (S_0, flat area of a wing, length times width of a plate, that of a body)";
    LIFT_COEFFICIENT: "lift_coefficient", "1", "lift coefficient; on ½ ρ U² and the flat area of a wing, or the reference area of a body";
    PROJECTED_DIAMETER_RATIO: "projected_diameter_ratio", "1", "projected over nominal diameter; the root of the ratio of the areas";
    HEIGHT: "height_m", "m", "height of the canopy; its extent along the wind";
    LINE_TENSION_MAX: "line_tension_max_n", "N", "largest tension of a suspension line";
    BELT_TENSION_MAX: "belt_tension_max_n", "N", "largest tension of a reinforcing belt";
    LINE_LOAD_SHARE: "line_load_over_breaking_load_max", "1", "load over breaking load of the line or riser nearest to breaking";
    TAPE_LOAD_SHARE: "belt_load_over_breaking_load_max", "1", "load over breaking load of the reinforcing belt, band or tape nearest to breaking";
    VENT_LINE_TENSION_MAX: "vent_line_tension_max_n", "N", "largest tension of a vent line";
    RISER_TENSION_MAX: "riser_tension_max_n", "N", "largest tension of a riser";
    CABLE_TENSION_MAX: "cable_tension_max_n", "N", "largest tension of a free-standing cable";
}

results! {
    /// Results of several kinds of scenes.
    RESULTS: "Several kinds of scenes";
    DRAG_MARKERS: "drag_markers_n", "N", "mean drag by markers, or at cut links; sum over them";
    DRAG_MOMENTUM_BOX: "drag_momentum_box_n", "N", "mean drag by the momentum of a box of air; populations through a box, with storage";
    FORCE_IMBALANCE: "force_imbalance", "1", "largest difference of the force routes over the drag";
    SLIP_MEAN: "slip_mean", "1", "mean slip of the air past the surface over the reference speed";
    MASS_DRIFT: "mass_drift", "1", "largest defect of the mass balance of the momentum box, over its mass";
    BLOCKAGE_RATIO: "blockage_ratio", "1", "nominal area of a canopy, frontal area of bodies, over the section of the tunnel";
    CORRECTED_DRAG: "{body}drag_coefficient_blockage_corrected", "1", "drag coefficient without the walls of the tunnel";
    PRESSURE_RATIO: "{body}dynamic_pressure_ratio_of_blockage", "1", "ratio of dynamic pressures that walls make; what the correction divides the drag by";
    FILL_TIME: "fill_time_s", "s", "time until a canopy or wing is full";
    STROUHAL_NUMBER: "{body}strouhal_number", "1", "frequency times length over speed; of the lift or the side force, whichever swings more, or of a plate's tip";
}
