//! What a run leaves out, and why.

use crate::case::Scene;
use crate::case::coupling::{Friction, Scheme};
use crate::case::scene::{Air, Body, BodyKind, Flow};
use crate::cloth::patches::{Patches, REACH};

/// Something that the scene does not need.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Skip {
    /// What is left out.
    pub what: &'static str,
    /// Why.
    pub why: String,
}

pub(super) fn skips(scene: &Scene) -> Vec<Skip> {
    let mut skips = Vec::new();
    let mut skip = |what: &'static str, why: String| skips.push(Skip { what, why });
    match &scene.air {
        None => {
            skip(
                "air (populations, boundaries, body force)",
                "the case has no [air]".into(),
            );
            skip(
                "markers, interpolation, spreading",
                "there is no air to couple with".into(),
            );
        }
        Some(air) => skip_air(scene, air, &mut skip),
    }
    match &scene.body {
        None => skip(
            "structure (nodes, elements, solver)",
            "the case has no [structure]".into(),
        ),
        Some(body) => {
            let structure = &body.structure;
            if scene.time.is_some() && !scene.fabric_is_solved() {
                skip("solves of the fabric", "all of it is held".into());
            }
            if structure.membrane.is_none() || structure.triangles.is_empty() {
                skip(
                    "membrane elements",
                    "no fabric modelled by membranes".into(),
                );
            }
            if structure.springs.is_empty() {
                skip(
                    "spring network and bending",
                    "no sheet with model = \"network\"".into(),
                );
            }
            if structure.cables.is_empty() {
                skip("cables", "the structure has no lines and no belts".into());
            }
            if structure.guides.is_empty() {
                skip("guides", "no apex_guide_n_m, no pitch_guide_n_m".into());
            }
            if structure.contact.is_none() && !structure.triangles.is_empty() {
                skip(
                    "contact of fabric with itself",
                    "the case has no [contact]: fabric passes through itself".into(),
                );
            }
            if scene.gravity_m_s2.is_none() {
                skip("gravity", "the case has no [gravity]".into());
            }
            if let BodyKind::Canopy(_) = &body.kind
                && scene.steady_drag_confidence.is_none()
            {
                skip(
                    "steady-state detection",
                    "the case has no [steady]: the run goes to time.end_s".into(),
                );
            }
            if scene.supports.is_empty() && scene.air.is_none() {
                skip("motion of supports", "the case has no [supports]".into());
            }
            if let (Some(time), None) = (scene.time, &scene.air)
                && time.adaptive.is_none()
            {
                skip(
                    "division of steps by accuracy",
                    format!("no [time.adaptive]: every step takes {:e} s", time.step_s),
                );
            }
            if scene.time.is_none() {
                skip(
                    "motion (inertia, time steps)",
                    "the case has no [time]: only the equilibrium is sought".into(),
                );
            }
        }
    }
    skips
}

pub(super) fn skip_air(scene: &Scene, air: &Air, skip: &mut impl FnMut(&'static str, String)) {
    if air.boxes.is_empty() {
        let why = match air.most_levels {
            0 => "the case asks for none (air.refinement.around)",
            _ => "there is no room for them, or they save no work",
        };
        skip("boxes of finer cells", why.into());
    }
    let by_links = scene.coupling.is_some_and(|c| c.scheme == Scheme::Links);
    if scene.coupling.is_none() {
        skip(
            "markers, interpolation, spreading, body force",
            "the case has neither [structure] nor [bodies]".into(),
        );
    } else if by_links {
        skip(
            "markers, interpolation, spreading, body force",
            "coupling.scheme = \"links\": what leaves along cut links comes back".into(),
        );
    } else if scene.rigid_bodies.is_empty() {
        skip("rigid bodies", "the case has no [bodies]".into());
    } else if scene.coupling.is_some_and(|c| c.passes == 1) {
        skip("further passes of forcing", "no coupling.passes".into());
    }
    let fabric = scene.body.as_ref();
    if let (true, Some(body)) = (by_links, fabric)
        && Patches::new(&body.structure.triangles, air.units.cell_size_m).is_none()
    {
        skip(
            "triangles that share what the air does to them",
            format!("their middles lie more than {REACH} cells apart"),
        );
    }
    let permeable = fabric.is_some_and(|body| body.structure.permeability.is_some())
        || scene.rigid_bodies.iter().any(|b| b.permeability.is_some());
    if scene.coupling.is_some() && !permeable {
        skip(
            "air through surfaces",
            "no fabric.permeability, no bodies.NAME.permeability".into(),
        );
    }
    if let Some(friction) = &scene.friction {
        if !friction.has(Friction::Model) {
            skip(
                "models of boundary layers",
                "nothing has friction = \"model\"".into(),
            );
        }
        if by_links && !friction.has(Friction::Model) && !friction.has(Friction::None) {
            skip(
                "images of cells, along which the air slides",
                "the air sticks to every surface".into(),
            );
        }
    }
    if scene.coupling.is_some() && scene.descent.is_none() {
        skip("a fall (accelerated box)", "no [air.descent]".into());
    }
    let has_line_drag = fabric.is_some_and(|body| body.structure.has_line_drag());
    if let Some(BodyKind::Canopy(_)) = fabric.map(|body| &body.kind)
        && !has_line_drag
    {
        let why = if scene.body.as_ref().is_some_and(Body::is_from_mesh) {
            "lines of a table have none"
        } else {
            "no lines.drag_coefficient"
        };
        skip("drag of lines", why.into());
    }
    if scene.wing().is_some() && !has_line_drag {
        skip("drag of lines", "line_drag_coefficient is 0".into());
    }
    match air.flow {
        Flow::TaylorGreen { .. } => skip("inlet, outlet, walls", "the box is periodic".into()),
        Flow::WindTunnel {
            sponge_length_m: None,
            ..
        } => {
            skip("outlet sponge", "no air.wind_tunnel.sponge_length_m".into());
        }
        Flow::WindTunnel { .. } => {}
    }
    match air.eddy_viscosity {
        None => skip("eddy viscosity", "no resolution.eddy_viscosity".into()),
        Some(eddy_viscosity) if eddy_viscosity.gradient_model().is_none() => skip(
            "stage eddy_viscosity, velocity gradients",
            "Smagorinsky's model takes the stress of each cell".into(),
        ),
        Some(_) => {}
    }
    if scene.coupling.is_some() && !by_links {
        skip(
            "body force away from markers",
            "it is read only near the cells under a marker's kernel".into(),
        );
    }
}
