//! What a multigrid cycle knows before any stiffness: patterns of all levels and interpolation between them, made once for a mesh.

use faer::linalg::solvers::DenseSolveCore;
use faer::{Mat, Side};

use super::blocks::{BlockMatrix, Pattern};
use super::coarsening::{Graph, Interpolation, coarse_pattern};

/// Added to the diagonal of a block, as a share of its largest entry, so that directions without stiffness stay regular.
pub const REGULARISATION: f32 = 1e-6;

/// At most this many nodes are solved directly.
pub const DIRECT_NODES: usize = 150;

/// Coarsening ends where a level keeps more than this share of its nodes.
const SLOWEST_COARSENING: f64 = 0.8;

const LEVEL_LIMIT: usize = 20;

/// One level without its matrix.
#[derive(Debug, Clone)]
pub struct Shape {
    /// Which blocks its matrix has.
    pub pattern: Pattern,
    /// From the next coarser level, and the same transposed; absent on the coarsest.
    pub interpolation: Option<[Interpolation; 2]>,
}

/// All levels for a mesh, finest first; the finest matrix has the pattern of the graph.
#[must_use]
pub fn hierarchy(mut graph: Graph) -> Vec<Shape> {
    let shape = |pattern| Shape {
        pattern,
        interpolation: None,
    };
    let mut levels = vec![shape(graph.pattern.clone())];
    while graph.pattern.row_count() > DIRECT_NODES && levels.len() < LEVEL_LIMIT {
        let (interpolation, count) = graph.interpolation();
        if count == 0 || count as f64 > SLOWEST_COARSENING * graph.pattern.row_count() as f64 {
            break;
        }
        let from_coarse = interpolation.transposed(count);
        let pattern = coarse_pattern(&graph.pattern, &interpolation, &from_coarse);
        graph = graph.coarse(&interpolation, &from_coarse, &pattern);
        if let Some(level) = levels.last_mut() {
            level.interpolation = Some([interpolation, from_coarse]);
        }
        levels.push(shape(pattern));
    }
    levels
}

/// Inverse of the coarsest matrix, row by row; empty where it is too large, has nothing to invert, or is indefinite by rounding: the
/// smoother then takes its place.
#[must_use]
pub fn coarsest_inverse(matrix: &BlockMatrix) -> Vec<f32> {
    let nodes = matrix.pattern.row_count();
    if nodes > DIRECT_NODES {
        return Vec::new();
    }
    let mut dense = Mat::<f64>::zeros(3 * nodes, 3 * nodes);
    let mut largest: f64 = 0.0;
    for row in 0..nodes {
        for (&column, block) in matrix.pattern.columns(row).iter().zip(matrix.row(row)) {
            for a in 0..3 {
                for b in 0..3 {
                    dense[(3 * row + a, 3 * column as usize + b)] = f64::from(block[3 * a + b]);
                }
            }
        }
        for a in 0..3 {
            largest = largest.max(dense[(3 * row + a, 3 * row + a)]);
        }
    }
    if !(largest > 0.0 && largest.is_finite()) {
        return Vec::new();
    }
    for i in 0..3 * nodes {
        dense[(i, i)] += f64::from(REGULARISATION) * largest;
    }
    let Ok(factors) = dense.llt(Side::Lower) else {
        return Vec::new();
    };
    let inverse = factors.inverse();
    (0..3 * nodes)
        .flat_map(|i| (0..3 * nodes).map(move |j| (i, j)))
        .map(|place| inverse[place] as f32)
        .collect()
}
