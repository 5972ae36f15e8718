//! All tables of a case file.

use std::collections::BTreeMap;

use schemars::JsonSchema;
use serde::Deserialize;

use super::air::{Air, Resolution};
use super::bare_wing::Aero;
use super::bodies::Body;
use super::canopy::Lines;
use super::comparison::ComparisonTable;
use super::design::CanopyDesign;
use super::design_mesh::MeshDesign;
use super::design_wing::WingDesign;
use super::fabric::{CableMaterial, Contact, Fabric, TapeMaterial};
use super::nodes::{NodeSpring, Nodes};
use super::output::Output;
use super::payload::Payload;
use super::structure::Structure;
use super::supports::Support;
use super::time::{Coupling, Equilibrium, Gravity, Solver, Steady, Time};

/// A case of Ripstop, version 1: SI units, the unit in the key. What is absent is not simulated. x is downstream, z up; the box of the air
/// starts at the origin.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct File {
    // A design stands here for the schema: where a case is read it has been replaced by what follows from it.
    /// Version of the format: 1.
    pub version: u32,
    /// One line for reports and pictures; `untitled` if absent.
    pub title: Option<String>,
    /// A canopy by its design, from which all other tables follow (docs/design.md); absent: they are written.
    pub canopy: Option<CanopyDesign>,
    /// A paraglider by span, cells and class, from which all other tables follow (docs/design.md); absent: they are written.
    pub wing: Option<WingDesign>,
    /// A mesh in a stream, from which all other tables follow (docs/design.md); absent: they are written.
    pub mesh: Option<MeshDesign>,
    /// A wing by itself, for `ripstop polar`; absent: none.
    pub aero: Option<Aero>,
    /// The air; absent: none.
    pub air: Option<Air>,
    /// Lattice of the air; required with it.
    pub resolution: Option<Resolution>,
    /// What hangs or flies; absent: nothing.
    pub structure: Option<Structure>,
    /// Rigid bodies in the air, by name; absent: none.
    #[serde(default)]
    pub bodies: BTreeMap<String, Body>,
    /// Held nodes that are moved, by name; absent: none.
    #[serde(default)]
    pub supports: BTreeMap<String, Support>,
    /// What single nodes of the structure have beside, by name; absent: nothing.
    #[serde(default)]
    pub nodes: BTreeMap<String, Nodes>,
    /// Springs between nodes of the structure, by name; absent: none.
    #[serde(default)]
    pub springs: BTreeMap<String, NodeSpring>,
    /// Fabric of the structure; required unless it is a cable, or a wing, which has its own.
    pub fabric: Option<Fabric>,
    /// Suspension lines of a canopy that is drawn in the case; required with one.
    pub lines: Option<Lines>,
    /// Belts on every seam, on centre lines that carry a line, and along both sides of a slot; absent: none.
    pub belts: Option<TapeMaterial>,
    /// Band along the lower edge of a canopy (cruciform: its four ends); absent: none.
    pub skirt_band: Option<TapeMaterial>,
    /// Band around the vent or opening; absent: none.
    pub vent_band: Option<TapeMaterial>,
    /// Lines across the vent from seam to seam, joined where they cross; of the suspension lines' material if absent.
    pub vent_lines: Option<CableMaterial>,
    /// Contact of fabric with itself; absent: it passes through itself.
    pub contact: Option<Contact>,
    /// Gravity; absent: none.
    pub gravity: Option<Gravity>,
    /// What hangs on a canopy and falls with it; absent: the confluence is held.
    pub payload: Option<Payload>,
    /// Coupling of the air with a structure or rigid bodies; required where both are there.
    pub coupling: Option<Coupling>,
    /// Solver of the fabric; absent: with the values of its keys.
    pub solver: Option<Solver>,
    /// Simulated time; required with air. Absent: no motion, only the equilibrium.
    pub time: Option<Time>,
    /// Static equilibrium, after the motion if there is one; absent: none.
    pub equilibrium: Option<Equilibrium>,
    /// Stops the run when the drag is known well enough; absent: it runs to its end.
    pub steady: Option<Steady>,
    /// What to write, and how often; absent: with the values of its keys.
    pub output: Option<Output>,
    /// Values of others, by the names of results; absent: none. The run prints them beside its own and writes `comparison.csv` and `.md`.
    #[serde(default)]
    pub comparison: BTreeMap<String, ComparisonTable>,
    /// Changes to this case, by name: any of its tables, taken with `--variant NAME`. The value `"absent"` removes a key or table. A
    /// variant is checked only when it is taken.
    #[serde(default)]
    #[schemars(with = "BTreeMap<String, BTreeMap<String, serde_json::Value>>")]
    pub variants: BTreeMap<String, toml::Table>,
}

impl File {
    /// Other files that the case takes its structure and bodies from, relative to its own.
    pub(in crate::case) fn named_files(&self) -> Vec<&str> {
        let of_bodies = self.bodies.values().flat_map(|body| {
            let mesh = body.mesh.as_ref().map(|mesh| &mesh.file);
            mesh.into_iter()
                .chain(body.wing.iter().flat_map(|wing| &wing.file))
        });
        let of_structure = self.structure.iter().flat_map(Structure::named_files);
        let of_wing = self.aero.iter().flat_map(|aero| aero.wing.named_files());
        of_bodies
            .map(String::as_str)
            .chain(of_structure)
            .chain(of_wing)
            .collect()
    }

    /// Diameter of the only rigid body, if it has one [m].
    pub(in crate::case) fn only_diameter_m(&self) -> Option<f64> {
        let mut bodies = self.bodies.values();
        match (bodies.next(), bodies.next()) {
            (Some(body), None) => body.diameter_m(),
            _ => None,
        }
    }

    /// The wing of the case, if it has one.
    pub(in crate::case) fn wing(&self) -> Option<&super::wing::Wing> {
        self.structure.as_ref().and_then(Structure::wing)
    }
}
