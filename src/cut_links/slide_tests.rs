//! Where air slides, and where it sticks.

use super::*;

/// Between two plates less than three cells apart the air sticks, farther apart it slides; outside it slides anyhow.
#[test]
fn air_sticks_in_narrow_gaps() {
    let domain = Domain {
        cells: [20; 3],
        repeats: [false; 3],
        kept: 0,
        open: false,
    };
    for (cells_between, slides) in [(1, false), (2, false), (3, true), (4, true)] {
        let plate = |height: f64| {
            [[5.2, 5.3], [14.6, 5.3], [14.6, 14.7], [5.2, 14.7]]
                .map(|[x, y]| DVec3::new(x, y, height))
        };
        let upper = 8.4 + f64::from(cells_between);
        let positions = [plate(8.4), plate(upper)].concat();
        let triangles = [[0, 1, 2], [2, 3, 0], [4, 5, 6], [6, 7, 4]];
        let mut links = CutLinks::default();
        links.find(&positions, &triangles, &domain).unwrap();
        for modelled in [false, true] {
            let mut images = Images::default();
            images.find(&links, &domain, |_| {
                Some(Slides {
                    normal: DVec3::Z,
                    modelled,
                })
            });
            // Off the rims, beside which the way across is free.
            let between = |(link, side): &(usize, usize)| {
                let [x, y, z] = links.links()[*link].cells[*side];
                (8.4..upper).contains(&f64::from(z)) && [x, y].iter().all(|n| (7..13).contains(n))
            };
            let inside = images.sides().filter(between).count();
            assert_eq!(inside > 0, slides, "{cells_between} cells");
            let outside = images.sides().count() - inside;
            assert!(outside > 500, "{cells_between} cells: {outside}");
        }
    }
}

/// In the crease of two plates at right angles the air sticks, though there is room before each of them; beside it, it slides along both.
#[test]
fn air_sticks_in_creases() {
    let domain = Domain {
        cells: [40, 40, 20],
        repeats: [false; 3],
        kept: 0,
        open: false,
    };
    let places = [[8.3, 20.2], [32.3, 20.2], [8.3, 36.2]];
    let corners = places.map(|[x, y]| [4.3, 15.4].map(|z| DVec3::new(x, y, z)));
    let positions = corners.concat();
    let triangles = [[0, 2, 3], [3, 1, 0], [0, 1, 5], [5, 4, 0]];
    let normals = [DVec3::Y, DVec3::Y, DVec3::X, DVec3::X];
    let mut links = CutLinks::default();
    links.find(&positions, &triangles, &domain).unwrap();
    let mut images = Images::default();
    images.find(&links, &domain, |triangle| {
        Some(Slides {
            normal: normals[triangle],
            modelled: false,
        })
    });
    let slide_at = |x: i32, y: i32| {
        let at = |(link, side): &(usize, usize)| links.links()[*link].cells[*side] == [x, y, 10];
        images.sides().filter(at).count()
    };
    assert_eq!(slide_at(9, 21), 0);
    for [x, y] in [[10, 21], [9, 22], [20, 20], [8, 28]] {
        assert!(slide_at(x, y) > 0, "{x} {y}");
    }
}

/// Air that stagnates on a plane, u = a (x e − z n), speeds up along it: next to none of it passes, in the mean over where the plane lies between the cells.
#[test]
fn air_that_speeds_up_does_not_pass() {
    let domain = Domain {
        cells: [44; 3],
        repeats: [false; 3],
        kept: 0,
        open: false,
    };
    let growth = 1e-3;
    let mut passed = Vec::new();
    for (turn, lean) in [(0.0_f64, 0.0_f64), (0.3, 0.0), (0.6, 0.4), (0.785, 0.6)] {
        let along = DVec3::new(turn.cos(), 0.0, turn.sin());
        let across = DVec3::new(0.0, lean.cos(), lean.sin());
        let normal = along.cross(across).normalize();
        let across = normal.cross(along);
        let (mut lost, mut area) = (0.0, 0.0);
        for shift in 0..40 {
            let k = f64::from(shift);
            let middle = DVec3::splat(21.5) + DVec3::new(0.618 * k, 0.755 * k, 0.57 * k).fract();
            let corner = |a: f64, b: f64| middle + (along * a + across * b) * 13.0;
            let positions = [
                corner(-1.0, -1.0),
                corner(1.0, -1.0),
                corner(1.0, 1.0),
                corner(-1.0, 1.0),
            ];
            let mut links = CutLinks::default();
            (links.find(&positions, &[[0, 1, 2], [2, 3, 0]], &domain)).unwrap();
            let mut images = Images::default();
            images.find(&links, &domain, |_| {
                Some(Slides {
                    normal,
                    modelled: false,
                })
            });
            // Shifted populations of first order.
            let leaving = |cell: [i32; 3]| -> Leaving {
                let at = DVec3::from_array(cell.map(f64::from)) - middle;
                let off = at.dot(normal);
                let velocity = (along * at.dot(along) - normal * off) * growth;
                std::array::from_fn(|i| 3.0 * WEIGHTS[i] * vector(i).dot(velocity))
            };
            let all: Vec<Leaving> = images
                .cells(Asked::Images)
                .iter()
                .map(|c| leaving(*c))
                .collect();
            images.take(&all);
            let of_link = |link: &CutLink| {
                crate::cut_links::SIDES.map(|side| Return {
                    out: leaving(link.cells[side])[link.leaving(side)],
                    ..Return::default()
                })
            };
            let mut returns: Vec<[Return; 2]> = links.links().iter().map(of_link).collect();
            let mut losses = Vec::new();
            images.returned(&all, |_, _| DVec3::ZERO, &mut returns, &mut losses);
            for (link, side) in images.sides() {
                let cut = &links.links()[link];
                let at = DVec3::from_array(cut.cells[side].map(f64::from))
                    + vector(cut.leaving(side)) * cut.distance(side)
                    - middle;
                if at.dot(along).abs() < 8.0 && at.dot(across).abs() < 8.0 {
                    lost += losses[link][side].all;
                }
            }
            area += 2.0 * 16.0 * 16.0;
        }
        passed.push(lost / (area * growth));
    }
    // 0.043, −0.010, −0.016, 0.011 of what the flow gains over a cell. As high as the cells lie: −0.007, −0.052, −0.060, −0.039.
    let mean = passed.iter().sum::<f64>() / passed.len() as f64;
    assert!(mean.abs() < 0.02, "{passed:?}");
    assert!(passed.iter().all(|p| p.abs() < 0.05), "{passed:?}");
}

/// Every direction of the lattice is nearest to itself. The cube's diagonal is 35.3° from three of them, and nothing is farther; of those three the last counts.
#[test]
fn the_straightest_direction_is_near() {
    for direction in 1..DIRECTION_COUNT {
        assert_eq!(straightest(vector(direction).normalize()), direction);
    }
    let diagonal = DVec3::ONE.normalize();
    let last = (1..DIRECTION_COUNT).rfind(|d| vector(*d).normalize().dot(diagonal) > 0.8);
    assert_eq!(Some(straightest(diagonal)), last);
    let farthest = (2.0 / 3.0_f64).sqrt() - 1e-12;
    for i in 0..20 {
        for k in 0..40 {
            let (z, turn) = (-1.0 + 0.1 * f64::from(i) + 0.05, 0.157 * f64::from(k));
            let across = (1.0 - z * z).sqrt();
            let towards = DVec3::new(across * turn.cos(), across * turn.sin(), z);
            let own = vector(straightest(towards)).normalize().dot(towards);
            assert!(own >= farthest, "{towards} by {own}");
            let nearer =
                (1..DIRECTION_COUNT).any(|d| vector(d).normalize().dot(towards) > own + 1e-12);
            assert!(!nearer, "{towards}");
        }
    }
}
