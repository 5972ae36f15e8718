//! Checks of `[supports.NAME]`: held nodes that are moved.

use glam::DVec3;

use super::body::Body;
use super::file::{self, File};
use super::mesh_examination::FromFiles;
use super::motion;
use super::nodes;
use super::problem::Problem;
use super::time::Time;
use super::usual;
use super::values::{check_name, positive, vector};
use crate::cloth::Structure;
use crate::rigid::{Motion, PrescribedMotion};

/// Held nodes that are moved together.
#[derive(Debug, Clone)]
pub struct Support {
    /// Its name in the case.
    pub name: String,
    /// The nodes.
    pub nodes: Vec<u32>,
    /// How they move.
    pub motion: PrescribedMotion,
}

impl Support {
    /// Where its nodes are at a time \[s\]: `(node, place [m])`; `structure` is that of the start.
    pub fn places_m<'a>(
        &'a self,
        structure: &'a Structure,
        time_s: f64,
    ) -> impl Iterator<Item = (u32, DVec3)> + 'a {
        let placement = self.motion.at(time_s);
        self.nodes.iter().map(move |&node| {
            let start_m = structure.positions_m[node as usize];
            (node, placement.position_m(start_m))
        })
    }
}

/// Farthest that a support may be from its start at t = 0, over the size of the structure: round-off.
const JUMP: f64 = 1e-9;

/// Checks all supports that are moved.
pub(super) fn check(
    file: &File,
    body: Option<&Body>,
    time: Option<&Time>,
    files: &FromFiles,
) -> Result<Vec<Support>, Problem> {
    let Some(first) = file.supports.keys().next() else {
        return Ok(Vec::new());
    };
    let Some(body) = body else {
        return Err(Problem::new(
            format!("supports.{first}"),
            "[supports] has no effect: it needs [structure]",
            "remove [supports], or add [structure]",
        ));
    };
    if file.air.is_some() {
        return Err(Problem::new(
            format!("supports.{first}"),
            "supports are moved only without air",
            "remove [supports] or [air]",
        ));
    }
    let seeks_trim = file.equilibrium.as_ref().is_some_and(|e| e.trim.is_some());
    if seeks_trim {
        return Err(Problem::new(
            format!("supports.{first}"),
            "supports are not moved in a trim, which turns the wing about its hang points",
            "remove [supports] or [equilibrium.trim]; structure.wing.hang_point_m moves the hang points, rows.NAME.trim_m the risers",
        ));
    }
    let mut mover: Vec<Option<&str>> = vec![None; body.structure.node_count()];
    let mut supports = Vec::new();
    for (name, table) in &file.supports {
        let support = check_support(name, table, &body.structure, time, files)?;
        for &node in &support.nodes {
            if let Some(other) = mover[node as usize].replace(name) {
                let key = format!("supports.{name}");
                return Err(Problem::new(
                    key.as_str(),
                    format!(
                        "node {} is moved by [supports.{other}] and by [{key}]",
                        node + 1
                    ),
                    "let one table move each node",
                ));
            }
        }
        supports.push(support);
    }
    Ok(supports)
}

fn check_support(
    name: &str,
    table: &file::Support,
    structure: &Structure,
    time: Option<&Time>,
    files: &FromFiles,
) -> Result<Support, Problem> {
    check_name("supports", name, "a support")?;
    let table_key = format!("supports.{name}");
    let key = |name: &str| format!("{table_key}.{name}");
    let nodes = match (&table.box_m, &table.nodes) {
        (Some(corners), None) => {
            let [a, b] = [
                vector(&key("box_m"), corners[0])?,
                vector(&key("box_m"), corners[1])?,
            ];
            nodes_in_box(&key("box_m"), [a.min(b), a.max(b)], structure)?
        }
        (None, Some(numbers)) => nodes_by_number(&key("nodes"), numbers, structure, files)?,
        _ => {
            return Err(Problem::new(
                table_key.as_str(),
                format!("[{table_key}] needs exactly one of box_m and nodes"),
                "give the box in which the held nodes start, or their numbers",
            ));
        }
    };
    let middle_m = nodes
        .iter()
        .map(|&node| structure.positions_m[node as usize])
        .sum::<DVec3>()
        / nodes.len() as f64;
    let motion = check_motion(&table_key, table, middle_m, time)?;
    let support = Support {
        name: name.to_owned(),
        nodes,
        motion,
    };
    if time.is_some() {
        let jump_m = support
            .places_m(structure, 0.0)
            .map(|(node, place)| place.distance(structure.positions_m[node as usize]))
            .fold(0.0, f64::max);
        if jump_m > JUMP * size_m(structure) {
            return Err(Problem::new(
                key("motion"),
                format!("the support would jump by {jump_m:.3e} m at t = 0"),
                "let the motion begin where the structure starts",
            ));
        }
    }
    Ok(support)
}

/// Diagonal of the box around a structure [m].
fn size_m(structure: &Structure) -> f64 {
    let [low, high] = structure.positions_m.iter().fold(
        [DVec3::INFINITY, DVec3::NEG_INFINITY],
        |[low, high], place| [low.min(*place), high.max(*place)],
    );
    low.distance(high)
}

fn nodes_in_box(
    key: &str,
    [low, high]: [DVec3; 2],
    structure: &Structure,
) -> Result<Vec<u32>, Problem> {
    let inside = |place: DVec3| place.cmpge(low).all() && place.cmple(high).all();
    let nodes: Vec<u32> = (0..structure.node_count())
        .filter(|&node| structure.held[node] && inside(structure.positions_m[node]))
        .map(|node| node as u32)
        .collect();
    if !nodes.is_empty() {
        return Ok(nodes);
    }
    let held: Vec<DVec3> = (0..structure.node_count())
        .filter(|&node| structure.held[node])
        .map(|node| structure.positions_m[node])
        .collect();
    let help = match held.first() {
        Some(place) => format!(
            "held nodes are {} in all, the first at ({:.4}, {:.4}, {:.4}) m: enlarge or move the box",
            held.len(),
            place.x,
            place.y,
            place.z
        ),
        None => "the structure has no held node: remove [supports]".to_owned(),
    };
    Err(Problem::new(
        key,
        format!("no held node starts in the box {key}"),
        help,
    ))
}

fn nodes_by_number(
    key: &str,
    numbers: &[u32],
    structure: &Structure,
    files: &FromFiles,
) -> Result<Vec<u32>, Problem> {
    if numbers.is_empty() {
        return Err(Problem::new(
            key,
            format!("{key} is empty: nothing would be moved"),
            "give numbers of held nodes, from 1, or remove the table",
        ));
    }
    let mut chosen = Vec::new();
    for &number in numbers {
        let node = nodes::by_number(key, number, structure, files)?;
        if !structure.held[node] {
            return Err(Problem::new(
                key,
                format!("{key}: node {number} is not held"),
                "only supports can be moved: hold the node, or leave it out",
            ));
        }
        // Vertices that are joined are one node.
        if !chosen.contains(&(node as u32)) {
            chosen.push(node as u32);
        }
    }
    Ok(chosen)
}

fn check_motion(
    table_key: &str,
    table: &file::Support,
    middle_m: DVec3,
    time: Option<&Time>,
) -> Result<PrescribedMotion, Problem> {
    let key = |name: &str| format!("{table_key}.{name}");
    match (table.displacement_m, &table.motion, time) {
        (Some(displacement), None, _) => {
            let ramp_s = match (table.ramp_time_s, time) {
                (Some(_), None) => {
                    return Err(Problem::new(
                        key("ramp_time_s"),
                        format!("{} has no effect without [time]", key("ramp_time_s")),
                        "remove it (an equilibrium alone knows no time), or add [time]",
                    ));
                }
                (Some(ramp_s), Some(_)) => positive(&key("ramp_time_s"), ramp_s)?,
                (None, Some(time)) => usual::noted(key("ramp_time_s"), time.end_s),
                (None, None) => 0.0,
            };
            Ok(PrescribedMotion {
                motion: Motion::Ramp {
                    displacement_m: vector(&key("displacement_m"), displacement)?,
                    ramp_s,
                },
                ..PrescribedMotion::held()
            })
        }
        (None, Some(_), None) => Err(Problem::new(
            key("motion"),
            format!("[{}] needs [time]", key("motion")),
            "add [time], or give the displacement in the equilibrium as displacement_m",
        )),
        (None, Some(_), Some(_)) if table.ramp_time_s.is_some() => Err(Problem::new(
            key("ramp_time_s"),
            format!(
                "{} has no effect beside [{}]",
                key("ramp_time_s"),
                key("motion")
            ),
            "remove it: the motion has times of its own",
        )),
        (None, Some(written), Some(time)) => {
            if matches!(written, file::Motion::FreeFall(_)) {
                return Err(Problem::new(
                    key("motion.free_fall"),
                    "a support does not fall: nothing would hold the structure",
                    "use constant_velocity, constant_rotation, oscillation or table",
                ));
            }
            motion::check(&key("motion"), written, middle_m, time)
        }
        _ => Err(Problem::new(
            table_key,
            format!("[{table_key}] needs exactly one of displacement_m and motion"),
            "say how far the support is moved (displacement_m), or how (motion)",
        )),
    }
}
