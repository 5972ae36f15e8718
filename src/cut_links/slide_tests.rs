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

/// In the crease of two plates that meet at an angle of 40 degrees the air sticks, along the rest of them it slides.
#[test]
fn air_sticks_in_creases() {
    let domain = Domain {
        cells: [40, 40, 20],
        repeats: [false; 3],
        kept: 0,
        open: false,
    };
    let crease = DVec3::new(8.3, 20.2, 0.0);
    let ends = [-20_f64, 20.0].map(|angle| {
        let angle = angle.to_radians();
        crease + 24.0 * DVec3::new(angle.cos(), angle.sin(), 0.0)
    });
    let at = |place: DVec3| [4.3, 15.4].map(|z| place + DVec3::Z * z);
    let positions = [at(crease), at(ends[0]), at(ends[1])].concat();
    let triangles = [[0, 2, 3], [3, 1, 0], [0, 1, 5], [5, 4, 0]];
    let normals = triangles.map(|nodes: [u32; 3]| {
        let [a, b, c] = nodes.map(|node| positions[node as usize]);
        (b - a).cross(c - a).normalize()
    });
    let mut links = CutLinks::default();
    links.find(&positions, &triangles, &domain).unwrap();
    let mut images = Images::default();
    images.find(&links, &domain, |triangle| {
        Some(Slides {
            normal: normals[triangle],
            modelled: false,
        })
    });
    let (mut sides, mut nearest) = (0, f64::INFINITY);
    for (link, side) in images.sides() {
        let [x, y, z] = links.links()[link].cells[side].map(f64::from);
        let along = x - crease.x;
        if (6.0..14.0).contains(&z) && (y - crease.y).abs() < along * 20_f64.to_radians().tan() {
            sides += 1;
            nearest = nearest.min(along);
        }
    }
    // Where the plates are three cells apart, straight ahead of either.
    assert!(sides > 500, "{sides}");
    assert!((3.0..7.0).contains(&nearest), "{nearest}");
}
