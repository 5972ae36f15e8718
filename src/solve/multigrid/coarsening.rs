//! Coarser and coarser graphs: aggregates of nodes, and smooth interpolation between them (smoothed aggregation, Vaněk, Mandel &
//! Brezina 1996).
//!
//! *Departure*: interpolation comes from a scalar Laplacian of the mesh, once and for all, and serves all three components alike. It
//! reproduces translations only, but keeps its pattern while the stiffness changes from one refresh to the next.

use rayon::prelude::*;

use super::blocks::Pattern;

/// A coupling below this share of the strongest one of its row is weak: it joins no nodes and carries no interpolation.
const STRONG: f32 = 0.1;

/// Damping of the Jacobi step that smooths the interpolation: 4/3 over the largest eigenvalue, which is at most 2.
const SMOOTHING: f32 = 2.0 / 3.0;

const NONE: u32 = u32::MAX;

/// A weighted graph: what the Laplacian Σ w_ij (x_i − x_j)² sees of a mesh.
#[derive(Debug)]
pub struct Graph {
    /// Neighbours; the diagonal is stored, with weight zero.
    pub pattern: Pattern,
    /// Weight of every entry of the pattern, symmetric, never negative.
    pub weights: Vec<f32>,
    /// Nodes that do not move and have no part in interpolation.
    pub fixed: Vec<bool>,
}

/// Weights of coarse nodes in fine ones.
#[derive(Debug, Clone, Default)]
pub struct Interpolation {
    starts: Vec<u32>,
    entries: Vec<(u32, f32)>,
}

impl Interpolation {
    /// (coarse node, weight) of a fine node.
    #[inline]
    #[must_use]
    pub fn row(&self, node: usize) -> &[(u32, f32)] {
        &self.entries[self.starts[node] as usize..self.starts[node + 1] as usize]
    }

    /// Number of rows.
    #[must_use]
    pub const fn row_count(&self) -> usize {
        self.starts.len().saturating_sub(1)
    }

    fn from_rows(rows: &[Vec<(u32, f32)>]) -> Self {
        let mut starts = vec![0];
        let mut entries = Vec::with_capacity(rows.iter().map(Vec::len).sum());
        for row in rows {
            entries.extend_from_slice(row);
            starts.push(entries.len() as u32);
        }
        Self { starts, entries }
    }

    /// (fine node, weight) of every coarse node.
    #[must_use]
    pub fn transposed(&self, coarse_nodes: usize) -> Self {
        let mut starts = vec![0u32; coarse_nodes + 1];
        for (coarse, _) in &self.entries {
            starts[*coarse as usize + 1] += 1;
        }
        for i in 0..coarse_nodes {
            starts[i + 1] += starts[i];
        }
        let mut next = starts.clone();
        let mut entries = vec![(0, 0.0); self.entries.len()];
        for fine in 0..self.row_count() {
            for &(coarse, weight) in self.row(fine) {
                let place = &mut next[coarse as usize];
                entries[*place as usize] = (fine as u32, weight);
                *place += 1;
            }
        }
        Self { starts, entries }
    }
}

impl Graph {
    /// A mesh with edges of the given lengths: weights are inverse squares.
    #[must_use]
    pub fn new(
        pattern: Pattern,
        fixed: Vec<bool>,
        distance: impl Fn(usize, usize) -> f64 + Sync,
    ) -> Self {
        let weights = (0..pattern.row_count())
            .into_par_iter()
            .flat_map_iter(|row| {
                let distance = &distance;
                pattern.columns(row).iter().map(move |&column| {
                    let length = distance(row, column as usize);
                    if row == column as usize || length <= 0.0 {
                        0.0
                    } else {
                        (1.0 / (length * length)) as f32
                    }
                })
            })
            .collect();
        Self {
            pattern,
            weights,
            fixed,
        }
    }

    /// Strong neighbours of a node with their weights.
    fn strong(&self, node: usize) -> impl Iterator<Item = (usize, f32)> {
        let range = self.pattern.row(node);
        let strongest = self.weights[range.clone()]
            .iter()
            .copied()
            .fold(0.0, f32::max);
        self.pattern
            .columns(node)
            .iter()
            .zip(&self.weights[range])
            .map(|(&column, &weight)| (column as usize, weight))
            .filter(move |(_, weight)| *weight > 0.0 && *weight >= STRONG * strongest)
    }

    /// Aggregate of every node, and how many there are. Fixed nodes and those without a neighbour belong to none.
    fn aggregates(&self) -> (Vec<u32>, usize) {
        let count = self.pattern.row_count();
        let mut aggregate = vec![NONE; count];
        let mut number = 0;
        let joins = |node: usize| !self.fixed[node];
        for node in (0..count).filter(|&n| joins(n)) {
            let free = |(other, _): (usize, f32)| aggregate[other] == NONE;
            if aggregate[node] == NONE
                && self.strong(node).any(|(other, _)| joins(other))
                && self
                    .strong(node)
                    .filter(|(other, _)| joins(*other))
                    .all(free)
            {
                aggregate[node] = number;
                for (other, _) in self.strong(node).filter(|(other, _)| joins(*other)) {
                    aggregate[other] = number;
                }
                number += 1;
            }
        }
        let roots = aggregate.clone();
        for node in (0..count).filter(|&n| joins(n) && roots[n] == NONE) {
            let nearest = self
                .strong(node)
                .filter(|(other, _)| roots[*other] != NONE)
                .max_by(|a, b| a.1.total_cmp(&b.1));
            if let Some((other, _)) = nearest {
                aggregate[node] = roots[other];
            }
        }
        for node in (0..count).filter(|&n| joins(n)) {
            if aggregate[node] == NONE && self.strong(node).next().is_some() {
                aggregate[node] = number;
                for (other, _) in self.strong(node) {
                    if joins(other) && aggregate[other] == NONE {
                        aggregate[other] = number;
                    }
                }
                number += 1;
            }
        }
        (aggregate, number as usize)
    }

    /// Smooth interpolation from aggregates, and their number.
    #[must_use]
    pub fn interpolation(&self) -> (Interpolation, usize) {
        let (aggregate, count) = self.aggregates();
        let rows: Vec<Vec<(u32, f32)>> = (0..self.pattern.row_count())
            .into_par_iter()
            .map(|node| {
                if aggregate[node] == NONE {
                    return Vec::new();
                }
                let diagonal: f32 = self.strong(node).map(|(_, weight)| weight).sum();
                let mut row = vec![(aggregate[node], 1.0 - SMOOTHING)];
                for (other, weight) in self.strong(node) {
                    if aggregate[other] == NONE {
                        continue;
                    }
                    let share = SMOOTHING * weight / diagonal;
                    match row
                        .iter_mut()
                        .find(|(coarse, _)| *coarse == aggregate[other])
                    {
                        Some((_, sum)) => *sum += share,
                        None => row.push((aggregate[other], share)),
                    }
                }
                row.sort_unstable_by_key(|(coarse, _)| *coarse);
                row
            })
            .collect();
        (Interpolation::from_rows(&rows), count)
    }

    /// The graph of the aggregates: off-diagonal part of PᵀLP, without what is positive there.
    #[must_use]
    pub fn coarse(
        &self,
        interpolation: &Interpolation,
        from_coarse: &Interpolation,
        pattern: &Pattern,
    ) -> Self {
        let rows = pattern.row_count();
        let weights: Vec<f32> = (0..rows)
            .into_par_iter()
            .flat_map_iter(|coarse| {
                let columns = pattern.columns(coarse);
                // L = Σ w (e_i − e_j)(e_i − e_j)ᵀ, row by row.
                let mut sums = vec![0.0f32; columns.len()];
                let mut add = |other: u32, value: f32| {
                    if let Ok(place) = columns.binary_search(&other) {
                        sums[place] += value;
                    }
                };
                for &(fine, share) in from_coarse.row(coarse) {
                    let fine = fine as usize;
                    let mut total = 0.0;
                    for (&column, &weight) in self
                        .pattern
                        .columns(fine)
                        .iter()
                        .zip(&self.weights[self.pattern.row(fine)])
                    {
                        total += weight;
                        for &(other, part) in interpolation.row(column as usize) {
                            add(other, share * weight * part);
                        }
                    }
                    for &(other, part) in interpolation.row(fine) {
                        add(other, -share * total * part);
                    }
                }
                columns
                    .iter()
                    .zip(sums)
                    .map(|(&column, sum)| {
                        if column as usize == coarse {
                            0.0
                        } else {
                            sum.max(0.0)
                        }
                    })
                    .collect::<Vec<f32>>()
            })
            .collect();
        Self {
            pattern: pattern.clone(),
            weights,
            fixed: vec![false; rows],
        }
    }
}

/// Pattern of PᵀAP.
#[must_use]
pub fn coarse_pattern(
    fine: &Pattern,
    interpolation: &Interpolation,
    from_coarse: &Interpolation,
) -> Pattern {
    let rows: Vec<Vec<u32>> = (0..from_coarse.row_count())
        .into_par_iter()
        .map(|coarse| {
            let mut columns = vec![coarse as u32];
            for &(node, _) in from_coarse.row(coarse) {
                for &column in fine.columns(node as usize) {
                    columns.extend(interpolation.row(column as usize).iter().map(|(c, _)| *c));
                }
            }
            columns.sort_unstable();
            columns.dedup();
            columns
        })
        .collect();
    Pattern::from_rows(&rows)
}
