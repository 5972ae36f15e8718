//! Checks of `[nodes.NAME]` and `[springs.NAME]`, and what they add to a structure.

use glam::DVec3;

use super::body::{Body, BodyKind};
use super::file::{self, File};
use super::mesh_examination::FromFiles;
use super::problem::Problem;
use super::usual;
use super::values::{check_name, positive, vector};
use crate::cloth::{Spring, Structure};

/// Adds what both kinds of tables say.
pub(super) fn check(file: &File, body: &mut Body, files: &FromFiles) -> Result<(), Problem> {
    let mut keys = file.nodes.keys().map(|name| format!("nodes.{name}"));
    let springs = || file.springs.keys().map(|name| format!("springs.{name}"));
    let Some(first) = keys.next().or_else(|| springs().next()) else {
        return Ok(());
    };
    if matches!(body.kind, BodyKind::Wing(_) | BodyKind::ImportedWing(_)) {
        return Err(Problem::new(
            first.as_str(),
            format!("[{first}] has no effect on a wing, which is drawn anew while it is trimmed"),
            "remove the table; structure.wing has keys for masses and pulls of its own",
        ));
    }
    if let BodyKind::Cable(cable) = &mut body.kind {
        cable.hangs_by_itself = false;
    }
    let is_canopy = body.canopy().is_some();
    let mut chosen = Vec::new();
    for (name, table) in &file.nodes {
        check_name("nodes", name, "a table of nodes")?;
        let adder = Adder {
            table_key: format!("nodes.{name}"),
            file,
            is_canopy,
        };
        let nodes = adder.chosen(table, &body.structure, files)?;
        adder.add(table, &mut body.structure, &nodes)?;
        chosen.push((adder, table, nodes));
    }
    // Which nodes are held is known now, whatever the order of the tables.
    for (adder, table, nodes) in chosen {
        adder.set_velocities(table, &mut body.structure, &nodes)?;
    }
    for (name, table) in &file.springs {
        check_name("springs", name, "a spring")?;
        let key = format!("springs.{name}");
        add_spring((file, &key), table, &mut body.structure, files)?;
    }
    Ok(())
}

struct Adder<'a> {
    table_key: String,
    file: &'a File,
    is_canopy: bool,
}

impl Adder<'_> {
    fn key(&self, name: &str) -> String {
        format!("{}.{name}", self.table_key)
    }

    fn add(
        &self,
        table: &file::Nodes,
        structure: &mut Structure,
        nodes: &[usize],
    ) -> Result<(), Problem> {
        let count = nodes.len() as f64;
        if let Some(held) = table.held {
            if self.is_canopy {
                return Err(Problem::new(
                    self.key("held"),
                    format!(
                        "{}: where a canopy is held is where its lines end",
                        self.key("held")
                    ),
                    "remove it",
                ));
            }
            if self.file.air.is_some() {
                return Err(Problem::new(
                    self.key("held"),
                    format!(
                        "{}: in air what holds a structure follows from its kind",
                        self.key("held")
                    ),
                    "remove it, or [air]",
                ));
            }
            for &node in nodes {
                structure.held[node] = held;
            }
        }
        if let Some(mass_kg) = table.mass_kg {
            let each_kg = positive(&self.key("mass_kg"), mass_kg)? / count;
            for &node in nodes {
                structure.masses_kg[node] += each_kg;
            }
        }
        if let Some(load_n) = table.load_n {
            let each_n = vector(&self.key("load_n"), load_n)? / count;
            structure
                .loads_n
                .resize(structure.node_count(), DVec3::ZERO);
            for &node in nodes {
                structure.loads_n[node] += each_n;
            }
        }
        let velocities = [table.velocity_m_s, table.angular_velocity_rad_s];
        let moves = velocities.iter().any(Option::is_some);
        let says = moves || table.held.is_some() || table.load_n.is_some();
        if says || table.mass_kg.is_some() {
            return Ok(());
        }
        Err(Problem::new(
            self.table_key.as_str(),
            format!("[{}] says nothing of its nodes", self.table_key),
            "give at least one of mass_kg, load_n, velocity_m_s, angular_velocity_rad_s and held",
        ))
    }

    fn set_velocities(
        &self,
        table: &file::Nodes,
        structure: &mut Structure,
        nodes: &[usize],
    ) -> Result<(), Problem> {
        let written = [
            ("velocity_m_s", table.velocity_m_s),
            ("angular_velocity_rad_s", table.angular_velocity_rad_s),
        ];
        let Some((name, _)) = written.iter().find(|(_, value)| value.is_some()) else {
            return Ok(());
        };
        let key = self.key(name);
        if self.file.time.is_none() || self.file.air.is_some() {
            return Err(Problem::new(
                key.as_str(),
                match self.file.air {
                    Some(_) => format!("{key}: in air everything starts from rest"),
                    None => format!("{key} has no effect without [time]"),
                },
                "remove it",
            ));
        }
        let [velocity_m_s, turning_rad_s] = [
            vector(
                &self.key("velocity_m_s"),
                table.velocity_m_s.unwrap_or_default(),
            )?,
            vector(
                &self.key("angular_velocity_rad_s"),
                table.angular_velocity_rad_s.unwrap_or_default(),
            )?,
        ];
        let places = nodes.iter().map(|&node| structure.positions_m[node]);
        let middle_m = places.clone().sum::<DVec3>() / nodes.len() as f64;
        let is_one_place = places.clone().zip(places.skip(1)).all(|(a, b)| a == b);
        if turning_rad_s != DVec3::ZERO && is_one_place {
            let key = self.key("angular_velocity_rad_s");
            return Err(Problem::new(
                key.as_str(),
                format!(
                    "{key} has no effect: nodes turn about their middle, and these are at one place"
                ),
                "choose several nodes, or give velocity_m_s",
            ));
        }
        structure
            .start_velocities_m_s
            .resize(structure.node_count(), DVec3::ZERO);
        for &node in nodes {
            if !structure.held[node] {
                let arm_m = structure.positions_m[node] - middle_m;
                structure.start_velocities_m_s[node] += velocity_m_s + turning_rad_s.cross(arm_m);
            }
        }
        Ok(())
    }

    fn chosen(
        &self,
        table: &file::Nodes,
        structure: &Structure,
        files: &FromFiles,
    ) -> Result<Vec<usize>, Problem> {
        match (table.at_m, table.box_m, &table.nodes) {
            (Some(place), None, None) => Ok(vec![nearest(&self.key("at_m"), place, structure)?]),
            (None, Some(corners), None) => {
                let key = self.key("box_m");
                let [a, b] = [vector(&key, corners[0])?, vector(&key, corners[1])?];
                let (low, high) = (a.min(b), a.max(b));
                let places = structure.positions_m.iter().enumerate();
                let nodes: Vec<usize> = places
                    .filter(|(_, place)| place.cmpge(low).all() && place.cmple(high).all())
                    .map(|(node, _)| node)
                    .collect();
                if nodes.is_empty() {
                    return Err(Problem::new(
                        key.as_str(),
                        format!("no node starts in the box {key}"),
                        extent(structure),
                    ));
                }
                Ok(nodes)
            }
            (None, None, Some(numbers)) => {
                let key = self.key("nodes");
                if numbers.is_empty() {
                    return Err(Problem::new(
                        key.as_str(),
                        format!("{key} is empty"),
                        "give numbers of nodes, from 1, or remove the table",
                    ));
                }
                let mut nodes = Vec::new();
                for &number in numbers {
                    let node = by_number(&key, number, structure, files)?;
                    // Vertices that are joined are one node.
                    if !nodes.contains(&node) {
                        nodes.push(node);
                    }
                }
                Ok(nodes)
            }
            _ => Err(Problem::new(
                self.table_key.as_str(),
                format!(
                    "[{}] needs exactly one of at_m, box_m and nodes",
                    self.table_key
                ),
                "say which nodes are meant",
            )),
        }
    }
}

fn add_spring(
    (file, table_key): (&File, &str),
    table: &file::NodeSpring,
    structure: &mut Structure,
    files: &FromFiles,
) -> Result<(), Problem> {
    let key = |name: &str| format!("{table_key}.{name}");
    let [a, b] = match (table.ends_m, table.nodes) {
        (Some([a, b]), None) => [
            nearest(&key("ends_m"), a, structure)?,
            nearest(&key("ends_m"), b, structure)?,
        ],
        (None, Some([a, b])) => [
            by_number(&key("nodes"), a, structure, files)?,
            by_number(&key("nodes"), b, structure, files)?,
        ],
        _ => {
            return Err(Problem::new(
                table_key,
                format!("[{table_key}] needs exactly one of ends_m and nodes"),
                "say which two nodes it joins",
            ));
        }
    };
    if file.air.is_some() && (structure.held[a] || structure.held[b]) {
        return Err(Problem::new(
            table_key,
            format!(
                "an end of [{table_key}] is held: in air its force would be missing in that of the supports"
            ),
            "let it join nodes that are free, or remove [air]",
        ));
    }
    if a == b {
        return Err(Problem::new(
            table_key,
            format!("both ends of [{table_key}] are node {}", a + 1),
            "give places of two nodes that are farther apart",
        ));
    }
    let stiffness_n_m = positive(&key("stiffness_n_m"), table.stiffness_n_m)?;
    let compressive_stiffness_n_m = match table.compressive_stiffness_n_m {
        Some(0.0) => 0.0,
        Some(stiffness) => positive(&key("compressive_stiffness_n_m"), stiffness)?,
        None => usual::noted(key("compressive_stiffness_n_m"), 0.0),
    };
    let distance_m = structure.positions_m[a].distance(structure.positions_m[b]);
    let rest_length_m = match table.rest_length_m {
        Some(length) => positive(&key("rest_length_m"), length)?,
        None => positive(
            &key("rest_length_m"),
            usual::noted(key("rest_length_m"), distance_m),
        )?,
    };
    structure.springs.push(Spring {
        nodes: [a as u32, b as u32],
        rest_length_m,
        stiffness_n_m,
        compressive_stiffness_n_m,
    });
    Ok(())
}

/// The node nearest to a place.
fn nearest(key: &str, place: [f64; 3], structure: &Structure) -> Result<usize, Problem> {
    let place_m = vector(key, place)?;
    let distances = structure.positions_m.iter().map(|x| x.distance(place_m));
    let found = distances.enumerate().min_by(|a, b| a.1.total_cmp(&b.1));
    match found {
        Some((node, distance_m)) if distance_m <= longest_element_m(structure) => Ok(node),
        Some((node, distance_m)) => {
            let x = structure.positions_m[node];
            Err(Problem::new(
                key,
                format!(
                    "the nearest node is {distance_m:.4} m away, farther than an element is long"
                ),
                format!(
                    "give a place of the structure; that node is at ({:.4}, {:.4}, {:.4}) m",
                    x.x, x.y, x.z
                ),
            ))
        }
        None => Err(Problem::new(
            key,
            "the structure has no nodes",
            "remove the table",
        )),
    }
}

/// Node of the first mesh with a number, from 1.
pub(super) fn by_number(
    key: &str,
    number: u32,
    structure: &Structure,
    files: &FromFiles,
) -> Result<usize, Problem> {
    let node = number.checked_sub(1).and_then(|vertex| files.node(vertex));
    let first = files.meshes.first().map_or(0, |mesh| mesh.start_m.len());
    match node.filter(|node| (*node as usize) < structure.node_count()) {
        Some(node) if files.meshes.len() > 1 && node as usize >= first => Err(Problem::new(
            key,
            format!("{key}: numbers are those of the first mesh, which has {first} nodes"),
            "choose nodes of further meshes by their place",
        )),
        Some(node) => Ok(node as usize),
        None => Err(Problem::new(
            key,
            format!(
                "there is no node {number} in a structure of {} nodes",
                structure.node_count()
            ),
            "nodes count from 1",
        )),
    }
}

/// Longest edge or cable segment at rest [m].
fn longest_element_m(structure: &Structure) -> f64 {
    let edges = structure.triangles.iter().flat_map(|t| t.rest_squares_m2);
    let cables = structure.cables.iter().map(|c| c.rest_length_m.powi(2));
    edges.chain(cables).fold(0.0, f64::max).sqrt()
}

/// Where the structure stands, in words.
fn extent(structure: &Structure) -> String {
    let ends = [DVec3::INFINITY, DVec3::NEG_INFINITY];
    let [low, high] = structure
        .positions_m
        .iter()
        .fold(ends, |[low, high], x| [low.min(*x), high.max(*x)]);
    format!(
        "the structure starts between ({:.4}, {:.4}, {:.4}) and ({:.4}, {:.4}, {:.4}) m",
        low.x, low.y, low.z, high.x, high.y, high.z
    )
}
