use glam::DVec3;

use super::*;

/// The stiffest place moves between refreshes, to where the last eigenvector has no part; a smoother whose interval it leaves would take the
/// cycle its sign. One triangle of equal springs among three nodes that pull as one, nnᵀ over all three, has three times its diagonal.
#[test]
fn the_largest_eigenvalue_is_found_where_it_has_moved_to() {
    let count = 3000;
    let groups: Vec<[u32; 3]> = (0..count as u32 - 2).map(|i| [i, i + 1, i + 2]).collect();
    let pattern = Pattern::from_groups(count, groups.iter().map(|g| &g[..]));
    let graph = Graph::new(pattern, vec![false; count], |_, _| 1.0);
    let mut multigrid = Multigrid::new(graph);
    for stiff in [700, 2100, 1400] {
        multigrid.refresh(|fine| {
            fine.fill_rows(
                || (),
                |(), row, columns, blocks| {
                    for (block, &column) in blocks.iter_mut().zip(columns) {
                        let inside = |node: usize| (stiff..stiff + 3).contains(&node);
                        let own = column as usize == row;
                        let together = inside(row) && inside(column as usize);
                        let value = if own { 1.0 } else { 0.0 } + if together { 1e6 } else { 0.0 };
                        *block = [value, 0.0, 0.0, 0.0, value, 0.0, 0.0, 0.0, value];
                    }
                },
            );
        });
        let found = multigrid.levels[0].largest_eigenvalue;
        assert!(found * EIGENVALUE_MARGIN > 3.0, "at {stiff}: {found}");
    }
}

/// A square sheet of `n`² nodes under isotropic tension 1 whose plane also stretches: stiffness `stretch` along edges, 1 across them.
/// Nodes of the first column are held.
fn sheet(n: usize, stretch: f32) -> (Multigrid, BlockMatrix) {
    let node = |x: usize, y: usize| (x + n * y) as u32;
    let mut edges = Vec::new();
    for y in 0..n {
        for x in 0..n {
            if x + 1 < n {
                edges.push([node(x, y), node(x + 1, y)]);
            }
            if y + 1 < n {
                edges.push([node(x, y), node(x, y + 1)]);
            }
        }
    }
    let pattern = Pattern::from_groups(n * n, edges.iter().map(|e| &e[..]));
    let fixed: Vec<bool> = (0..n * n).map(|i| i % n == 0).collect();
    let mut matrix = BlockMatrix::new(pattern.clone());
    matrix.fill_rows(
        || (),
        |(), row, columns, blocks| {
            for (place, &column) in columns.iter().enumerate() {
                let column = column as usize;
                if column == row {
                    continue;
                }
                let along = if column.abs_diff(row) == 1 { 0 } else { 1 };
                let mut block = [0.0; 9];
                for k in 0..3 {
                    block[4 * k] = if k == along { stretch } else { 1.0 };
                }
                let own = columns.binary_search(&(row as u32)).unwrap();
                for k in 0..9 {
                    blocks[own][k] += block[k];
                    if !fixed[row] && !fixed[column] {
                        blocks[place][k] -= block[k];
                    }
                }
            }
        },
    );
    let mut multigrid = Multigrid::new(Graph::new(pattern, fixed, |_, _| 1.0));
    multigrid.refresh(|fine| fine.clone_from(&matrix));
    (multigrid, matrix)
}

/// One cycle, with its argument and result in double precision.
fn cycle(multigrid: &mut Multigrid, right: &[DVec3]) -> Vec<DVec3> {
    let right: Vec<Vec3> = right.iter().map(|v| v.as_vec3()).collect();
    let mut result = vec![Vec3::ZERO; right.len()];
    multigrid.apply(&right, &mut result);
    result.iter().map(|v| v.as_dvec3()).collect()
}

fn dot(a: &[DVec3], b: &[DVec3]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a.dot(*b)).sum()
}

fn noise(count: usize, seed: u32) -> Vec<DVec3> {
    let mut state = seed;
    let mut next = || {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        f64::from(state >> 8) / f64::from(1 << 24) - 0.5
    };
    (0..count)
        .map(|_| DVec3::new(next(), next(), next()))
        .collect()
}

/// A broken cycle may never get there.
const ITERATION_LIMIT: usize = 300;

/// Conjugate gradients preconditioned with one cycle: iterations until the error norm √(rᵀ M r) has fallen by 1e-4.
fn iterations(multigrid: &mut Multigrid, matrix: &BlockMatrix) -> usize {
    let count = matrix.pattern.row_count();
    let multiply = |v: &[DVec3]| -> Vec<DVec3> {
        let single: Vec<[f32; 3]> = v.iter().map(|x| x.as_vec3().to_array()).collect();
        (0..count)
            .map(|row| glam::Vec3::from_array(matrix.multiply_row(row, &single)).as_dvec3())
            .collect()
    };
    let mut residual = noise(count, 7);
    let mut z = cycle(multigrid, &residual);
    let mut direction = z.clone();
    let mut square = dot(&residual, &z);
    let goal = 1e-8 * square;
    for iteration in 0..ITERATION_LIMIT {
        if square < goal {
            return iteration;
        }
        let product = multiply(&direction);
        let alpha = square / dot(&direction, &product);
        for (r, p) in residual.iter_mut().zip(&product) {
            *r -= *p * alpha;
        }
        z = cycle(multigrid, &residual);
        let new = dot(&residual, &z);
        for (d, z) in direction.iter_mut().zip(&z) {
            *d = *z + *d * (new / square);
        }
        square = new;
    }
    ITERATION_LIMIT
}

#[test]
fn one_cycle_is_a_symmetric_positive_operator() {
    let (mut multigrid, matrix) = sheet(40, 30.0);
    let count = matrix.pattern.row_count();
    let (a, b) = (noise(count, 1), noise(count, 2));
    let mut apply = |v: &[DVec3]| cycle(&mut multigrid, v);
    let (ma, mb) = (apply(&a), apply(&b));
    let (ab, ba) = (dot(&a, &mb), dot(&b, &ma));
    let scale = (dot(&a, &ma) * dot(&b, &mb)).sqrt();
    assert!((ab - ba).abs() < 1e-5 * scale, "{ab} {ba} {scale}");
    assert!(dot(&a, &ma) > 0.0);
    let (zero, twice) = (
        apply(&vec![DVec3::ZERO; count]),
        apply(&a.iter().map(|v| *v * 2e-30).collect::<Vec<_>>()),
    );
    assert!(zero.iter().all(|v| *v == DVec3::ZERO));
    // Linear, however small the vector.
    for (t, m) in twice.iter().zip(&ma) {
        assert!((*t * 0.5e30 - *m).length() < 1e-5 * m.length() + 1e-9);
    }
    assert!(apply(&vec![DVec3::NAN; count]).iter().all(|v| v.is_nan()));
}

/// What multigrid is for: the number of iterations hardly grows with the number of nodes.
#[test]
fn iterations_do_not_grow_with_the_mesh() {
    for stretch in [1.0, 100.0] {
        let counts = [32, 64, 128].map(|n| {
            let (mut multigrid, matrix) = sheet(n, stretch);
            let count = iterations(&mut multigrid, &matrix);
            println!("{n}: {count} {:?}", multigrid.sizes());
            count
        });
        assert!(counts[2] <= counts[0] + 8, "stretch {stretch}: {counts:?}");
        assert!(counts[2] < 60, "stretch {stretch}: {counts:?}");
    }
}

/// Held nodes get the diagonal part only, and the coarse levels know nothing of them.
#[test]
fn levels_shrink_and_hold() {
    let (multigrid, _) = sheet(64, 1.0);
    let sizes = multigrid.sizes();
    assert!(sizes.len() >= 3, "{sizes:?}");
    for pair in sizes.windows(2) {
        assert!(pair[1][0] * 2 < pair[0][0], "{sizes:?}");
    }
    let coarse_weight = |node: usize| {
        let [interpolation, _] = multigrid.levels[0].interpolation.as_ref().unwrap();
        interpolation.row(node).iter().map(|(_, w)| *w).sum::<f32>()
    };
    assert_eq!(coarse_weight(64 * 30), 0.0);
    assert!((coarse_weight(64 * 30 + 20) - 1.0).abs() < 1e-5);
}
