//! Tests of the lists of touched cells.

use super::*;

fn positions() -> Vec<[f64; 3]> {
    (0..200)
        .map(|k| {
            let t = f64::from(k) * 0.37;
            [
                10.0 + 4.0 * t.sin(),
                9.0 + 3.0 * (1.7 * t).cos(),
                8.0 + 0.01 * t,
            ]
        })
        .collect()
}

/// ⟨S u, F⟩ = ⟨u, S* F⟩ and total spread force = total force.
#[test]
fn interpolation_and_spreading_are_adjoint() {
    let positions = positions();
    let mut touched = TouchedCells::default();
    touched.rebuild(&positions, [24, 20, 18]).unwrap();
    let field: Vec<[f64; 1]> = touched
        .cells
        .iter()
        .map(|c| [f64::from(c[0] * 7 + c[1] * 3 + c[2]).sin()])
        .collect();
    let force: Vec<[f64; 1]> = (0..positions.len()).map(|m| [(m as f64).cos()]).collect();
    let left: f64 = (0..positions.len())
        .map(|m| touched.interpolate(m, &field)[0] * force[m][0])
        .sum();
    let mut spread = Vec::new();
    touched.spread(&force, &mut spread);
    let right: f64 = spread.iter().zip(&field).map(|(s, f)| s[0] * f[0]).sum();
    assert!((left - right).abs() < 1e-12 * force.len() as f64);
    let total: f64 = spread.iter().map(|s| s[0]).sum();
    assert!((total - force.iter().map(|f| f[0]).sum::<f64>()).abs() < 1e-12);
}

/// However many threads share the cells, each gets the same sum of its markers, in their order.
#[test]
fn spreading_has_the_same_bits_on_any_number_of_threads() {
    let positions: Vec<[f64; 3]> = (0..5).flat_map(|_| positions()).collect();
    let force: Vec<[f64; 3]> = (0..positions.len())
        .map(|m| [(m as f64).cos(), (m as f64).sin(), 1.0 / (1.0 + m as f64)])
        .collect();
    let mut touched = TouchedCells::default();
    touched.rebuild(&positions, [24, 20, 18]).unwrap();
    let mut plain = vec![[0.0; 3]; touched.cells.len()];
    for (position, force) in positions.iter().zip(&force) {
        let axes = position.map(kernel::weights);
        for (sum, cell) in plain.iter_mut().zip(&touched.cells) {
            let at = |a: usize| {
                usize::try_from(i64::from(cell[a]) - axes[a].0)
                    .ok()
                    .and_then(|i| axes[a].1.get(i))
            };
            if let (Some(x), Some(y), Some(z)) = (at(0), at(1), at(2)) {
                for a in 0..3 {
                    sum[a] += z * y * x * force[a];
                }
            }
        }
    }
    for threads in [1, 2, 3, 7] {
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()
            .unwrap();
        let mut sums = Vec::new();
        pool.install(|| touched.spread(&force, &mut sums));
        assert!(sums == plain, "{threads}");
    }
}

#[test]
fn linear_fields_are_interpolated_exactly() {
    let positions = positions();
    let mut touched = TouchedCells::default();
    touched.rebuild(&positions, [24, 20, 18]).unwrap();
    let field: Vec<[f64; 3]> = touched.cells.iter().map(|c| c.map(f64::from)).collect();
    for (m, position) in positions.iter().enumerate() {
        let value = touched.interpolate(m, &field);
        for a in 0..3 {
            assert!((value[a] - position[a]).abs() < 1e-12);
        }
    }
}

#[test]
fn rows_are_ordered_and_cover_all_cells() {
    let mut touched = TouchedCells::default();
    touched.rebuild(&positions(), [24, 20, 18]).unwrap();
    let mut covered = 0;
    for (row, first, end) in &touched.rows {
        assert_eq!(*first, covered);
        covered = *end;
        for c in *first..*end {
            let [_, y, z] = touched.cells[c as usize];
            assert_eq!(y + z * 20, *row);
        }
    }
    assert_eq!(covered as usize, touched.cells.len());
    assert!(touched.rows.windows(2).all(|pair| pair[0].0 < pair[1].0));
}

/// Through a side that repeats, a sheet of markers one cell apart covers every cell alike.
#[test]
fn kernels_go_on_through_sides_that_repeat() {
    let domain = Domain {
        kept: 0,
        cells: [12, 6, 5],
        repeats: [false, true, true],
        folds: None,
    };
    let positions: Vec<[f64; 3]> = (0..30)
        .map(|i| [5.3, f64::from(i % 6) - 0.2, f64::from(i / 6) - 0.4])
        .collect();
    let mut touched = TouchedCells::default();
    touched.rebuild(&positions, domain).unwrap();
    assert_eq!(touched.cells.len(), 4 * 30);
    let mut sums = Vec::new();
    touched.spread(&[[1.0]; 30], &mut sums);
    let (_, along) = kernel::weights(5.3);
    for (cell, place) in touched.cells.iter().enumerate() {
        let expected = along[place[0] as usize - 4];
        assert!((sums[cell][0] - expected).abs() < 1e-14);
    }
    assert!(touched.rebuild(&[[5.3, 5.6, 1.0]], domain).is_err());
}

/// At faces that a body passes through markers and cells exchange what a body and its image exchange in the doubled box.
#[test]
fn folded_kernels_are_those_of_a_body_and_its_image() {
    let folds = Folds {
        sides: [[true, false], [false, true]],
        outlet: true,
    };
    let domain = Domain {
        kept: 0,
        cells: [14, 12, 11],
        repeats: [false; 3],
        folds: Some(folds),
    };
    // Behind the lower side of y and the upper side of z lie images; cells of y go from −12 to 11, those of z from 0 to 21.
    let image = |[x, y, z]: [f64; 3], turns: [bool; 2]| {
        let y = if turns[0] { -1.0 - y } else { y };
        [x, y, if turns[1] { 21.0 - z } else { z }]
    };
    let positions: Vec<[f64; 3]> = (0..300)
        .map(|k| {
            let t = f64::from(k);
            let part = |factor: f64| (t * factor).fract();
            [
                5.0 + 8.4 * part(0.618),
                -0.5 + 6.0 * part(0.414).powi(2),
                10.49 - 6.0 * part(0.732).powi(2),
            ]
        })
        .collect();
    let turns = [[false, false], [true, false], [false, true], [true, true]];
    // Moved by 12 along y, so that no place is negative.
    let doubled: Vec<[f64; 3]> = turns
        .into_iter()
        .flat_map(|turn| positions.iter().map(move |p| image(*p, turn)))
        .map(|[x, y, z]| [x, y + 12.0, z])
        .collect();
    let mut folded = TouchedCells::default();
    folded.rebuild(&positions, domain).unwrap();
    let mut whole = TouchedCells::default();
    // Beyond the outlet there is room, and the last cell's value.
    whole.rebuild(&doubled, [20, 24, 22]).unwrap();
    let field = |[x, y, z]: [f64; 3]| {
        let v = [(0.3 * x).sin() + 0.1 * y, (0.5 * y + x).cos(), 0.2 * z * y];
        v.map(|v| v + 0.3 * z)
    };
    let values: Vec<[f64; 3]> = folded
        .cells
        .iter()
        .map(|c| field(c.map(f64::from)))
        .collect();
    let beyond: Vec<[f64; 3]> = whole
        .cells
        .iter()
        .map(|c| {
            let [x, y, z] = c.map(f64::from);
            let turn = [y < 12.0, z > 10.5];
            let [u, v, w] = field(image([x.min(13.0), y - 12.0, z], turn));
            [
                u,
                if turn[0] { -v } else { v },
                if turn[1] { -w } else { w },
            ]
        })
        .collect();
    let mut read: Vec<[f64; 3]> = (0..positions.len())
        .map(|m| folded.interpolate(m, &values))
        .collect();
    for (marker, axis, part) in folded.interpolate_normals(&values) {
        read[marker][axis] += part;
    }
    for (m, read) in read.iter().enumerate() {
        let expected = whole.interpolate(m, &beyond);
        for a in 0..3 {
            assert!((read[a] - expected[a]).abs() < 1e-12, "{m} {a}");
        }
    }
    let forces: Vec<[f64; 3]> = (0..positions.len())
        .map(|m| [(m as f64).cos(), (m as f64).sin(), 1.0 / (1.0 + m as f64)])
        .collect();
    let of_images: Vec<[f64; 3]> = turns
        .into_iter()
        .flat_map(|turn| {
            forces.iter().map(move |&[x, y, z]| {
                let y = if turn[0] { -y } else { y };
                [x, y, if turn[1] { -z } else { z }]
            })
        })
        .collect();
    let (mut got, mut expected) = (Vec::new(), Vec::new());
    folded.spread(&forces, &mut got);
    folded.spread_normals(&forces, &mut got);
    whole.spread(&of_images, &mut expected);
    for (cell, got) in folded.cells.iter().zip(&got) {
        let own = |c: &[u32; 3]| [c[0].min(13), c[1], c[2]] == [cell[0], cell[1] + 12, cell[2]];
        let mut sum = [0.0; 3];
        for (c, force) in whole.cells.iter().zip(&expected) {
            if own(c) {
                for a in 0..3 {
                    sum[a] += force[a];
                }
            }
        }
        for a in 0..3 {
            assert!((got[a] - sum[a]).abs() < 1e-12, "{cell:?} {a}");
        }
    }
    let sides = folded.rows.iter().map(|(row, _, _)| row % 12);
    assert_eq!(sides.min(), Some(0));
}

#[test]
fn markers_near_the_border_are_reported() {
    let mut touched = TouchedCells::default();
    let error = touched
        .rebuild(&[[5.0, 5.0, 5.0], [0.5, 5.0, 5.0]], [10, 10, 10])
        .unwrap_err();
    assert_eq!(error.marker, 1);
    assert!(
        touched
            .rebuild(&[[f64::NAN, 5.0, 5.0]], [10, 10, 10])
            .is_err()
    );
}
