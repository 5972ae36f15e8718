//! Tables that nothing in a case would read: a reader would take them for effective.

use super::file::{File, Structure};
use super::problem::Problem;

/// What lines and bands belong to.
const DRAWN: &str = "a canopy drawn in the case (one from a mesh has structure.mesh.lines)";

/// Refuses them.
pub(super) fn refuse(file: &File) -> Result<(), Problem> {
    let of = |what: fn(&Structure) -> bool| file.structure.as_ref().is_some_and(what);
    let canopy = of(Structure::is_drawn_canopy);
    let fabric = of(|structure| !matches!(structure, Structure::Cable(_)));
    let one_fabric = of(|structure| !matches!(structure, Structure::Cable(_) | Structure::Wing(_)));
    for (key, present, used, what) in [
        ("lines", file.lines.is_some(), canopy, DRAWN),
        ("belts", file.belts.is_some(), canopy, DRAWN),
        ("skirt_band", file.skirt_band.is_some(), canopy, DRAWN),
        ("vent_band", file.vent_band.is_some(), canopy, DRAWN),
        ("vent_lines", file.vent_lines.is_some(), canopy, DRAWN),
        (
            "steady",
            file.steady.is_some(),
            file.air.is_some() && (of(Structure::is_canopy) || !file.bodies.is_empty()),
            "a canopy or a rigid body in wind",
        ),
        (
            "fabric",
            file.fabric.is_some(),
            one_fabric,
            "a structure of one fabric (a wing has [structure.wing.fabrics])",
        ),
        (
            "contact",
            file.contact.is_some(),
            fabric,
            "a structure with fabric",
        ),
        (
            "resolution",
            file.resolution.is_some(),
            file.air.is_some(),
            "[air]",
        ),
        (
            "gravity",
            file.gravity.is_some(),
            file.structure.is_some() || file.air.as_ref().is_some_and(|a| a.descent.is_some()),
            "[structure]",
        ),
        (
            "solver",
            file.solver.is_some(),
            file.structure.is_some(),
            "[structure]",
        ),
    ] {
        if present && !used {
            return Err(Problem::new(
                key,
                format!("[{key}] has no effect: it needs {what}"),
                format!("remove [{key}], or add {what}"),
            ));
        }
    }
    Ok(())
}
