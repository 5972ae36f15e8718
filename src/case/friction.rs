//! How the air passes along fabric, bodies and the parts of wings: keys `friction`, and `coupling.transition_reynolds`.

use super::air::Air;
use super::body::Body;
use super::coupling::{Coupling, Friction, Scheme};
use super::file::{File, Structure};
use super::problem::Problem;
use super::usual;
use super::values::{wing_key, within};
use super::wing::Wing;
use crate::lattice::Operator;

/// Reynolds number of the length of run beyond which no layer is laminar; larger ones say so, too.
const LARGEST_TRANSITION_REYNOLDS: f64 = 1e9;

const TRANSITION: &str = "coupling.transition_reynolds";

/// Friction of everything in the air.
#[derive(Debug, Clone, PartialEq)]
pub struct SurfaceFriction {
    /// Of the fabric's triangles.
    pub fabric: Vec<Friction>,
    /// Of the rigid bodies.
    pub bodies: Vec<Friction>,
    /// Reynolds number of the length of run at which modelled boundary layers turn turbulent.
    pub transition_reynolds: f64,
}

impl SurfaceFriction {
    /// True if a part has this.
    #[must_use]
    pub fn has(&self, friction: Friction) -> bool {
        self.fabric.contains(&friction) || self.bodies.contains(&friction)
    }
}

/// Checks the friction of everything that `coupling` joins with the air.
pub(super) fn check(
    file: &File,
    (air, body): (Option<&Air>, Option<&Body>),
    coupling: Option<&Coupling>,
) -> Result<Option<SurfaceFriction>, Problem> {
    let scheme = coupling.map(|coupling| coupling.scheme);
    let written = |key: String, written: Option<Friction>| -> Result<Friction, Problem> {
        if scheme.is_none() {
            return match written {
                None => Ok(Friction::NoSlip),
                Some(_) => Err(Problem::new(
                    key.as_str(),
                    format!("{key} has no effect: it needs air that the surface meets"),
                    format!("remove {key}, or add [air] and [coupling]"),
                )),
            };
        }
        let friction = usual::or(key.as_str(), written, Friction::NoSlip);
        if friction == Friction::NoSlip || scheme == Some(Scheme::Links) {
            return Ok(friction);
        }
        let name = friction.name();
        Err(Problem::new(
            key.as_str(),
            format!(
                "{key} = \"{name}\" needs coupling.scheme = \"links\": markers hold the air in all directions"
            ),
            format!("give coupling.scheme = \"links\", or remove {key}"),
        ))
    };
    let mut of_fabrics = Vec::new();
    if let Some(fabric) = &file.fabric {
        of_fabrics.push(written("fabric.friction".to_owned(), fabric.friction)?);
    }
    if let Some(Structure::Mesh(mesh)) = &file.structure {
        for (name, further) in &mesh.further {
            if let Some(fabric) = &further.fabric {
                let key = format!("structure.mesh.further.{name}.fabric.friction");
                of_fabrics.push(written(key, fabric.friction)?);
            }
        }
    }
    let mut bodies = Vec::new();
    for (name, table) in &file.bodies {
        bodies.push(written(format!("bodies.{name}.friction"), table.friction)?);
    }
    let Some(coupling) = coupling else {
        return Ok(None);
    };
    let fabric = match body {
        Some(body) => match body.wing() {
            Some(wing) => of_wing(wing, coupling)?,
            None => (body.structure.triangles.iter())
                .map(|triangle| of_fabrics.get(triangle.fabric as usize))
                .map(|friction| friction.copied().unwrap_or(Friction::NoSlip))
                .collect(),
        },
        None => Vec::new(),
    };
    let slides = (fabric.iter().chain(&bodies)).any(|friction| *friction != Friction::NoSlip);
    if slides
        && coupling.scheme == Scheme::Links
        && air.is_some_and(|air| air.operator == Operator::RecursiveRegularised)
    {
        return Err(Problem::new(
            "resolution.operator",
            "with resolution.operator = \"recursive_regularised\" the air breaks down where it slides along cut links (friction = \"none\" or \"model\")",
            "give resolution.operator = \"stabilised_regularised\"",
        ));
    }
    let own = (file.coupling.as_ref()).and_then(|coupling| coupling.transition_reynolds);
    let mut friction = SurfaceFriction {
        fabric,
        bodies,
        transition_reynolds: 0.0,
    };
    if friction.has(Friction::Model) {
        friction.transition_reynolds = within(
            TRANSITION,
            usual::or(TRANSITION, own, 0.0),
            0.0,
            LARGEST_TRANSITION_REYNOLDS,
        )?;
    } else if own.is_some() {
        return Err(Problem::new(
            TRANSITION,
            format!("{TRANSITION} has no effect: nothing has friction = \"model\""),
            format!("remove {TRANSITION}, or give a surface friction = \"model\""),
        ));
    }
    Ok(Some(friction))
}

/// Whether anything is written to have modelled boundary layers, before it is checked.
pub(super) fn models_layers(file: &File, body: Option<&Body>) -> bool {
    let tunnel = body
        .and_then(Body::wing)
        .and_then(|wing| wing.tunnel.as_ref());
    let of_wing = tunnel.map(|tunnel| [tunnel.friction, tunnel.inner_friction]);
    let further = match &file.structure {
        Some(Structure::Mesh(mesh)) => Some(mesh.further.values()),
        _ => None,
    };
    let of_further = (further.into_iter().flatten())
        .filter_map(|further| further.fabric.as_ref().and_then(|fabric| fabric.friction));
    (of_wing.into_iter().flatten())
        .chain(file.fabric.iter().filter_map(|fabric| fabric.friction))
        .chain(of_further)
        .chain(file.bodies.values().filter_map(|body| body.friction))
        .any(|friction| friction == Friction::Model)
}

/// Friction of a wing's triangles.
fn of_wing(wing: &Wing, coupling: &Coupling) -> Result<Vec<Friction>, Problem> {
    let inner = wing.built.inner_triangles();
    let Some(tunnel) = &wing.tunnel else {
        return Ok(vec![Friction::NoSlip; inner.len()]);
    };
    for (name, friction) in [
        ("friction", tunnel.friction),
        ("inner_friction", tunnel.inner_friction),
    ] {
        let key = wing_key(&format!("tunnel.{name}"));
        if friction == Friction::Model && coupling.scheme == Scheme::Kernel {
            return Err(Problem::new(
                key.as_str(),
                format!(
                    "{key} = \"model\" needs coupling.scheme = \"links\": markers know no boundary layer"
                ),
                format!("give coupling.scheme = \"links\", or {key} = \"none\" or \"no_slip\""),
            ));
        }
    }
    let of = |inner: bool| {
        if inner {
            tunnel.inner_friction
        } else {
            tunnel.friction
        }
    };
    Ok(inner.into_iter().map(of).collect())
}
