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
