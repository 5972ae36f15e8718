//! A structure as the device reads it: words of every kind of element, and the slots that every node gathers.
//!
//! Words are stored word by word, `[word][element]`, so that neighbouring threads read neighbouring addresses. An element writes
//! one slot per corner; nodes gather theirs through a list in ascending order of slots, always the same.

use glam::DVec3;

use crate::cloth::{CableSegment, Structure};
use crate::gpu::shaders::WORKGROUP;
use crate::lines::CableLaw;

/// Points farther than this from the origin are refused as not finite [m]: whole numbers of 2⁻¹⁶ m end at 32 km, and a step
/// must not leave them.
const FARTHEST_M: f64 = 16384.0;

/// Units of the whole numbers per metre.
pub(super) const UNITS_PER_M: f64 = 65536.0;

/// Where what lies at every node begins, and which it is: 3 · number + corner of things with three nodes each.
pub(super) fn corners_at_nodes(
    nodes: usize,
    things: impl Iterator<Item = [u32; 3]>,
) -> (Vec<u32>, Vec<u32>) {
    let mut at_nodes = vec![Vec::new(); nodes];
    for (number, of_thing) in things.enumerate() {
        for (corner, node) in of_thing.into_iter().enumerate() {
            at_nodes[node as usize].push((3 * number + corner) as u32);
        }
    }
    let mut first = vec![0];
    for of_node in &at_nodes {
        first.push(first.last().copied().unwrap_or(0) + of_node.len() as u32);
    }
    (first, at_nodes.concat())
}

/// A coordinate [m] as a whole number of 2⁻¹⁶ m and a remainder.
pub(in crate::gpu) fn split(coordinate_m: f64) -> (i32, f32) {
    if coordinate_m.abs() < FARTHEST_M {
        let whole = (coordinate_m * UNITS_PER_M).round();
        (whole as i32, (coordinate_m - whole / UNITS_PER_M) as f32)
    } else {
        (0, f32::NAN)
    }
}

/// The coordinate [m] that [`split`] took apart.
pub(super) fn joined(whole: i32, remainder: f32) -> f64 {
    f64::from(whole) / UNITS_PER_M + f64::from(remainder)
}

/// A vector in single precision.
pub(super) fn narrow(v: &DVec3) -> [f32; 3] {
    v.to_array().map(|x| x as f32)
}

/// Words of a triangle that cuts the lattice: six symmetric blocks, and the force on each corner at the velocities of the prediction.
pub(super) const CUT_WORDS: usize = 6 * 6 + 3 * 3;

/// Elements of one kind.
#[derive(Debug)]
pub(super) struct Kind {
    /// "triangle"
    pub name: &'static str,
    /// "triangles"
    pub plural: &'static str,
    /// Elements.
    pub count: usize,
    /// Words, `[word][element]`.
    pub words: Vec<u32>,
    /// Nodes, `[corner][element]`.
    corners: Vec<u32>,
}

impl Kind {
    fn new<T, const C: usize, const W: usize>(
        name: &'static str,
        plural: &'static str,
        elements: &[T],
        nodes: impl Fn(&T) -> [u32; C],
        rest: impl Fn(&T) -> [u32; W],
    ) -> Self {
        let count = elements.len();
        let mut corners = vec![0; C * count];
        let mut words = vec![0; (C + W) * count];
        for (e, element) in elements.iter().enumerate() {
            for (corner, node) in nodes(element).into_iter().enumerate() {
                corners[corner * count + e] = node;
                words[corner * count + e] = node;
            }
            for (k, word) in rest(element).into_iter().enumerate() {
                words[(C + k) * count + e] = word;
            }
        }
        Self {
            name,
            plural,
            count,
            words,
            corners,
        }
    }

    /// Nodes of an element.
    pub const fn corner_count(&self) -> usize {
        self.corners.len() / self.count
    }

    /// A node of an element.
    pub fn node(&self, element: usize, corner: usize) -> u32 {
        self.corners[corner * self.count + element]
    }

    /// Workgroups of one thread per element.
    pub fn groups(&self) -> usize {
        self.count.div_ceil(WORKGROUP as usize)
    }
}

/// What triangles are besides fabric.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Triangles {
    /// Pressure follows them.
    pub faces: bool,
    /// They cut the lattice of the air.
    pub cut: bool,
}

/// Slots that the elements of a structure with so many markers have at most: a triangle is fabric, a face, and cut.
pub(super) fn most_slots(structure: &Structure, marker_count: usize) -> usize {
    // A damped cable is a dashpot, too.
    3 * (3 * structure.triangles.len() + marker_count)
        + 2 * (structure.springs.len() + 2 * structure.cables.len())
        + 3 * structure.bendings.len()
        + 6 * structure.curvatures.len()
        + structure.guides.len()
}

/// The kinds that a structure has, and which slots every node gathers.
#[derive(Debug)]
pub(super) struct Elements {
    /// Kinds with at least one element, in the order of their slots.
    pub kinds: Vec<Kind>,
    /// Slots in all.
    pub slots: usize,
    /// Entries of energies: one per workgroup of every kind, then of the nodes.
    pub energies: usize,
    /// Where every node's slots begin in `node_slots`, and where the last ones end.
    pub node_first: Vec<u32>,
    /// Slots of the nodes.
    pub node_slots: Vec<u32>,
    /// Pieces of the cables' laws: strain and force [N] where each begins, slope [N], energy per rest length up to there [N].
    pub cable_laws: Vec<[f32; 4]>,
    /// Counts and first entries, as constants of the shaders.
    pub constants: Vec<(String, f64)>,
}

fn bits(value: f64) -> u32 {
    (value as f32).to_bits()
}

/// A squared rest length [m²] in units of 2⁻³² m²: whole part modulo 2³², the rest; and the whole in m².
fn rest_square(square_m2: f64) -> [u32; 3] {
    let units = square_m2 * (UNITS_PER_M * UNITS_PER_M);
    let whole = units.floor();
    let modulus = UNITS_PER_M * UNITS_PER_M;
    [
        whole.rem_euclid(modulus) as u32,
        bits(units - whole),
        bits(square_m2),
    ]
}

/// Cable segments with axial damping, in their order.
pub(super) fn damped_cables(structure: &Structure) -> impl Iterator<Item = &CableSegment> {
    structure.cables.iter().filter(|c| c.damping_n_s > 0.0)
}

/// Straight pieces of all laws, and where those of every law begin.
fn law_pieces(laws: &[CableLaw]) -> (Vec<[f32; 4]>, Vec<u32>) {
    let mut pieces = Vec::new();
    let mut first = vec![0];
    for law in laws {
        match law {
            CableLaw::Linear { axial_stiffness_n } => {
                pieces.push([0.0, 0.0, *axial_stiffness_n as f32, 0.0]);
            }
            CableLaw::Table(table) => {
                let mut start = [0.0; 2];
                for &[strain, force] in table.points() {
                    let slope = (force - start[1]) / (strain - start[0]);
                    let energy = law.at(start[0]).energy_n;
                    pieces.push([start[0], start[1], slope, energy].map(|x| x as f32));
                    start = [strain, force];
                }
            }
        }
        first.push(pieces.len() as u32);
    }
    (pieces, first)
}

impl Elements {
    /// Lays out a structure; `markers` are (triangle, weights).
    pub fn new(
        structure: &Structure,
        markers: &[(u32, [f64; 3])],
        Triangles { faces, cut }: Triangles,
    ) -> Self {
        let mut kinds = Vec::new();
        if structure.membrane.is_some() {
            kinds.push(Kind::new(
                "triangle",
                "triangles",
                &structure.triangles,
                |t| t.nodes,
                |t| {
                    let mut words = [0; 19];
                    for i in 0..3 {
                        words[3 * i..3 * i + 3].copy_from_slice(&rest_square(t.rest_squares_m2[i]));
                        for j in 0..3 {
                            words[9 + 3 * i + j] = bits(t.strain_from_squares[i][j]);
                        }
                    }
                    words[18] = bits(t.rest_area_m2);
                    words
                },
            ));
        }
        kinds.push(Kind::new(
            "spring",
            "springs",
            &structure.springs,
            |s| s.nodes,
            |s| {
                let [whole, part, square] = rest_square(s.rest_length_m * s.rest_length_m);
                [
                    whole,
                    part,
                    square,
                    bits(s.rest_length_m),
                    bits(s.stiffness_n_m),
                    bits(s.compressive_stiffness_n_m),
                ]
            },
        ));
        kinds.push(Kind::new(
            "bending",
            "bendings",
            &structure.bendings,
            |b| b.nodes,
            |b| [bits(b.stiffness_n_m)],
        ));
        kinds.push(Kind::new(
            "curvature",
            "curvatures",
            &structure.curvatures,
            |c| c.nodes,
            |c| {
                let [c0, c1, c2, c3, c4, c5] = c.coefficients.map(bits);
                [c0, c1, c2, c3, c4, c5, bits(c.stiffness_n_m)]
            },
        ));
        let (cable_laws, law_first) = law_pieces(&structure.cable_laws);
        kinds.push(Kind::new(
            "cable",
            "cables",
            &structure.cables,
            |c| c.nodes,
            |c| {
                let [whole, part, square] = rest_square(c.rest_length_m * c.rest_length_m);
                [
                    whole,
                    part,
                    square,
                    bits(c.rest_length_m),
                    law_first[c.law as usize],
                    law_first[c.law as usize + 1] - law_first[c.law as usize],
                ]
            },
        ));
        let damped: Vec<[u32; 2]> = damped_cables(structure).map(|c| c.nodes).collect();
        kinds.push(Kind::new(
            "dashpot",
            "dashpots",
            &damped,
            |nodes| *nodes,
            |_| [],
        ));
        kinds.push(Kind::new(
            "guide",
            "guides",
            &structure.guides,
            |g| [g.node],
            |g| {
                let anchor = g.anchor_m.to_array().map(split);
                let stiffness = g.stiffness_n_m.to_array().map(bits);
                let mut words = [0; 9];
                for axis in 0..3 {
                    words[axis] = anchor[axis].0.cast_unsigned();
                    words[3 + axis] = anchor[axis].1.to_bits();
                    words[6 + axis] = stiffness[axis];
                }
                words
            },
        ));
        for (name, plural, _) in [
            ("face", "faces", faces),
            ("cut_triangle", "cut_triangles", cut),
        ]
        .into_iter()
        .filter(|(_, _, there)| *there)
        {
            let triangles = &structure.triangles;
            kinds.push(Kind::new(name, plural, triangles, |t| t.nodes, |_| []));
        }
        let [name, plural] = match structure.permeability {
            None => ["marker", "markers"],
            Some(_) => ["permeable_marker", "permeable_markers"],
        };
        kinds.push(Kind::new(
            name,
            plural,
            markers,
            |(triangle, _)| structure.triangles[*triangle as usize].nodes,
            |(_, weights)| weights.map(bits),
        ));
        kinds.retain(|kind| kind.count > 0);
        Self {
            cable_laws,
            ..Self::of_kinds(kinds, structure.node_count())
        }
    }

    fn of_kinds(kinds: Vec<Kind>, nodes: usize) -> Self {
        let mut constants = vec![("NODES".to_owned(), nodes as f64)];
        let (mut slots, mut energies) = (0, 0);
        let mut node_first = vec![0_u32; nodes + 1];
        for kind in &kinds {
            let name = kind.name.to_uppercase();
            constants.push((kind.plural.to_uppercase(), kind.count as f64));
            constants.push((format!("{name}_SLOTS"), slots as f64));
            constants.push((format!("{name}_ENERGIES"), energies as f64));
            slots += kind.corners.len();
            energies += kind.groups();
            for &node in &kind.corners {
                node_first[node as usize + 1] += 1;
            }
        }
        constants.push(("NODE_ENERGIES".to_owned(), energies as f64));
        energies += nodes.div_ceil(WORKGROUP as usize);
        constants.push(("ENERGIES".to_owned(), energies as f64));
        for node in 0..nodes {
            node_first[node + 1] += node_first[node];
        }
        let mut next = node_first.clone();
        let mut node_slots = vec![0; slots];
        let nodes_of_slots = kinds.iter().flat_map(|kind| &kind.corners);
        for (slot, &node) in nodes_of_slots.enumerate() {
            let place = &mut next[node as usize];
            node_slots[*place as usize] = slot as u32;
            *place += 1;
        }
        Self {
            kinds,
            slots,
            energies,
            node_first,
            node_slots,
            cable_laws: Vec::new(),
            constants,
        }
    }
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;
    use crate::cloth::{Bending, Guide, Spring, Triangle};

    #[test]
    fn coordinates_keep_half_a_picometre() {
        for x in [0.0, 1e-13, -0.3, 12.345_678_901_234, -9_000.000_007_629] {
            let (whole, remainder) = split(x);
            assert!((joined(whole, remainder) - x).abs() < 5e-13, "{x}");
        }
        for x in [f64::NAN, f64::INFINITY, -2e4] {
            assert!(split(x).1.is_nan());
        }
    }

    #[test]
    fn nodes_gather_every_slot_once_in_order() {
        let corners = vec![2, 0, 1, 0, 1, 2];
        let kind = Kind {
            name: "spring",
            plural: "springs",
            count: 3,
            words: Vec::new(),
            corners,
        };
        let elements = Elements::of_kinds(vec![kind], 4);
        assert_eq!(elements.node_first, [0, 2, 4, 6, 6]);
        assert_eq!(elements.node_slots, [1, 3, 2, 4, 0, 5]);
    }

    /// The bound counts every kind of element.
    #[test]
    fn slots_are_bounded() {
        let mut structure = Structure {
            bendings: vec![Bending {
                nodes: [0, 1, 2],
                coefficients: [1.0, -2.0, 1.0],
                stiffness_n_m: 1.0,
            }],
            curvatures: vec![Bending {
                nodes: [0, 1, 2, 3, 4, 5],
                coefficients: [0.0; 6],
                stiffness_n_m: 1.0,
            }],
            springs: vec![Spring {
                nodes: [0, 1],
                rest_length_m: 1.0,
                stiffness_n_m: 1.0,
                compressive_stiffness_n_m: 1.0,
            }],
            guides: vec![Guide {
                node: 0,
                anchor_m: DVec3::ZERO,
                stiffness_n_m: DVec3::ONE,
            }],
            triangles: vec![Triangle {
                nodes: [0, 1, 2],
                fabric: 0,
                rest_area_m2: 0.5,
                rest_squares_m2: [2.0, 1.0, 1.0],
                strain_from_squares: [[0.0; 3]; 3],
            }],
            ..Structure::default()
        };
        for k in 0..6 {
            structure.add_node(DVec3::X * f64::from(k));
        }
        let triangles = Triangles {
            faces: true,
            cut: true,
        };
        let markers = [(0, [1.0, 0.0, 0.0])];
        let slots = Elements::new(&structure, &markers, triangles).slots;
        // The triangle has no fabric here.
        assert_eq!(slots + 3, most_slots(&structure, markers.len()));
    }
}
