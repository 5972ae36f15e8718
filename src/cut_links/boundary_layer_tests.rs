//! Layers along a plate against Blasius, Thwaites and Schlichting, in air whose velocity is known.

use super::*;

/// A plate in the plane y = 0, `length` long and 4 wide, of triangles about a cell long, turned about z.
fn plate(length: usize, turned_deg: f64) -> (Vec<DVec3>, Vec<[u32; 3]>) {
    let (across, turn) = (5, glam::DQuat::from_rotation_z(turned_deg.to_radians()));
    let nodes = (0..=length).flat_map(|i| (0..across).map(move |j| (i, j)));
    let positions = nodes
        .map(|(i, j)| turn * DVec3::new(i as f64, 0.0, j as f64))
        .collect();
    let mut triangles = Vec::new();
    for i in 0..length as u32 {
        for j in 0..across - 1 {
            let [a, b] = [i * across + j, (i + 1) * across + j];
            let [c, d] = [b + 1, a + 1];
            triangles.extend(if (i + j) % 2 == 0 {
                [[a, b, c], [a, c, d]]
            } else {
                [[a, b, d], [b, c, d]]
            });
        }
    }
    (positions, triangles)
}

#[test]
fn triangles_that_the_stream_crosses_askew_change_nothing() {
    // Turbulent layers along the same plate, the stream up to 30 degrees off its edges: far from them θ follows from the distance along the stream.
    const LENGTH: usize = 60;
    let (positions, triangles) = {
        let wide = 40;
        let positions: Vec<DVec3> = (0..=LENGTH)
            .flat_map(|i| (0..=wide).map(move |j| DVec3::new(i as f64, 0.0, j as f64)))
            .collect();
        let row = wide as u32 + 1;
        let mut triangles = Vec::new();
        for (i, j) in (0..LENGTH as u32).flat_map(|i| (0..wide as u32).map(move |j| (i, j))) {
            let [a, b] = [i * row + j, (i + 1) * row + j];
            triangles.extend(if (i + j) % 2 == 0 {
                [[a, b, b + 1], [a, b + 1, a + 1]]
            } else {
                [[a, b, a + 1], [b, b + 1, a + 1]]
            });
        }
        (positions, triangles)
    };
    let normals: Vec<DVec3> = (triangles.iter())
        .map(|t| {
            let [a, b, c] = t.map(|node| positions[node as usize]);
            (b - a).cross(c - a).normalize()
        })
        .collect();
    let spaces = Spaces::new(&triangles, &positions, |_| true);
    let shape = Shape {
        triangles: &triangles,
        positions: &positions,
        normals: &normals,
        spaces: &spaces,
    };
    let viscosity = 1e-5;
    for askew in [5_f64, 15.0, 30.0] {
        let direction = glam::DQuat::from_rotation_y(askew.to_radians()) * DVec3::X;
        let modelled = vec![true; triangles.len()];
        let mut layers = BoundaryLayers::new(modelled, viscosity, 0.0).unwrap();
        for _ in 0..3 * LENGTH {
            layers.march(shape, |_| {
                Some(Seen {
                    velocities: [direction * SPEED; 2],
                    heights: HEIGHTS,
                })
            });
        }
        let mut seen = 0;
        for (number, nodes) in triangles.iter().enumerate() {
            let middle = nodes.map(|n| positions[n as usize]).iter().sum::<DVec3>() / 3.0;
            // Back along the stream to the front, and not out over a side.
            let run = middle.x / direction.x;
            let side = middle.z - run * direction.z;
            if middle.x < 20.0 || !(5.0..35.0).contains(&side) {
                continue;
            }
            let exact = (0.0106 * run * (viscosity / SPEED).powf(0.2)).powf(1.0 / 1.2);
            let thickness = layers.momentum_thickness(2 * number);
            assert!(
                (thickness / exact - 1.0).abs() < 0.05,
                "{askew} {middle} {thickness} {exact}"
            );
            seen += 1;
        }
        assert!(seen > 500, "{seen}");
    }
}

struct Marched {
    layers: BoundaryLayers,
    /// Distance of every triangle from the front.
    along: Vec<f64>,
}

/// Layers along a plate of 200 cells in air that flows along it with `speed` of the distances from its front and from it, taken at two `HEIGHTS`.
fn marched(
    viscosity: f64,
    transition_reynolds: f64,
    speed: impl Fn(f64, f64) -> f64 + Sync,
) -> Marched {
    const LENGTH: usize = 200;
    let (positions, triangles) = plate(LENGTH, 20.0);
    let direction = glam::DQuat::from_rotation_z(20_f64.to_radians()) * DVec3::X;
    let normals: Vec<DVec3> = (triangles.iter())
        .map(|t| {
            let [a, b, c] = t.map(|node| positions[node as usize]);
            (b - a).cross(c - a).normalize()
        })
        .collect();
    let along: Vec<f64> = (triangles.iter())
        .map(|t| t.map(|node| positions[node as usize].dot(direction)))
        .map(|x| x.iter().sum::<f64>() / 3.0)
        .collect();
    let spaces = Spaces::new(&triangles, &positions, |_| true);
    let modelled = vec![true; triangles.len()];
    let mut layers = BoundaryLayers::new(modelled, viscosity, transition_reynolds).unwrap();
    let shape = Shape {
        triangles: &triangles,
        positions: &positions,
        normals: &normals,
        spaces: &spaces,
    };
    for _ in 0..3 * LENGTH {
        // Every third triangle has no link.
        layers.march(shape, |face| {
            (face / 2 % 3 != 1).then(|| Seen {
                velocities: HEIGHTS.map(|height| direction * speed(along[face / 2], height)),
                heights: HEIGHTS,
            })
        });
    }
    Marched { layers, along }
}

impl Marched {
    /// Distance, θ and τ of all faces between two distances.
    fn between(&self, from: f64, to: f64) -> impl Iterator<Item = (f64, f64, f64)> {
        let inside = move |&(_, x): &(usize, &f64)| (from..to).contains(x);
        (self.along.iter().enumerate())
            .filter(inside)
            .flat_map(|(triangle, &x)| {
                [0, 1].map(|side| {
                    let face = 2 * triangle + side;
                    let stress = self.layers.stress(face).length();
                    (x, self.layers.momentum_thickness(face), stress)
                })
            })
    }

    /// Mean stress.
    fn mean_stress(&self) -> f64 {
        let sum: f64 = self.between(0.0, 1e9).map(|(_, _, stress)| stress).sum();
        sum / (2 * self.along.len()) as f64
    }
}

const SPEED: f64 = 0.1;
const HEIGHTS: [f64; 2] = [2.5, 5.5];

#[test]
fn a_laminar_layer_is_that_of_blasius() {
    // Thinner than 2.5 cells up to the end.
    for reynolds in [2e5, 1e6] {
        let viscosity = SPEED * 200.0 / reynolds;
        let plate = marched(viscosity, 1e9, |_, _| SPEED);
        for (x, thickness, _) in plate.between(20.0, 200.0) {
            let exact = 0.664 * (viscosity * x / SPEED).sqrt();
            assert!(
                (thickness / exact - 1.0).abs() < 0.06,
                "{x} {thickness} {exact}"
            );
        }
        // The gradient of the velocity between single triangles scatters.
        for from in (20..200).step_by(10).map(f64::from) {
            let ratios: Vec<f64> = (plate.between(from, from + 10.0))
                .map(|(x, _, stress)| {
                    stress / (0.332 * SPEED * SPEED / (SPEED * x / viscosity).sqrt())
                })
                .collect();
            let mean = ratios.iter().sum::<f64>() / ratios.len() as f64;
            assert!((mean - 1.0).abs() < 0.06, "{reynolds} {from} {mean}");
        }
    }
}

#[test]
fn a_turbulent_layer_has_the_friction_of_prandtl_and_schlichting() {
    for reynolds in [1e5_f64, 1e6, 1e7] {
        let viscosity = SPEED * 200.0 / reynolds;
        // Inside the layer the velocity of its profile.
        let speed = |x: f64, height: f64| {
            let thickness = 0.37 * x * (SPEED * x / viscosity).powf(-0.2);
            SPEED * (height / thickness).min(1.0).powf(1.0 / 7.0)
        };
        let plate = marched(viscosity, 0.0, speed);
        let friction = plate.mean_stress() / (0.5 * SPEED * SPEED);
        let exact = 0.455 / reynolds.log10().powf(2.58);
        assert!(
            (friction / exact - 1.0).abs() < 0.15,
            "{reynolds} {friction} {exact}"
        );
    }
}

#[test]
fn a_layer_turns_turbulent_where_it_is_told_to() {
    let viscosity = SPEED * 200.0 / 1e6;
    let plate = marched(viscosity, 5e5, |_, _| SPEED);
    // At half the length.
    let mean = |from: f64, to: f64| {
        let found: Vec<f64> = plate
            .between(from, to)
            .map(|(_, _, stress)| stress)
            .collect();
        found.iter().sum::<f64>() / found.len() as f64
    };
    let (before, behind) = (mean(90.0, 98.0), mean(104.0, 112.0));
    assert!(behind > 4.0 * before, "{before} {behind}");
    // No jump of the thickness there.
    let thickness = |from: f64, to: f64| {
        plate
            .between(from, to)
            .map(|(_, thickness, _)| thickness)
            .fold(0.0, f64::max)
    };
    assert!(thickness(101.0, 103.0) < 1.3 * thickness(97.0, 99.0));
}

#[test]
fn at_a_stagnation_line_the_layer_is_that_of_hiemenz() {
    // Both ways from the middle; Thwaites: θ² = 0.075 ν/(dU/ds), everywhere the same.
    let (viscosity, strain) = (1e-5, 1e-3);
    let plate = marched(viscosity, 1e9, |x, _| strain * (x - 100.0));
    for (x, thickness, _) in plate.between(120.0, 190.0) {
        let exact = (0.075 * viscosity / strain).sqrt();
        assert!(
            (thickness / exact - 1.0).abs() < 0.05,
            "{x} {thickness} {exact}"
        );
    }
}

#[test]
fn far_from_the_edge_of_a_thick_layer_the_law_of_the_wall_holds() {
    // 2.5 cells off, in a layer of a hundred.
    let layer = Layer {
        velocity: DVec3::X * 0.08,
        heights: HEIGHTS,
        thickness: 20.0,
        ..Layer::default()
    };
    let viscosity = 1e-5;
    let friction_velocity = turbulent_stress(&layer, viscosity).sqrt();
    let wall_units = 2.5 * friction_velocity / viscosity;
    let logarithmic = friction_velocity * (wall_units.ln() / KARMAN + 5.2);
    assert!((logarithmic / 0.08 - 1.0).abs() < 0.02, "{logarithmic}");
    // In the viscous sublayer the profile is straight.
    let layer = Layer {
        velocity: DVec3::X * 1e-4,
        ..layer
    };
    let slow = turbulent_stress(&layer, 0.01);
    assert!((slow / (0.01 * 1e-4 / 2.5) - 1.0).abs() < 0.02, "{slow:e}");
}

#[test]
fn layers_go_on_on_another_lattice() {
    let mut layers = BoundaryLayers::new(vec![true; 2], 1e-3, 0.0).unwrap();
    let one = [0.1, 0.2, -0.1, 0.3, 2.5, 5.5, 0.4, 1e-3, 2e-3, -1e-3];
    layers.go_on(&[one; 4], 3);
    let there = layers.saved_for([0.5, 2.0]);
    // Speeds, lengths, stresses.
    assert_eq!([there[3][3], there[3][6], there[3][8]], [0.15, 0.8, 5e-4]);
    layers.go_on(&there, 3);
    assert_eq!(layers.saved_for([2.0, 0.5]), [one; 4]);
}
