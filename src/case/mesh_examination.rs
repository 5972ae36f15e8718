//! Meshes of others: what they are made of, what was joined, and what a case accepts.

use std::path::Path;
use std::sync::Arc;

use glam::{DQuat, DVec3};

use super::file::{self, File};
use super::problem::Problem;
use super::usual;
use super::values::positive;
use crate::cloth::Structure;
pub use crate::geometry::mesh::doctor::{Border, Examination, Finding, Kind, Mouth, Piece};
use crate::geometry::mesh::doctor::{NoSides, Subject, Use, Welded, examine, mouth, orient, weld};
use crate::rigid::Surface;

/// What a case takes from other files, beside its structure and bodies.
#[derive(Debug)]
pub(super) struct FromFiles<'a> {
    /// Folder that files are looked up in.
    pub folder: &'a Path,
    /// What meshes are made of.
    pub meshes: Vec<ExaminedMesh>,
    /// Nodes of a structure by the vertices of its file, where some were joined.
    pub joined: Option<Joined>,
}

impl<'a> FromFiles<'a> {
    /// Nothing yet.
    pub const fn new(folder: &'a Path) -> Self {
        Self {
            folder,
            meshes: Vec::new(),
            joined: None,
        }
    }

    /// Node of a structure, for its number in the file and beyond (ends of lines), from 0; `None` where no triangle of the vertex is left.
    pub fn node(&self, vertex: u32) -> Option<u32> {
        let Some(joined) = &self.joined else {
            return Some(vertex);
        };
        match joined.nodes.get(vertex as usize) {
            Some(node) => *node,
            None => Some(vertex - joined.nodes.len() as u32 + joined.node_count),
        }
    }
}

/// Nodes of a mesh by the vertices of its file.
#[derive(Debug)]
pub(super) struct Joined {
    /// Node of each vertex.
    pub nodes: Vec<Option<u32>>,
    /// Nodes of the mesh.
    pub node_count: u32,
}

/// A mesh of a case, examined.
#[derive(Debug, Clone)]
pub struct ExaminedMesh {
    /// Table that names it.
    pub key: String,
    /// Its file.
    pub file: String,
    /// What it is made of.
    pub examination: Examination,
    /// Nodes and triangles at rest, in the file's coordinates times its scale.
    pub surface: Arc<Surface>,
    /// Where the nodes are at the start, in the same coordinates [m], `[node_count]`.
    pub start_m: Arc<Vec<DVec3>>,
    /// What was joined, where the case asks for it.
    pub weld: Option<Weld>,
    /// Triangles that were turned, where the case asks for it.
    pub oriented: Option<usize>,
    /// Where the opening of fabric in the wind faces.
    pub heading: Option<Heading>,
    /// Findings that the case accepts.
    pub accepted: Vec<Kind>,
    /// True where findings are told but nothing is refused.
    pub is_told_only: bool,
    /// Mass of the fabric [kg]; `None` for a body.
    pub mass_kg: Option<f64>,
    /// Volume enclosed [m³]; `None` for fabric and open surfaces.
    pub volume_m3: Option<f64>,
    /// D₀, where the case gives S₀ [m].
    pub nominal_diameter_m: Option<f64>,
}

/// What joining vertices did.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Weld {
    /// Distance below which vertices were joined [m].
    pub tolerance_m: f64,
    /// Vertices that were inserted into edges of the other side of a seam.
    pub inserted: usize,
    /// Vertices that went.
    pub joined: usize,
    /// Triangles that went.
    pub collapsed: usize,
}

/// Where the opening of fabric faces, and the wind that blows along +x.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Heading {
    /// Normal of the opening as it stands in the box of the air.
    pub direction: DVec3,
    /// Angle between it and the way that the wind comes from [°].
    pub off_wind_deg: f64,
    /// Axis and angle [°] of the rotation of the file by which it would face the wind.
    pub rotation: (DVec3, f64),
}

impl Heading {
    /// Angle from which fabric hardly stands as it is meant to [°].
    const ODD_DEG: f64 = 45.0;

    /// Of a canopy (by its area) or of fabric that is deep like one; `None` without wind.
    fn new(file: &File, mouth: Option<Mouth>, rotation: DQuat) -> Option<Self> {
        let is_canopy = (file.structure.as_ref()).is_some_and(|table| table.is_canopy());
        let is_windy = (file.air.as_ref()).is_some_and(|air| air.taylor_green.is_none());
        let mouth = mouth.filter(|mouth| is_windy && (is_canopy || !mouth.is_flat))?;
        let upstream = DVec3::NEG_X;
        let mut own = mouth.direction;
        if mouth.is_flat && (rotation * own).dot(upstream) < 0.0 {
            own = -own;
        }
        let direction = rotation * own;
        let axis = own.cross(upstream);
        // Half a turn has many axes.
        let axis = axis.try_normalize().unwrap_or(DVec3::Z);
        Some(Self {
            direction,
            off_wind_deg: direction.angle_between(upstream).to_degrees(),
            rotation: (axis, own.angle_between(upstream).to_degrees()),
        })
    }

    /// True if the opening is far from facing the wind.
    #[must_use]
    pub fn is_odd(&self) -> bool {
        self.off_wind_deg > Self::ODD_DEG
    }
}

/// A mesh with its vertices joined and its triangles turned, as far as the case asks for either.
#[derive(Debug)]
pub(super) struct Prepared {
    pub welded: Welded,
    tolerance_m: Option<f64>,
    oriented: Option<usize>,
}

impl Prepared {
    fn weld(&self) -> Option<Weld> {
        let welded = &self.welded;
        self.tolerance_m
            .filter(|tolerance_m| *tolerance_m > 0.0)
            .map(|tolerance_m| Weld {
                tolerance_m,
                inserted: welded.inserted.len(),
                joined: welded.joined,
                collapsed: welded.collapsed,
            })
    }
}

impl ExaminedMesh {
    fn new(key: &str, path: &Path, examination: Examination, surface: Surface) -> Self {
        Self {
            key: key.to_owned(),
            file: path.display().to_string(),
            examination,
            start_m: Arc::new(surface.positions_m.clone()),
            surface: Arc::new(surface),
            weld: None,
            oriented: None,
            heading: None,
            accepted: Vec::new(),
            is_told_only: false,
            mass_kg: None,
            volume_m3: None,
            nominal_diameter_m: None,
        }
    }

    /// Examines fabric; the first nodes of the structure are those of the mesh.
    pub(super) fn of_fabric(
        (key, path): (&str, &Path),
        (prepared, has_numbers): (&Prepared, bool),
        start_m: Vec<DVec3>,
        structure: &Structure,
        (file, written): (&File, &file::MeshFile),
        rotation: DQuat,
    ) -> Self {
        let welded = &prepared.welded;
        let nominal_area_m2 = written.nominal_area_m2.filter(|area| *area > 0.0);
        let cell_size_m = file.resolution.as_ref().and_then(|r| r.cell_size_m);
        let cell_size_m = cell_size_m.filter(|cell| *cell > 0.0);
        let examination = examine(&Subject {
            surface: &welded.surface,
            start_m: &start_m,
            numbers: has_numbers.then_some((&welded.numbers, &welded.triangle_numbers)),
            used_as: Use::Fabric {
                anchored: &anchored(structure),
                nominal_area_m2,
            },
            cell_size_m,
        });
        let masses_kg = structure.masses_kg.iter().take(start_m.len());
        let triangles = &welded.surface.triangles;
        let mouth = mouth(&start_m, triangles, &examination.borders);
        let diameter = |area: f64| (4.0 * area / std::f64::consts::PI).sqrt();
        Self {
            start_m: Arc::new(start_m),
            weld: prepared.weld(),
            oriented: prepared.oriented,
            heading: Heading::new(file, mouth, rotation),
            accepted: written.accept.clone(),
            mass_kg: Some(masses_kg.sum()),
            nominal_diameter_m: nominal_area_m2.map(diameter),
            ..Self::new(key, path, examination, welded.surface.clone())
        }
    }

    /// Examines the surface of a rigid body.
    pub(super) fn of_body(
        key: &str,
        path: &Path,
        prepared: &Prepared,
        accepted: &[Kind],
        cell_size_m: Option<f64>,
    ) -> Self {
        let surface = prepared.welded.surface.clone();
        // Nodes that lie together are joined as a file of a body is read: it has no numbers any more.
        let examination = examine(&Subject {
            surface: &surface,
            start_m: &surface.positions_m,
            numbers: None,
            used_as: Use::RigidBody,
            cell_size_m,
        });
        Self {
            weld: prepared.weld(),
            oriented: prepared.oriented,
            accepted: accepted.to_vec(),
            volume_m3: surface.is_closed().then(|| surface.volume_m3().0.abs()),
            ..Self::new(key, path, examination, surface)
        }
    }

    /// Examines a wing of another program. Ribs on a skin and straps through them are what such a wing is made of: nothing is refused.
    pub(super) fn of_wing(key: &str, path: &Path, structure: &Structure) -> Self {
        let surface = Surface {
            positions_m: structure.positions_m.clone(),
            triangles: structure.triangles.iter().map(|t| t.nodes).collect(),
        };
        let examination = examine(&Subject {
            surface: &surface,
            start_m: &surface.positions_m,
            numbers: None,
            used_as: Use::Fabric {
                anchored: &anchored(structure),
                nominal_area_m2: None,
            },
            cell_size_m: None,
        });
        Self {
            is_told_only: true,
            mass_kg: Some(structure.masses_kg.iter().sum()),
            ..Self::new(key, path, examination, surface)
        }
    }

    /// Findings that the case does not accept.
    pub fn refused(&self) -> impl Iterator<Item = &Finding> {
        let findings = self.examination.findings.iter();
        findings.filter(|f| !self.is_told_only && !self.accepted.contains(&f.kind))
    }

    /// What the case accepts, but is not there.
    pub fn accepted_in_vain(&self) -> impl Iterator<Item = Kind> {
        let findings = &self.examination.findings;
        let accepted = self.accepted.iter().copied();
        accepted.filter(|kind| !findings.iter().any(|f| f.kind == *kind))
    }

    /// Refuses what the case does not accept.
    pub(super) fn refuse(&self) -> Result<(), Problem> {
        let refused: Vec<&Finding> = self.refused().collect();
        if refused.is_empty() {
            return Ok(());
        }
        let told: Vec<String> = refused
            .iter()
            .map(|f| format!("{} ({})", f.what, f.kind.name()))
            .collect();
        // What is joined is often of one piece then, and its seams no longer cross.
        let seams = [Kind::DoubledVertices, Kind::HangingNodes];
        let is_seam = refused.iter().any(|f| seams.contains(&f.kind));
        let remedies: Vec<String> = refused
            .iter()
            .filter(|f| {
                let follows = matches!(
                    f.kind,
                    Kind::Pieces | Kind::LoosePieces | Kind::SelfCrossing | Kind::OverlappingFaces
                );
                !is_seam || !follows
            })
            .map(|f| match refused[..] {
                [_] => f.remedy.clone(),
                _ => format!("{}: {}", f.kind.name(), f.remedy),
            })
            .collect();
        let names = self.accepted.iter().copied();
        let names = names.chain(refused.iter().map(|f| f.kind));
        let names: Vec<String> = names.map(|kind| format!("\"{}\"", kind.name())).collect();
        Err(Problem::new(
            format!("{}.file", self.key),
            format!(
                "the mesh {} is not taken as it is: {}",
                self.file,
                told.join("; ")
            ),
            format!(
                "{}; or, if that is meant, {}.accept = [{}]. `ripstop check CASE --pictures DIR` draws each finding; docs/meshes.md tells what it does to a run",
                remedies.join("; "),
                self.key,
                names.join(", ")
            ),
        ))
    }
}

/// True for nodes that are held or have a line.
fn anchored(structure: &Structure) -> Vec<bool> {
    let mut anchored = structure.held.clone();
    for node in structure.cables.iter().flat_map(|cable| cable.nodes) {
        anchored[node as usize] = true;
    }
    anchored
}

/// A mesh with its vertices joined, if the case gives a tolerance above 0, and its triangles turned alike, if it asks for that.
pub(super) fn prepared(
    table: &str,
    (tolerance_m, orients): (Option<f64>, bool),
    surface: Surface,
) -> Result<Prepared, Problem> {
    let mut welded = welded(table, tolerance_m, surface)?;
    let oriented = orients.then(|| oriented(table, &mut welded)).transpose()?;
    Ok(Prepared {
        welded,
        tolerance_m,
        oriented,
    })
}

fn oriented(table: &str, welded: &mut Welded) -> Result<usize, Problem> {
    orient(&mut welded.surface).map_err(|reason| {
        let (NoSides::NonManifold(edge) | NoSides::OneSided(edge)) = reason;
        let [a, b] = edge.map(|node| {
            let place = welded.surface.positions_m[node as usize];
            format!("{} at {place:.4} m", welded.numbers[node as usize] + 1)
        });
        let (why, help) = match reason {
            NoSides::NonManifold(_) => (
                "more than two triangles meet there, and nothing says which of them are neighbours",
                "remove the fabric that does not belong there, or remove the key and turn triangles in the program that drew the mesh",
            ),
            NoSides::OneSided(_) => (
                "the surface has one side only, as a Möbius strip, and no turning helps",
                "cut the surface where it should end, in the program that drew the mesh",
            ),
        };
        Problem::new(
            format!("{table}.orient_triangles"),
            format!("triangles cannot be turned alike between vertices {a} and {b}: {why}"),
            help,
        )
    })
}

/// A mesh with its vertices joined, if the case gives a tolerance above 0.
fn welded(table: &str, tolerance_m: Option<f64>, surface: Surface) -> Result<Welded, Problem> {
    let key = format!("{table}.weld_tolerance_m");
    let tolerance_m = usual::or(key.as_str(), tolerance_m, 0.0);
    let Some(tolerance_m) = Some(tolerance_m).filter(|tolerance| *tolerance != 0.0) else {
        return Ok(Welded::untouched(surface));
    };
    let tolerance_m = positive(&key, tolerance_m)?;
    let welded = weld(&surface, tolerance_m).map_err(|fault| {
        Problem::new(
            key.as_str(),
            format!("{key} = {tolerance_m} is too wide for this mesh: {fault}"),
            fault.largest_m().map_or_else(
                || "give less: what belongs together is usually a millionth of the mesh apart".to_owned(),
                |largest_m| format!("give at most {largest_m:.2e} m: seams are joined, and neither short edges nor fabric upon fabric"),
            ),
        )
    })?;
    if welded.surface.triangles.is_empty() {
        return Err(Problem::new(
            key.as_str(),
            format!("{key} = {tolerance_m} leaves no triangle"),
            "give less",
        ));
    }
    Ok(welded)
}
