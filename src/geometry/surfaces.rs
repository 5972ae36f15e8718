//! Surfaces of simple bodies, about the origin, divided into triangles with edges of a given length.

use std::collections::HashMap;
use std::f64::consts::{PI, TAU};

use glam::DVec3;

use crate::rigid::Surface;

/// Parts into which a length is divided.
fn parts(length: f64, edge_m: f64, least: usize) -> usize {
    ((length / edge_m).ceil() as usize).max(least)
}

/// A sphere: an icosahedron whose faces are divided evenly, normals outwards.
#[must_use]
pub fn sphere(radius_m: f64, edge_m: f64) -> Surface {
    let golden = 0.5 * (1.0 + 5f64.sqrt());
    let mut corners = Vec::new();
    for (a, b) in [
        (1.0, golden),
        (-1.0, golden),
        (1.0, -golden),
        (-1.0, -golden),
    ] {
        corners.extend([
            DVec3::new(0.0, a, b),
            DVec3::new(a, b, 0.0),
            DVec3::new(b, 0.0, a),
        ]);
    }
    // The edge of the icosahedron is 2, its circumradius √(1 + φ²).
    let unit = 1.0 / (1.0 + golden * golden).sqrt();
    // Edges near the middle of a face are stretched the most, by circumradius over inradius.
    let n = parts(1.26 * radius_m * 2.0 * unit, edge_m, 1);
    let mut surface = Surface::default();
    let mut numbers: HashMap<[i64; 3], u32> = HashMap::new();
    let mut node = |place: DVec3, positions: &mut Vec<DVec3>| {
        let direction = place.normalize();
        let key = (direction * 1e9).round().to_array().map(|x| x as i64);
        *numbers.entry(key).or_insert_with(|| {
            positions.push(direction * radius_m);
            positions.len() as u32 - 1
        })
    };
    for i in 0..12 {
        for j in i + 1..12 {
            for k in j + 1..12 {
                let [a, mut b, mut c] = [corners[i], corners[j], corners[k]];
                let near = |p: DVec3, q: DVec3| (p.distance(q) - 2.0).abs() < 1e-9;
                if !(near(a, b) && near(b, c) && near(c, a)) {
                    continue;
                }
                if a.dot(b.cross(c)) < 0.0 {
                    (b, c) = (c, b);
                }
                let place = |p: usize, q: usize| {
                    a + (b - a) * (p as f64 / n as f64) + (c - a) * (q as f64 / n as f64)
                };
                for p in 0..n {
                    for q in 0..n - p {
                        let mut add = |nodes: [(usize, usize); 3]| {
                            let nodes =
                                nodes.map(|(p, q)| node(place(p, q), &mut surface.positions_m));
                            surface.triangles.push(nodes);
                        };
                        add([(p, q), (p + 1, q), (p, q + 1)]);
                        if p + q + 1 < n {
                            add([(p + 1, q), (p + 1, q + 1), (p, q + 1)]);
                        }
                    }
                }
            }
        }
    }
    surface
}

/// A disk in the plane x = 0, normal along +x: rings of 6, 12, 18, … nodes around the middle.
#[must_use]
pub fn disk(radius_m: f64, edge_m: f64) -> Surface {
    let rings = parts(radius_m, edge_m, 1);
    let mut surface = Surface {
        positions_m: vec![DVec3::ZERO],
        triangles: Vec::new(),
    };
    let first = |ring: usize| {
        if ring == 0 {
            0
        } else {
            1 + 3 * ring * (ring - 1)
        }
    };
    for ring in 1..=rings {
        for k in 0..6 * ring {
            let (sine, cosine) = (TAU * k as f64 / (6 * ring) as f64).sin_cos();
            let radius = radius_m * ring as f64 / rings as f64;
            surface
                .positions_m
                .push(DVec3::new(0.0, radius * cosine, radius * sine));
        }
    }
    let node =
        |ring: usize, k: usize| (first(ring) + if ring == 0 { 0 } else { k % (6 * ring) }) as u32;
    for ring in 1..=rings {
        for sector in 0..6 {
            for k in 0..ring {
                let outer = [sector * ring + k, sector * ring + k + 1].map(|k| node(ring, k));
                let inner = sector * (ring - 1) + k;
                surface
                    .triangles
                    .push([node(ring - 1, inner), outer[0], outer[1]]);
                if k + 1 < ring {
                    surface.triangles.push([
                        node(ring - 1, inner),
                        outer[1],
                        node(ring - 1, inner + 1),
                    ]);
                }
            }
        }
    }
    surface
}

/// A rectangle in the plane x = 0, width along y, height along z, normal along +x.
#[must_use]
pub fn plate(size_m: [f64; 2], edge_m: f64) -> Surface {
    let [n, m] = size_m.map(|size| parts(size, edge_m, 1));
    let mut surface = Surface::default();
    for j in 0..=m {
        for i in 0..=n {
            surface.positions_m.push(DVec3::new(
                0.0,
                size_m[0] * (i as f64 / n as f64 - 0.5),
                size_m[1] * (j as f64 / m as f64 - 0.5),
            ));
        }
    }
    let node = |i: usize, j: usize| (i + (n + 1) * j) as u32;
    for j in 0..m {
        for i in 0..n {
            let (a, b) = (node(i, j), node(i + 1, j));
            let (c, d) = (node(i + 1, j + 1), node(i, j + 1));
            // Alternate diagonals, so that no direction is preferred.
            if (i + j) % 2 == 0 {
                surface.triangles.extend([[a, b, c], [a, c, d]]);
            } else {
                surface.triangles.extend([[a, b, d], [b, c, d]]);
            }
        }
    }
    surface
}

/// A circular cylinder along z, normals outwards, with flat ends if `closed`.
#[must_use]
pub fn cylinder(radius_m: f64, length_m: f64, closed: bool, edge_m: f64) -> Surface {
    // The ends' rim has six nodes per ring.
    let rings = parts(radius_m * PI / 3.0, edge_m, 1);
    let n = 6 * rings;
    let m = parts(length_m, edge_m, 1);
    let mut surface = Surface::default();
    for j in 0..=m {
        for i in 0..n {
            let (sine, cosine) = (TAU * i as f64 / n as f64).sin_cos();
            let z = length_m * (j as f64 / m as f64 - 0.5);
            surface
                .positions_m
                .push(DVec3::new(radius_m * cosine, radius_m * sine, z));
        }
    }
    let node = |i: usize, j: usize| (i % n + n * j) as u32;
    for j in 0..m {
        for i in 0..n {
            let (a, b) = (node(i, j), node(i + 1, j));
            let (c, d) = (node(i + 1, j + 1), node(i, j + 1));
            if (i + j) % 2 == 0 {
                surface.triangles.extend([[a, b, c], [a, c, d]]);
            } else {
                surface.triangles.extend([[a, b, d], [b, c, d]]);
            }
        }
    }
    if closed {
        let end = disk(radius_m, radius_m / rings as f64);
        let inner = end.positions_m.len() - n;
        for (z, layer, turned) in [(-0.5, 0, true), (0.5, m, false)] {
            let start = surface.positions_m.len() as u32;
            for place in &end.positions_m[..inner] {
                surface
                    .positions_m
                    .push(DVec3::new(place.y, place.z, z * length_m));
            }
            for &nodes in &end.triangles {
                let mut nodes = nodes.map(|k| match (k as usize).checked_sub(inner) {
                    Some(rim) => node(rim, layer),
                    None => start + k,
                });
                if turned {
                    nodes.swap(1, 2);
                }
                surface.triangles.push(nodes);
            }
        }
    }
    surface
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn areas_volumes_and_rims() {
        let sphere = sphere(2.0, 0.2);
        assert!(sphere.is_closed());
        assert!((sphere.area_m2() / (16.0 * PI) - 1.0).abs() < 0.005);
        assert!((sphere.volume_m3().0 / (32.0 * PI / 3.0) - 1.0).abs() < 0.005);
        assert!(sphere.volume_m3().1.length() < 1e-9);
        let longest = sphere
            .extents()
            .map(|e| e.longest_edge_m)
            .fold(0.0, f64::max);
        assert!((0.12..0.2).contains(&longest), "{longest}");
        let disk = disk(1.5, 0.1);
        assert!((disk.area_m2() / (2.25 * PI) - 1.0).abs() < 0.002);
        assert_eq!(disk.rim().len(), 6 * 15);
        assert!(disk.area_vectors_m2().all(|a| a.x > 0.0));
        let plate = plate([2.0, 1.0], 0.3);
        assert!((plate.area_m2() - 2.0).abs() < 1e-12);
        assert!(plate.area_vectors_m2().all(|a| a.x > 0.0));
        let tube = cylinder(1.0, 3.0, false, 0.1);
        assert!((tube.area_m2() / (6.0 * PI) - 1.0).abs() < 0.002);
        assert!(!tube.is_closed());
        let cylinder = cylinder(1.0, 3.0, true, 0.1);
        assert!(cylinder.is_closed());
        assert!((cylinder.volume_m3().0 / (3.0 * PI) - 1.0).abs() < 0.004);
    }
}
