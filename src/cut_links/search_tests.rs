//! What a surface cuts, wherever it stands.

use super::*;

/// A ball, its poles along z.
fn ball(middle: DVec3, radius: f64) -> (Vec<DVec3>, Vec<[u32; 3]>) {
    const AROUND: u32 = 24;
    const DOWN: u32 = 12;
    let mut positions = vec![middle + DVec3::Z * radius];
    for ring in 1..DOWN {
        let polar = std::f64::consts::PI * f64::from(ring) / f64::from(DOWN);
        for k in 0..AROUND {
            let turn = std::f64::consts::TAU * f64::from(k) / f64::from(AROUND);
            let direction = DVec3::new(
                polar.sin() * turn.cos(),
                polar.sin() * turn.sin(),
                polar.cos(),
            );
            positions.push(middle + direction * radius);
        }
    }
    positions.push(middle - DVec3::Z * radius);
    let last = positions.len() as u32 - 1;
    let at = |ring: u32, k: u32| 1 + AROUND * (ring - 1) + k % AROUND;
    let mut triangles = Vec::new();
    for k in 0..AROUND {
        triangles.push([0, at(1, k), at(1, k + 1)]);
        triangles.push([last, at(DOWN - 1, k + 1), at(DOWN - 1, k)]);
        for ring in 1..DOWN - 1 {
            triangles.push([at(ring, k), at(ring + 1, k), at(ring + 1, k + 1)]);
            triangles.push([at(ring, k), at(ring + 1, k + 1), at(ring, k + 1)]);
        }
    }
    (positions, triangles)
}

const DOMAIN: Domain = Domain {
    cells: [20, 20, 20],
    repeats: [false; 3],
    kept: 0,
    open_from: None,
};

fn found(positions: &[DVec3], triangles: &[[u32; 3]], domain: &Domain) -> CutLinks {
    let mut links = CutLinks::default();
    links.find(positions, triangles, domain).unwrap();
    links
}

/// Every cut lies on its triangle and on its link.
#[test]
fn cuts_lie_on_triangle_and_link() {
    let (positions, triangles) = ball(DVec3::new(9.3, 9.8, 10.1), 5.2);
    let links = found(&positions, &triangles, &DOMAIN);
    assert!(links.links().len() > 500);
    for link in links.links() {
        let a = as_vector(link.cells[0]);
        assert_eq!(a + link.direction(), as_vector(link.cells[1]));
        for cut in &link.cuts {
            let nodes = triangles[cut.triangle as usize];
            let on_triangle: DVec3 = (nodes.iter().zip(cut.weights))
                .map(|(n, w)| positions[*n as usize] * w)
                .sum();
            let on_link = a + link.direction() * cut.at;
            assert!((on_triangle + GENERAL_POSITION - on_link).length() < 1e-12);
            assert!((0.0..1.0).contains(&cut.at));
            assert!(cut.weights.iter().all(|w| *w >= 0.0));
        }
    }
}

/// Links from inside a closed surface to outside are cut an odd number of times, all others an even number. It is so wherever it stands, with nodes and edges on lines of
/// cell centres, too.
#[test]
fn a_closed_surface_is_tight() {
    let places = [
        (DVec3::new(9.5, 9.5, 9.5), 5.0),
        (DVec3::new(10.0, 10.0, 10.0), 4.0),
        (DVec3::new(9.13, 10.4, 9.77), 5.63),
    ];
    for (middle, radius) in places {
        for turned in [false, true] {
            let (positions, mut triangles) = ball(middle, radius);
            if turned {
                for nodes in &mut triangles {
                    nodes.swap(1, 2);
                }
            }
            let links = found(&positions, &triangles, &DOMAIN);
            let odd = |cell: [i32; 3], pair: u8| {
                let same = |link: &&CutLink| link.cells[0] == cell && link.pair == pair;
                links
                    .links()
                    .iter()
                    .find(same)
                    .is_some_and(|link| link.layers % 2 == 1)
            };
            // From a cell outside, crossing no cut: what is reached is outside.
            let mut outside = vec![false; 8000];
            let index = |c: [i32; 3]| (c[0] + 20 * (c[1] + 20 * c[2])) as usize;
            let mut open = vec![[0, 0, 0]];
            outside[0] = true;
            while let Some(cell) = open.pop() {
                for pair in 0..9_u8 {
                    let c = DIRECTIONS[2 * usize::from(pair) + 1];
                    for sign in [1, -1] {
                        let next: [i32; 3] = std::array::from_fn(|a| cell[a] + sign * c[a]);
                        if next.iter().any(|n| !(0..20).contains(n)) {
                            continue;
                        }
                        let start = if sign == 1 { cell } else { next };
                        if !odd(start, pair) && !outside[index(next)] {
                            outside[index(next)] = true;
                            open.push(next);
                        }
                    }
                }
            }
            let inside = outside.iter().filter(|out| !**out).count() as f64;
            let parts = triangles.iter().map(|nodes| {
                let [a, b, c] = nodes.map(|n| positions[n as usize] - middle);
                a.dot(b.cross(c)) / 6.0
            });
            let volume = parts.sum::<f64>().abs();
            assert!((inside / volume - 1.0).abs() < 0.05, "{inside} {volume}");
        }
    }
}

/// A sheet through the middles of cells, whose nodes and edges lie on their lines, cuts every link that passes it once.
#[test]
fn a_sheet_on_cell_centres_is_cut_once() {
    let domain = Domain {
        open_from: Some(0),
        ..DOMAIN
    };
    let mut positions = Vec::new();
    for z in 0..21 {
        for y in 0..21 {
            positions.push(DVec3::new(10.0, f64::from(y), f64::from(z)));
        }
    }
    let mut triangles = Vec::new();
    for z in 0..20_u32 {
        for y in 0..20_u32 {
            let at = |dy: u32, dz: u32| y + dy + 21 * (z + dz);
            triangles.extend([
                [at(0, 0), at(1, 0), at(1, 1)],
                [at(0, 0), at(1, 1), at(0, 1)],
            ]);
        }
    }
    let links = found(&positions, &triangles, &domain);
    assert_eq!(links.doubled(), [0; 0]);
    let along_x = links.links().iter().filter(|link| link.pair == 0);
    let cells: Vec<_> = along_x.map(|link| link.cells[0][0]).collect();
    assert!(cells.iter().all(|cell| *cell == 10));
    assert_eq!(cells.len(), 19 * 19);
}

/// A fold that enters and leaves a link is one link with two cuts, the nearest to each cell on its side.
#[test]
fn a_fold_in_a_link_has_two_layers() {
    let plane = |x: f64, first: u32| {
        let corners = [[2.2, 2.2], [17.7, 2.2], [17.7, 17.7], [2.2, 17.7]];
        (
            corners.map(|[y, z]| DVec3::new(x, y, z)),
            [[first, first + 1, first + 2], [first, first + 2, first + 3]],
        )
    };
    let (one, of_one) = plane(9.25, 0);
    let (other, of_other) = plane(9.75, 4);
    let links = found(
        &[one, other].concat(),
        &[of_one, of_other].concat(),
        &DOMAIN,
    );
    assert!(!links.doubled().is_empty());
    for link in links.links().iter().filter(|link| link.pair == 0) {
        assert_eq!(link.layers, 2);
        let off = link.cuts[0].at - 0.25 - GENERAL_POSITION.x;
        assert!(off.abs() < 1e-12);
        assert!((link.distance(1) - 0.25 + GENERAL_POSITION.x).abs() < 1e-12);
    }
}

/// A surface across sides that repeat cuts the links over them.
#[test]
fn sides_that_repeat_have_links_over_them() {
    let domain = Domain {
        cells: [20, 6, 6],
        repeats: [false, true, true],
        kept: 0,
        open_from: None,
    };
    let corners = [[-0.5, -0.5], [5.5, -0.5], [5.5, 5.5], [-0.5, 5.5]];
    let positions = corners.map(|[y, z]| DVec3::new(9.3, y, z));
    let links = found(&positions, &[[0, 1, 2], [0, 2, 3]], &domain);
    // One along x and four along diagonals for each of 36 cells.
    assert_eq!(links.links().len(), 5 * 36);
    assert!(links.links().iter().all(|link| link.layers == 1));
}

/// Nodes outside the air are told.
#[test]
fn a_node_outside_is_told() {
    let (positions, triangles) = ball(DVec3::new(3.0, 9.0, 9.0), 5.0);
    let mut links = CutLinks::default();
    assert!(links.find(&positions, &triangles, &DOMAIN).is_err());
    // Triangles from one on may go on beyond a face, those before may not.
    let open = |from| Domain {
        open_from: Some(from),
        ..DOMAIN
    };
    assert!(links.find(&positions, &triangles, &open(0)).is_ok());
    let last = triangles.len();
    assert!(links.find(&positions, &triangles, &open(last)).is_err());
    let kept = Domain { kept: 6, ..DOMAIN };
    let (positions, triangles) = ball(DVec3::new(9.5, 9.5, 9.5), 5.0);
    assert!(links.find(&positions, &triangles, &kept).is_err());
    let mut lost = positions;
    lost[3].x = f64::NAN;
    assert!(links.find(&lost, &triangles, &DOMAIN).is_err());
}

/// Some threads find and sort the same as one.
#[test]
fn threads_do_not_matter() {
    let domain = Domain {
        cells: [40; 3],
        ..DOMAIN
    };
    let (positions, triangles) = ball(DVec3::splat(19.7), 15.3);
    let on = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads);
        pool.build().unwrap().install(|| {
            let links = found(&positions, &triangles, &domain);
            // Enough for several tasks.
            assert!(links.links().len() > 2 * 4096, "{}", links.links().len());
            let mut sorted = crate::cut_links::CutsByTriangle::default();
            sorted.sort(&links, triangles.len());
            let cuts: Vec<Vec<(u32, u8)>> = (sorted.triangles().iter())
                .map(|triangle| sorted.of(*triangle).to_vec())
                .collect();
            (links.links().to_vec(), sorted.triangles().to_vec(), cuts)
        })
    };
    assert!(on(1) == on(3));
}

/// Sorted by triangle no cut is lost, and they stay in the order of links; triangles from a number on are left out.
#[test]
fn cuts_are_sorted_by_triangle() {
    let (positions, triangles) = ball(DVec3::new(9.3, 9.8, 10.1), 5.2);
    let links = found(&positions, &triangles, &DOMAIN);
    let mut sorted = crate::cut_links::CutsByTriangle::default();
    for count in [triangles.len(), triangles.len() / 2, 0] {
        sorted.sort(&links, count);
        let mut cuts = 0;
        for &triangle in sorted.triangles() {
            let of_it = sorted.of(triangle);
            assert!(!of_it.is_empty() && of_it.is_sorted());
            for &(link, side) in of_it {
                let cut = &links.links()[link as usize].cuts[usize::from(side)];
                assert_eq!(cut.triangle, triangle);
            }
            cuts += of_it.len();
        }
        let wanted = links.links().iter().flat_map(|link| link.cuts);
        let wanted = wanted.filter(|cut| (cut.triangle as usize) < count).count();
        assert_eq!(cuts, wanted);
    }
}

/// Links are ordered by the cell that they lead from, x fastest, then by pair. What is known around cells is what leads from them and to them.
#[test]
fn links_are_in_order() {
    let (positions, triangles) = ball(DVec3::new(9.3, 9.8, 10.1), 5.2);
    let links = found(&positions, &triangles, &DOMAIN);
    let place = |link: &CutLink| {
        let [x, y, z] = link.cells[0];
        (z, y, x, link.pair)
    };
    assert!(links.links().is_sorted_by(|a, b| place(a) < place(b)));
    let mut around = std::collections::HashMap::<[i32; 3], u32>::new();
    for link in links.links() {
        for side in [0, 1] {
            *around.entry(link.cells[side]).or_default() |= 1 << link.leaving(side);
        }
    }
    for (cell, wanted) in around {
        let cut = links.cut_around(cell);
        assert_eq!(cut.directions(), wanted);
        assert!((1..19).all(|direction| cut.has(direction) == (wanted >> direction & 1 == 1)));
    }
}
