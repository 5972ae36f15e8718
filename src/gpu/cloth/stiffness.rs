//! Stage `stiffness` on the device (`shaders/stiffness.wgsl`): the finest matrix of multigrid, assembled from the point sought.
//!
//! Every kind of element knows the blocks that it touches and, for each, the elements that add to it in ascending order. Held nodes
//! have no terms, so their rows and columns stay zero.

use rayon::prelude::*;

use crate::cloth::Structure;
use crate::gpu::commands::Pass;
use crate::gpu::device::Device;
use crate::gpu::error::DeviceError;
use crate::gpu::multigrid::sliced::Sliced;
use crate::gpu::pipeline::Bound;
use crate::gpu::shaders;
use crate::solve::multigrid::blocks::Pattern;

use super::elements::Kind;

/// Elements of a kind that terms can tell apart.
const ELEMENT_LIMIT: usize = 1 << 26;

/// Blocks touched by a kind, and what adds to each.
#[derive(Debug, Default, PartialEq, Eq)]
struct Terms {
    places: Vec<u32>,
    first: Vec<u32>,
    terms: Vec<u32>,
}

impl Terms {
    /// `nodes` gives the corners of an element.
    fn new(
        count: usize,
        corners: usize,
        nodes: impl Fn(usize, usize) -> u32 + Sync,
        held: &[bool],
        (pattern, sliced): (&Pattern, &Sliced),
    ) -> Self {
        let mut pairs: Vec<u64> = (0..count)
            .into_par_iter()
            .flat_map_iter(|element| {
                let nodes = &nodes;
                (0..corners * corners).filter_map(move |both| {
                    let [row, column] = [both / corners, both % corners];
                    let [a, b] = [nodes(element, row), nodes(element, column)];
                    if held[a as usize] || held[b as usize] {
                        return None;
                    }
                    let k = pattern.within_row(a as usize, b)?;
                    let place = sliced.place(a as usize, k) as u64;
                    Some((place << 32) | (64 * element + 8 * row + column) as u64)
                })
            })
            .collect();
        pairs.par_sort_unstable();
        let mut terms = Self::default();
        for pair in pairs {
            let place = (pair >> 32) as u32;
            if terms.places.last() != Some(&place) {
                terms.places.push(place);
                terms.first.push(terms.terms.len() as u32);
            }
            terms.terms.push(pair as u32);
        }
        terms.first.push(terms.terms.len() as u32);
        terms
    }
}

/// Dispatches that assemble the matrix.
#[derive(Debug)]
pub(super) struct Stiffness {
    dispatches: Vec<(Bound, [u32; 2])>,
    /// Of the nodes' inertia; only where time goes on.
    inertia: Option<(Bound, [u32; 2])>,
}

impl Stiffness {
    /// Dispatches for the kinds of a structure, into `matrix`.
    pub fn new(
        device: &Device,
        structure: &Structure,
        kinds: &[Kind],
        constants: &[(&str, f64)],
        buffers: &[(&str, &wgpu::Buffer)],
        (matrix, pattern, sliced): (&wgpu::Buffer, &Pattern, &Sliced),
    ) -> Result<Self, DeviceError> {
        let bound = |entry: &str, touched: usize, more: &[(&str, &wgpu::Buffer)]| {
            let constants = [constants, &[("TOUCHED", touched as f64)]].concat();
            let [pipeline] = device.pipelines(&shaders::STIFFNESS, [entry], &constants)?;
            device.bind(&pipeline, &[buffers, more].concat())
        };
        let into_matrix = |entry: &str, terms: &Terms| {
            if terms.places.is_empty() {
                return Ok::<_, DeviceError>(None);
            }
            let places = device.storage_of("touched blocks", &terms.places)?;
            let first = device.storage_of("first terms", &terms.first)?;
            let list = device.storage_of("terms of blocks", &terms.terms)?;
            let more = [
                ("matrix", matrix),
                ("block_places", &places),
                ("block_first", &first),
                ("block_terms", &list),
            ];
            let touched = terms.places.len();
            let groups = device.workgroups(touched as u64);
            Ok(Some((bound(entry, touched, &more)?, groups)))
        };
        let mut dispatches = Vec::new();
        for kind in kinds {
            if kind.count >= ELEMENT_LIMIT {
                return Err(DeviceError::Command(format!(
                    "{} {} are more than the {ELEMENT_LIMIT} that multigrid takes on a device",
                    kind.count, kind.plural
                )));
            }
            if kind.name == "face" {
                // Pressure has no part in it.
                continue;
            }
            if kind.name == "triangle" {
                let groups = device.workgroups(kind.count as u64);
                dispatches.push((bound("triangle_stiffness", 0, &[])?, groups));
            }
            let terms = Terms::new(
                kind.count,
                kind.corner_count(),
                |element, corner| kind.node(element, corner),
                &structure.held,
                (pattern, sliced),
            );
            dispatches.extend(into_matrix(&format!("{}_matrix", kind.name), &terms)?);
        }
        let nodes = Terms::new(
            structure.node_count(),
            1,
            |node, _| node as u32,
            &structure.held,
            (pattern, sliced),
        );
        Ok(Self {
            dispatches,
            inertia: into_matrix("node_matrix", &nodes)?,
        })
    }

    /// Records all dispatches; the matrix must have been cleared.
    pub fn dispatch(&self, pass: &mut Pass<'_>, moving: bool) {
        for (bound, groups) in self
            .dispatches
            .iter()
            .chain(self.inertia.iter().filter(|_| moving))
        {
            bound.dispatch(pass, *groups);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn blocks_know_their_elements() {
        // A chain 0–1–2–3, whose first node is held.
        let pairs = [[0, 1], [1, 2], [2, 3]];
        let pattern = Pattern::from_groups(4, pairs.iter().map(|p| &p[..]));
        let sliced = Sliced::new(&pattern);
        let held = [true, false, false, false];
        let nodes = |element: usize, corner: usize| pairs[element][corner];
        let found = Terms::new(3, 2, nodes, &held, (&pattern, &sliced));
        let at = |row: usize, column: u32| {
            let k = pattern.within_row(row, column).unwrap();
            let place = sliced.place(row, k) as u32;
            let thread = found.places.iter().position(|p| *p == place);
            thread.map(|t| &found.terms[found.first[t] as usize..found.first[t + 1] as usize])
        };
        assert_eq!(at(0, 0), None);
        assert_eq!(at(1, 0), None);
        // Element 0 with corner 1 twice, element 1 with corner 0 twice.
        assert_eq!(at(1, 1), Some(&[9, 64][..]));
        assert_eq!(at(1, 2), Some(&[65][..]));
        assert_eq!(at(2, 1), Some(&[72][..]));
        assert_eq!(at(3, 3), Some(&[137][..]));
    }
}
