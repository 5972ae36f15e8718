//! Checks of `[structure.mesh]`: fabric from a mesh file, with a nominal area a parachute canopy.

use std::cmp::Reverse;
use std::collections::BinaryHeap;
use std::f64::consts::PI;
use std::path::Path;

use glam::{DQuat, DVec3};

use super::body::{Body, BodyKind, Canopy};
use super::fabric::{USUAL_RESIDUAL, check_fabric, check_fabric_at};
use super::file::{self, File};
use super::mesh_examination::{self, ExaminedMesh, FromFiles, Joined};
use super::problem::Problem;
use super::values::{absent, check_name, positive, rotation, vector};
use super::{mesh_lines, usual};
use crate::cloth::Structure;
use crate::cloth::elements::EDGES;
use crate::fabric::Fabric;
use crate::geometry::fabric_surface;
use crate::geometry::mesh::doctor::Welded;
use crate::geometry::mesh::obj::{self, Faces};
use crate::geometry::mesh::openings::openings;
use crate::geometry::mesh::surface;
use crate::rigid::Surface;

const KEY: &str = "structure.mesh";

/// Most by which an edge may be longer at the start than at rest: beyond what fabric bears, so one of both files is not what it should be.
const LARGEST_STRETCH: f64 = 0.1;

/// Farthest that joined vertices may be apart at the start, in tolerances: twice at rest, and stretched.
const LARGEST_GAP: f64 = 2.5;

/// Least that the longest edge may be at the start, over its length at rest.
const LEAST_RATIO: f64 = 0.5;

/// Builds the structure, and refuses a mesh in which something is found that the case does not accept.
pub(super) fn check(
    file: &File,
    written: &file::MeshFile,
    files: &mut FromFiles,
) -> Result<Body, Problem> {
    refuse_further(written)?;
    let mut all = examine_all(file, written, files.folder)?.into_iter();
    let Some(mut first) = all.next() else {
        return Err(absent(KEY, "a structure of meshes has one at least"));
    };
    // Without lines all of it is loose, but the lines are what is missing.
    let fabric_nodes = first.examined.examination.node_count;
    if written.nominal_area_m2.is_some() && first.structure.node_count() == fabric_nodes {
        return Err(absent(
            "structure.mesh.lines",
            "a canopy (structure.mesh.nominal_area_m2) hangs on suspension lines",
        ));
    }
    first.examined.refuse()?;
    let kind = match written.nominal_area_m2 {
        None => BodyKind::Mesh,
        Some(area) => {
            let nominal_area_m2 = positive(&format!("{KEY}.nominal_area_m2"), area)?;
            BodyKind::Canopy(canopy(nominal_area_m2, fabric_nodes, &first.structure)?)
        }
    };
    files.joined = first.joined.take();
    files.meshes.push(first.examined.clone());
    for mut next in all {
        next.examined.refuse()?;
        if let Some(fabric) = &next.own_fabric {
            first.structure.further_fabrics.push(fabric.into());
            let number = first.structure.further_fabrics.len() as u32;
            for triangle in &mut next.structure.triangles {
                triangle.fabric = number;
            }
        }
        first.structure.add_beside(next.structure);
        first.rest_m.extend(next.rest_m);
        files.meshes.push(next.examined);
    }
    Ok(Body::new(first.structure, &first.rest_m, kind))
}

/// Refuses what further meshes cannot have.
fn refuse_further(written: &file::MeshFile) -> Result<(), Problem> {
    for (name, table) in &written.further {
        let key = format!("{KEY}.further.{name}");
        check_name(&key, name, "a mesh")?;
        if written.nominal_area_m2.is_some() {
            return Err(Problem::new(
                key.as_str(),
                format!("[{key}]: a canopy (structure.mesh.nominal_area_m2) is one mesh"),
                "put all its fabric into one file, or leave out nominal_area_m2",
            ));
        }
        let fabric = table.fabric.as_ref();
        if fabric.is_some_and(|fabric| fabric.permeability.is_some()) {
            let key = format!("{key}.fabric.permeability");
            return Err(Problem::new(
                key.as_str(),
                "what passes the fabric is the same for the whole structure",
                format!("remove {key}; fabric.permeability holds for all meshes"),
            ));
        }
    }
    Ok(())
}

/// All meshes, the further ones behind the first; nothing that is found is refused.
pub(super) fn examine_all(
    file: &File,
    written: &file::MeshFile,
    folder: &Path,
) -> Result<Vec<Read>, Problem> {
    let mut read = vec![examine(file, (KEY, written, None), folder)?];
    for (name, table) in &written.further {
        let key = format!("{KEY}.further.{name}");
        let fabric = table.fabric.as_ref();
        read.push(examine(file, (&key, &table.as_mesh(), fabric), folder)?);
    }
    Ok(read)
}

/// A mesh as it was read, joined and examined.
pub(super) struct Read {
    structure: Structure,
    /// Where its nodes are at rest [m].
    rest_m: Vec<DVec3>,
    /// What it is made of, where that is not the fabric of the case.
    own_fabric: Option<Fabric>,
    joined: Option<Joined>,
    pub(super) examined: ExaminedMesh,
}

/// Reads, joins and examines the mesh, with its lines and held nodes; nothing that is found is refused.
fn examine(
    file: &File,
    (key, written, fabric): (&str, &file::MeshFile, Option<&file::Fabric>),
    folder: &Path,
) -> Result<Read, Problem> {
    let own_fabric = fabric
        .map(|own| check_fabric_at(&format!("{key}.fabric"), own, USUAL_RESIDUAL))
        .transpose()?;
    let fabric = match &own_fabric {
        Some(own) => *own,
        None => check_fabric(file)?,
    };
    let scale = positive(&format!("{key}.scale"), written.scale)?;
    let path = folder.join(&written.file);
    let rotation = rotation(&format!("{key}.rotation"), written.rotation.as_ref())?;
    let (as_written, faces) = read(key, &path, scale)?;
    let wished = (written.weld_tolerance_m, written.orient_triangles);
    let prepared = mesh_examination::prepared(key, wished, as_written.clone())?;
    let welded = &prepared.welded;
    let mut structure =
        fabric_surface::build(&turned(&welded.surface, rotation), DVec3::X, &fabric)
            .map_err(|index| degenerate((key, &path), welded, index))?;
    let rest_m = structure.positions_m.clone();
    let mut start_m = welded.surface.positions_m.clone();
    if let Some(start) = &written.start_file {
        if !is_numbered(&path) {
            return Err(Problem::new(
                format!("{key}.start_file"),
                format!(
                    "{key}.start_file needs nodes with numbers, which STL and PLY files do not keep"
                ),
                format!("give {key}.file as OBJ, too"),
            ));
        }
        let places_m = start_places((key, &folder.join(start)), scale, (&as_written, &faces))?;
        start_m = joined_start((key, start), written, welded, &places_m)?;
        structure.positions_m = start_m.iter().map(|place| rotation * *place).collect();
    }
    let position_m = match written.position_m {
        Some(position) => vector(&format!("{key}.position_m"), position)?,
        None => usual::noted(format!("{key}.position_m"), [0.0; 3]).into(),
    };
    for place in &mut structure.positions_m {
        *place += position_m;
    }
    hold((key, &written.held_nodes), welded, &mut structure)?;
    mesh_lines::add(written, folder, (rotation, position_m), &mut structure)?;
    let examined = ExaminedMesh::of_fabric(
        (key, &path),
        (&prepared, is_numbered(&path)),
        start_m,
        &structure,
        (file, written),
        rotation,
    );
    let welded = prepared.welded;
    if written.nominal_area_m2.is_some() {
        structure.openings = openings(&welded.surface, &examined.examination.borders);
    }
    Ok(Read {
        joined: (welded.joined + welded.collapsed > 0).then_some(Joined {
            node_count: welded.surface.positions_m.len() as u32,
            nodes: welded.nodes,
        }),
        structure,
        rest_m,
        own_fabric,
        examined,
    })
}

fn turned(surface: &Surface, rotation: DQuat) -> Surface {
    let places = surface.positions_m.iter();
    Surface {
        positions_m: places.map(|place| rotation * *place).collect(),
        triangles: surface.triangles.clone(),
    }
}

/// Nodes and triangles of a file, with its faces where nodes keep their numbers.
fn read(key: &str, path: &Path, scale: f64) -> Result<(Surface, Faces), Problem> {
    let unreadable = |why: String| {
        Problem::new(
            format!("{key}.file"),
            format!("cannot read the mesh {}: {why}", path.display()),
            "give an OBJ file with triangles or polygons (or STL, PLY), relative to the case file",
        )
    };
    // Nodes of OBJ files keep their numbers; those of others are joined where they lie together.
    if is_numbered(path) {
        let mesh = obj::read(path, scale).map_err(unreadable)?;
        let surface = Surface {
            positions_m: mesh.positions_m,
            triangles: mesh.triangles,
        };
        Ok((surface, mesh.faces))
    } else {
        let surface = surface::read(path, scale).map_err(unreadable)?;
        Ok((surface, Faces::default()))
    }
}

fn is_numbered(path: &Path) -> bool {
    !["stl", "ply"].iter().any(|other| {
        path.extension()
            .is_some_and(|e| e.eq_ignore_ascii_case(other))
    })
}

/// A place without hundreds of zeros.
fn told(place: DVec3) -> String {
    let is_usual = |c: f64| c == 0.0 || (1e-6..1e9).contains(&c.abs());
    if place.to_array().into_iter().all(is_usual) {
        place.to_string()
    } else {
        place.to_array().map(|c| format!("{c:.4e}")).join(", ")
    }
}

fn degenerate((key, path): (&str, &Path), welded: &Welded, index: usize) -> Problem {
    let nodes = welded.surface.triangles[index];
    let corners = welded.surface.corners(nodes);
    let nodes = nodes.map(|node| welded.numbers[node as usize]);
    let [a, b, c] = corners.map(told);
    let index = welded.triangle_numbers[index] as usize;
    Problem::new(
        format!("{key}.file"),
        format!(
            "triangle {} of {} is degenerate: nodes {}, {}, {} at ({a}), ({b}), ({c}) enclose no area",
            index + 1,
            path.display(),
            nodes[0] + 1,
            nodes[1] + 1,
            nodes[2] + 1,
        ),
        "remove or repair the triangle (numbers count from 1, as in the OBJ file)",
    )
}

/// Where the nodes start, for vertices of which some are joined.
fn joined_start(
    (key, file): (&str, &str),
    written: &file::MeshFile,
    welded: &Welded,
    start_m: &[DVec3],
) -> Result<Vec<DVec3>, Problem> {
    let (places_m, farthest) = welded.carried_over(start_m);
    let weld_m = usual::or(
        format!("{key}.weld_tolerance_m"),
        written.weld_tolerance_m,
        0.0,
    );
    let allowed_m = LARGEST_GAP * weld_m;
    for hanging in &welded.inserted {
        let [a, b] = hanging.edge.map(|vertex| start_m[vertex as usize]);
        let apart_m = a
            .lerp(b, hanging.share)
            .distance(start_m[hanging.vertex as usize]);
        if apart_m > allowed_m + LARGEST_STRETCH * a.distance(b) {
            let [a, b] = hanging.edge.map(|vertex| vertex + 1);
            return Err(Problem::new(
                format!("{key}.start_file"),
                format!(
                    "vertex {} is sewn to the edge between vertices {a} and {b} in {}, but {apart_m:.3e} m from it in {file}",
                    hanging.vertex + 1,
                    written.file
                ),
                format!("let seams lie together in both files, or lower {key}.weld_tolerance_m"),
            ));
        }
    }
    match farthest {
        Some(([a, b], apart_m)) if apart_m > allowed_m => Err(Problem::new(
            format!("{key}.start_file"),
            format!(
                "vertices {} and {} are joined in {}, but {apart_m:.3e} m apart in {file}",
                a + 1,
                b + 1,
                written.file
            ),
            format!("let seams lie together in both files, or lower {key}.weld_tolerance_m"),
        )),
        _ => Ok(places_m),
    }
}

/// Where a second file has the same nodes [m].
fn start_places(
    (key, path): (&str, &Path),
    scale: f64,
    (rest, faces): (&Surface, &Faces),
) -> Result<Vec<DVec3>, Problem> {
    let refused = |why: String, help: &str| {
        Problem::new(
            format!("{key}.start_file"),
            format!("the start shape {}: {why}", path.display()),
            help,
        )
    };
    let same = format!(
        "give an OBJ file with the same faces as {key}.file, in the same order, and moved vertices"
    );
    if !is_numbered(path) {
        return Err(refused(
            "its nodes have no numbers that would say which is which".to_owned(),
            &same,
        ));
    }
    // Its polygons are covered by the triangles of the shape at rest, however they are folded.
    let start = obj::read_folded(path, scale)
        .map_err(|why| refused(format!("cannot be read: {why}"), &same))?;
    if start.positions_m.len() != rest.positions_m.len() || start.faces != *faces {
        return Err(refused(
            format!(
                "it has {} nodes and {} faces, the shape at rest {} and {}; or faces differ",
                start.positions_m.len(),
                start.faces.count(),
                rest.positions_m.len(),
                faces.count()
            ),
            &same,
        ));
    }
    let mut longest_ratio: f64 = 0.0;
    for nodes in &rest.triangles {
        for (a, b) in [(0, 1), (1, 2), (2, 0)] {
            let [a, b] = [nodes[a], nodes[b]];
            let length = |of: &[DVec3]| of[a as usize].distance(of[b as usize]);
            let stretch = length(&start.positions_m) / length(&rest.positions_m) - 1.0;
            longest_ratio = longest_ratio.max(1.0 + stretch);
            if stretch > LARGEST_STRETCH {
                return Err(refused(
                    format!(
                        "the edge between nodes {} and {} is {:.0} % longer than at rest",
                        a + 1,
                        b + 1,
                        100.0 * stretch
                    ),
                    "fold without stretching (10 % at most), and write both files in one unit (numbers count from 1)",
                ));
            }
        }
    }
    if longest_ratio < LEAST_RATIO {
        return Err(refused(
            format!("its edges are {longest_ratio:.2e} times as long as at rest, at most"),
            "write both files in one unit: a fold leaves most edges as long as they are",
        ));
    }
    Ok(start.positions_m)
}

/// Holds nodes by the numbers of their vertices in the file, from 1.
fn hold(
    (key, vertices): (&str, &[u32]),
    welded: &Welded,
    structure: &mut Structure,
) -> Result<(), Problem> {
    for &vertex in vertices {
        let node = (vertex as usize)
            .checked_sub(1)
            .and_then(|index| welded.nodes.get(index));
        let refused = |why: String| {
            let help = "nodes count from 1, as in the OBJ file";
            Problem::new(format!("{key}.held_nodes"), why, help)
        };
        match node {
            Some(Some(node)) => structure.held[*node as usize] = true,
            Some(None) => {
                return Err(refused(format!(
                    "all triangles at node {vertex} collapsed when vertices were joined"
                )));
            }
            None => {
                let node_count = welded.nodes.len();
                return Err(refused(format!(
                    "there is no node {vertex} in a mesh of {node_count} nodes"
                )));
            }
        }
    }
    Ok(())
}

/// Least distance by which lines lead upstream, over the nominal diameter: more than round-off.
const LEAST_LEAD: f64 = 1e-3;

/// The mesh as a canopy, whose lines have to lead upstream.
fn canopy(
    nominal_area_m2: f64,
    canopy_node_count: usize,
    structure: &Structure,
) -> Result<Canopy, Problem> {
    let (fabric, ends) = structure.positions_m.split_at(canopy_node_count);
    let middle_x = fabric.iter().map(|place| place.x).sum::<f64>() / fabric.len() as f64;
    let nominal_diameter_m = (4.0 * nominal_area_m2 / PI).sqrt();
    let least_m = LEAST_LEAD * nominal_diameter_m;
    if let Some(end) = ends.iter().find(|end| end.x > middle_x - least_m) {
        return Err(Problem::new(
            "structure.mesh.lines",
            format!(
                "lines end at x = {:.4} m, not upstream of the canopy (its middle is at {middle_x:.4} m)",
                end.x
            ),
            "the air comes along +x: turn mesh and lines, with structure.mesh.rotation, so that the lines lead from the canopy towards −x",
        ));
    }
    Ok(Canopy {
        nominal_area_m2,
        nominal_diameter_m,
        canopy_node_count,
        apex: farthest_from_lines(structure, canopy_node_count),
        lower_end: (ends.len() == 1).then_some(canopy_node_count),
        loading: None,
    })
}

/// The node of the fabric that is farthest from all attachments of lines, along its edges at rest.
fn farthest_from_lines(structure: &Structure, fabric: usize) -> usize {
    let mut neighbours = vec![Vec::new(); fabric];
    for triangle in &structure.triangles {
        for ([from, to], square) in EDGES.into_iter().zip(triangle.rest_squares_m2) {
            let [from, to] = [from, to].map(|k| triangle.nodes[k] as usize);
            neighbours[from].push((to, square.sqrt()));
            neighbours[to].push((from, square.sqrt()));
        }
    }
    // Bits of numbers that are not negative are in the order of the numbers.
    let mut distances_m = vec![f64::INFINITY; fabric];
    let mut queue = BinaryHeap::new();
    for node in structure.cables.iter().flat_map(|cable| cable.nodes) {
        if let Some(distance) = distances_m.get_mut(node as usize) {
            *distance = 0.0;
            queue.push((Reverse(0), node as usize));
        }
    }
    let mut last = 0;
    while let Some((Reverse(bits), node)) = queue.pop() {
        let distance = f64::from_bits(bits);
        if distance > distances_m[node] {
            continue;
        }
        last = node;
        for &(to, length) in &neighbours[node] {
            let longer = distance + length;
            if longer < distances_m[to] {
                distances_m[to] = longer;
                queue.push((Reverse(longer.to_bits()), to));
            }
        }
    }
    last
}
