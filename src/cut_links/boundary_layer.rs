//! Boundary layers that the cells do not hold: the shear stress that a wall along which the air slides gets from a model.
//!
//! Every face of every triangle carries the velocity of the air two to three cells off and its speed five to six cells off. It carries the momentum thickness θ of the layer there. Between a face and those
//! upstream of it, a distance s along the flow apart, von Kármán's momentum integral holds. U is the speed beside the layer, the larger of the two:
//!
//! * laminar: θ² U⁶ grows by 0.45 ν ∫U⁵ ds (Thwaites 1949, doi:10.1017/S0001925900000184);
//! * turbulent, with a shape factor of 1.5 and c_f = 0.0177 (U θ/ν)^(−1/5): θ^(6/5) U⁴ (U/ν)^(1/5) grows by 0.0106 ∫U⁴ ds;
//!
//! U linear in between. A layer begins with θ = 0 at a rim, where air flows over it onto the face, and where the flow parts at a stagnation line. It is turbulent where U θ/ν
//! exceeds 0.664 √Re, Re the length of run at which a layer along a flat plate turns (`coupling.transition_reynolds`).
//!
//! The stress follows from the velocity u at the distance y, or at the edge δ of a layer that is thinner than that:
//!
//! * turbulent, δ = 72/7 θ: Reichardt's law u = u_τ (ln(1 + κ y⁺)/κ + 7.8 (1 − e^(−y⁺/11) − y⁺/11 e^(−y⁺/3))), κ = 0.41 (Reichardt 1951, doi:10.1002/zamm.19510310704);
//! * laminar: l(λ) ν U/θ with Thwaites' l, λ = θ²/ν dU/ds; in a layer thicker than the further distance the speed there is taken over Pohlhausen's profile.
//!
//! The layers march in every fourth step of the air; in between the stress stays.
//!
//! *Departure*: wall models of large-eddy simulations suppose that y lies inside the layer. Here the layer is mostly thinner than a cell, and a law of the wall alone would give it the
//! friction of one as thick as y. By arithmetic, that is some 40 % less on a plate of 16 cells at Re = 10⁵.

use glam::DVec3;
use rayon::prelude::*;

use super::spaces::Spaces;

/// Steps of the air from one march of the layers, by a triangle, to the next. Where triangles are a cell long, they march twice as fast as the air or faster.
const STEPS_OF_A_MARCH: u64 = 4;

/// Share that a face takes, in a march, of the velocity that its links see now.
const NEW_SHARE: f64 = 0.3;

/// Thickness of a laminar layer over its momentum thickness, Pohlhausen's 5.84/0.686.
const LAMINAR_THICKNESS: f64 = 8.5;
/// The same of the profile u ∝ y^(1/7).
const TURBULENT_THICKNESS: f64 = 72.0 / 7.0;

/// Momentum thickness of a laminar layer along a flat plate over x, times √Re_x (Blasius).
const BLASIUS: f64 = 0.664;

/// Thwaites' parameter is taken between separation and where his table ends.
const PRESSURE_GRADIENTS: [f64; 2] = [-0.09, 0.1];

/// Smallest momentum thickness [cells]: a triangle without area has none upstream.
const THINNEST: f64 = 1e-4;

/// Fastest flow upstream over that on a face that a layer is carried from: beyond, it has come to rest.
const FASTEST_UPSTREAM: f64 = 10.0;

/// Largest momentum thickness over the extent of the surface: a layer that goes round in a wake does not grow without end.
const THICKEST: f64 = 0.1;

/// Most of the velocity beside the wall that a step's stress takes from a cell; layers of interest take a thousandth.
const MOST_OF_VELOCITY: f64 = 0.1;

const KARMAN: f64 = 0.41;

/// Faces that work in one task.
const FACES_AT_ONCE: usize = 512;

/// A face of a triangle: twice the triangle's number, plus 1 behind its normal.
pub type Face = usize;

/// What the links of a face see of the air beside it, in the mean.
#[derive(Debug, Clone, Copy, Default)]
pub struct Seen {
    /// Velocity of the air beyond that of the wall, near it and further off [cells per step].
    pub velocities: [DVec3; 2],
    /// Distances of both places from the wall [cells].
    pub heights: [f64; 2],
}

/// State of the layer on one face.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
struct Layer {
    /// Velocity of the air beyond that of the wall, near it [cells per step].
    velocity: DVec3,
    /// Its speed further off [cells per step].
    further_speed: f64,
    /// Distances from the wall of where they were taken; 0 before anything was [cells].
    heights: [f64; 2],
    /// Momentum thickness θ [cells].
    thickness: f64,
    /// From the air to the wall [density × cells² per step²].
    stress: DVec3,
}

impl Layer {
    /// True once a link saw the air.
    fn known(&self) -> bool {
        self.heights[0] > 0.0
    }

    /// Speed at the edge of the layer: the larger of those at the nearer and the further distance, since a thick layer slows the air at the nearer one. The layer's own profile is not
    /// used for it: the speed decides the thickness, and thicknesses of neighbouring faces would swing between nothing and the largest.
    fn edge_speed(&self) -> f64 {
        self.velocity.length().max(self.further_speed)
    }
}

/// Numbers of one face in a checkpoint: velocity near, speed further off, both heights, momentum thickness, stress.
pub type Saved = [f64; 10];

/// Layers on the faces of a surface, in lattice units.
#[derive(Debug, Clone)]
pub struct BoundaryLayers {
    /// Of the triangles.
    modelled: Vec<bool>,
    viscosity: f64,
    /// U θ/ν at which a layer turns turbulent; negative: everywhere.
    transition: f64,
    layers: Vec<Layer>,
    /// Those before, while they march.
    before: Vec<Layer>,
    /// Steps of the air until the layers march again.
    steps_left: u64,
}

/// Where the triangles are.
#[derive(Debug, Clone, Copy)]
pub struct Shape<'a> {
    /// Nodes of all triangles.
    pub triangles: &'a [[u32; 3]],
    /// Places of the nodes [cells].
    pub positions: &'a [DVec3],
    /// Unit normals of the triangles.
    pub normals: &'a [DVec3],
    /// Which faces follow each other.
    pub spaces: &'a Spaces,
}

impl BoundaryLayers {
    /// On the triangles that are `modelled`, in air of this kinematic viscosity [cells² per step]. Along a flat plate layers turn turbulent at the Reynolds number `transition_reynolds` of the
    /// length of run. `None` where no triangle is.
    #[must_use]
    pub fn new(modelled: Vec<bool>, viscosity: f64, transition_reynolds: f64) -> Option<Self> {
        let faces = 2 * modelled.len();
        modelled.contains(&true).then(|| Self {
            modelled,
            viscosity,
            transition: if transition_reynolds > 0.0 {
                BLASIUS * transition_reynolds.sqrt()
            } else {
                -1.0
            },
            layers: vec![Layer::default(); faces],
            before: Vec::new(),
            steps_left: 0,
        })
    }

    /// Counts a step of the air; true where the layers march in it.
    pub fn count_step(&mut self) -> bool {
        let marches = self.steps_left == 0;
        self.steps_left = if marches {
            STEPS_OF_A_MARCH - 1
        } else {
            self.steps_left - 1
        };
        marches
    }

    /// Stress on a face, from the air to the wall [density × cells² per step²]; none where no layer is modelled.
    #[must_use]
    pub fn stress(&self, face: Face) -> DVec3 {
        self.layers[face].stress
    }

    /// Momentum thickness of the layer on a face [cells].
    #[must_use]
    pub fn momentum_thickness(&self, face: Face) -> f64 {
        self.layers[face].thickness
    }

    /// Takes what the links of faces have `seen`, if they have any, and marches by one triangle.
    pub fn march(&mut self, shape: Shape<'_>, seen: impl Fn(Face) -> Option<Seen> + Sync) {
        self.take(shape, seen);
        self.grow(shape);
    }

    fn take(&mut self, shape: Shape<'_>, seen: impl Fn(Face) -> Option<Seen> + Sync) {
        std::mem::swap(&mut self.layers, &mut self.before);
        self.layers.resize(self.before.len(), Layer::default());
        let (before, modelled) = (&self.before, &self.modelled);
        (self.layers.par_iter_mut().enumerate())
            .with_min_len(FACES_AT_ONCE)
            .for_each(|(face, layer)| {
                *layer = before[face];
                if !modelled[face / 2] {
                    return;
                }
                let normal = shape.normals[face / 2];
                let along = |velocity: DVec3| velocity - normal * normal.dot(velocity);
                let (velocity, further_speed, heights);
                if let Some(seen) = seen(face) {
                    velocity = along(seen.velocities[0]);
                    further_speed = along(seen.velocities[1]).length();
                    heights = seen.heights;
                } else {
                    // No link cuts a triangle that is smaller than a cell: what those about it saw.
                    let (mut of_all, mut count) = (Layer::default(), 0.0);
                    for other in shape.spaces.beside(face).into_iter().flatten() {
                        let other = &before[other as usize];
                        if other.known() {
                            of_all.velocity += other.velocity;
                            of_all.further_speed += other.further_speed;
                            for k in 0..2 {
                                of_all.heights[k] += other.heights[k];
                            }
                            count += 1.0;
                        }
                    }
                    if count == 0.0 {
                        return;
                    }
                    velocity = along(of_all.velocity / count);
                    further_speed = of_all.further_speed / count;
                    heights = of_all.heights.map(|height| height / count);
                }
                let new = if layer.known() { NEW_SHARE } else { 1.0 };
                layer.velocity += (velocity - layer.velocity) * new;
                layer.further_speed += (further_speed - layer.further_speed) * new;
                for k in 0..2 {
                    layer.heights[k] += (heights[k] - layer.heights[k]) * new;
                }
            });
    }

    fn grow(&mut self, shape: Shape<'_>) {
        self.before.clone_from(&self.layers);
        let (before, modelled) = (&self.before, &self.modelled);
        let nodes = (shape.triangles.iter().zip(modelled))
            .filter(|(_, modelled)| **modelled)
            .flat_map(|(nodes, _)| nodes);
        let (low, high) = nodes.fold(
            (DVec3::INFINITY, DVec3::NEG_INFINITY),
            |(low, high), &node| {
                let position = shape.positions[node as usize];
                (low.min(position), high.max(position))
            },
        );
        let thickest = (THICKEST * (high - low).length()).max(THINNEST);
        let (viscosity, transition) = (self.viscosity, self.transition);
        (self.layers.par_iter_mut().enumerate())
            .with_min_len(FACES_AT_ONCE)
            .for_each(|(face, layer)| {
                let speed = layer.velocity.length();
                if !modelled[face / 2] || !layer.known() || speed == 0.0 {
                    layer.stress = DVec3::ZERO;
                    return;
                }
                let upstream = upstream(face, layer, (before, modelled), shape);
                let grown = grown(&upstream, layer.edge_speed(), (viscosity, transition));
                layer.thickness = grown.thickness.clamp(THINNEST, thickest);
                let of_wall = if grown.turbulent {
                    turbulent_stress(layer, viscosity)
                } else {
                    laminar_stress(layer, (viscosity, grown.gradient))
                };
                layer.stress = layer.velocity * (of_wall / speed).min(MOST_OF_VELOCITY);
            });
    }

    /// What a checkpoint keeps of the faces.
    #[must_use]
    pub fn saved(&self) -> Vec<Saved> {
        let numbers = |layer: &Layer| {
            let ([u, v, w], [x, y, z]) = (layer.velocity.to_array(), layer.stress.to_array());
            let [near, further] = layer.heights;
            let Layer {
                further_speed,
                thickness,
                ..
            } = *layer;
            [u, v, w, further_speed, near, further, thickness, x, y, z]
        };
        self.layers.iter().map(numbers).collect()
    }

    /// The same on a lattice whose speeds and lengths are so many times as large in numbers.
    #[must_use]
    pub fn saved_for(&self, [speed, length]: [f64; 2]) -> Vec<Saved> {
        let stress = speed * speed;
        let scales = [
            speed, speed, speed, speed, length, length, length, stress, stress, stress,
        ];
        let scaled = |numbers: Saved| std::array::from_fn(|i| numbers[i] * scales[i]);
        self.saved().into_iter().map(scaled).collect()
    }

    /// Steps of the air until the layers march again.
    #[must_use]
    pub const fn steps_left(&self) -> u64 {
        self.steps_left
    }

    /// Goes on from them.
    pub fn go_on(&mut self, saved: &[Saved], steps_left: u64) {
        self.steps_left = steps_left;
        for (layer, saved) in self.layers.iter_mut().zip(saved) {
            let &[u, v, w, further_speed, near, further, thickness, x, y, z] = saved;
            *layer = Layer {
                velocity: DVec3::new(u, v, w),
                further_speed,
                heights: [near, further],
                thickness,
                stress: DVec3::new(x, y, z),
            };
        }
    }
}

/// What flows onto a face over one of its edges.
#[derive(Debug, Clone, Copy, Default)]
struct Inflow {
    /// Share of all.
    share: f64,
    /// Velocity beside the layer there, and its momentum thickness.
    speed: f64,
    thickness: f64,
    /// Distance along the flow [cells].
    distance: f64,
}

fn upstream(
    face: Face,
    layer: &Layer,
    (before, modelled): (&[Layer], &[bool]),
    shape: Shape<'_>,
) -> [Inflow; 3] {
    let middle = |face: Face| {
        let [a, b, c] = shape.triangles[face / 2].map(|node| shape.positions[node as usize]);
        (a + b + c) / 3.0
    };
    let (own, normal) = (middle(face), shape.normals[face / 2]);
    let (speed, along) = (layer.edge_speed(), layer.velocity.normalize_or_zero());
    let corners = shape.triangles[face / 2].map(|node| shape.positions[node as usize]);
    let mut inflows = [Inflow::default(); 3];
    let mut all = 0.0;
    for (k, inflow) in inflows.iter_mut().enumerate() {
        let (from, to) = (corners[k], corners[(k + 1) % 3]);
        // Out of the triangle, as long as the edge; `normal` is that of the order of its corners.
        let out = (to - from).cross(normal);
        let flux = -out.dot(along);
        if flux <= 0.0 {
            continue;
        }
        all += flux;
        let edge = 0.5 * (from + to);
        let other = shape.spaces.beside(face)[k].map(|other| other as usize);
        *inflow = match other.filter(|&other| modelled[other / 2] && before[other].known()) {
            // The layer begins here; beyond a rim the stream is as fast as on the face.
            None => Inflow {
                share: flux,
                speed,
                thickness: 0.0,
                distance: (own - edge).dot(along).max(0.0),
            },
            Some(other) => {
                let there = &before[other];
                let their = there.velocity.normalize_or_zero();
                if outflow(other, [from, to], their, shape) <= 0.0 {
                    // It flows away from there, too: the flow parts at the edge.
                    Inflow {
                        share: flux,
                        speed: 0.0,
                        thickness: 0.0,
                        distance: (own - edge).dot(along).max(0.0),
                    }
                } else {
                    Inflow {
                        share: flux,
                        speed: there.edge_speed(),
                        thickness: there.thickness,
                        // Along both faces, which may meet at an angle.
                        distance: ((own - edge).dot(along) + their.dot(edge - middle(other)))
                            .max(0.0),
                    }
                }
            }
        };
    }
    for inflow in &mut inflows {
        inflow.share /= all.max(f64::MIN_POSITIVE);
    }
    inflows
}

/// What flows out of a face over the edge between two places that it shares, in the direction `along`, over that with unit speed [cells].
fn outflow(face: Face, [from, to]: [DVec3; 2], along: DVec3, shape: Shape<'_>) -> f64 {
    let corners = shape.triangles[face / 2].map(|node| shape.positions[node as usize]);
    let out = (to - from).cross(shape.normals[face / 2]);
    // Away from the corner that is not on the edge: the one whose distance from its line is largest.
    let third = corners.into_iter().fold(0.0, |most: f64, corner| {
        let beside = (corner - from).dot(out);
        if beside.abs() > most.abs() {
            beside
        } else {
            most
        }
    });
    if third < 0.0 {
        out.dot(along)
    } else {
        -out.dot(along)
    }
}

#[derive(Debug, Clone, Copy)]
struct Grown {
    thickness: f64,
    turbulent: bool,
    /// dU/ds [1/step].
    gradient: f64,
}

/// Mean of the power `n` of a velocity that is linear between `a` and `b`: (bⁿ + bⁿ⁻¹ a + … + aⁿ)/(n + 1).
fn mean_power(a: f64, b: f64, n: i32) -> f64 {
    let (mut sum, mut power) = (1.0, 1.0);
    for _ in 0..n {
        power *= b;
        sum = sum * a + power;
    }
    sum / f64::from(n + 1)
}

/// The layer on a face at whose edge the air has `speed`, from those upstream.
fn grown(upstream: &[Inflow; 3], speed: f64, (viscosity, transition): (f64, f64)) -> Grown {
    let inflows = || upstream.iter().filter(|from| from.share > 0.0);
    let ratio = |from: &Inflow| (from.speed / speed).min(FASTEST_UPSTREAM);
    let (mut laminar, mut faster, mut farther) = (0.0, 0.0, 0.0);
    for from in inflows() {
        let ratio = ratio(from);
        laminar += from.share
            * (from.thickness.powi(2) * ratio.powi(6)
                + 0.45 * viscosity / speed * mean_power(ratio, 1.0, 5) * from.distance);
        faster += from.share * (speed - from.speed);
        farther += from.share * from.distance;
    }
    let gradient = if farther > 0.0 { faster / farther } else { 0.0 };
    let laminar: f64 = laminar.sqrt();
    let is_turbulent = speed * laminar / viscosity > transition;
    if !is_turbulent {
        return Grown {
            thickness: laminar,
            turbulent: false,
            gradient,
        };
    }
    let power = 0.2;
    let friction = 0.0106 * (viscosity / speed).powf(power);
    let mut turbulent: f64 = 0.0;
    for from in inflows() {
        let ratio = ratio(from);
        turbulent += from.share
            * (from.thickness.powf(1.0 + power) * ratio.powf(4.0 + power)
                + friction * mean_power(ratio, 1.0, 4) * from.distance);
    }
    Grown {
        thickness: turbulent.powf(1.0 / 1.2),
        turbulent: true,
        gradient,
    }
}

/// Reichardt's law and its slope over y⁺.
fn reichardt(y: f64) -> [f64; 2] {
    let (far, near) = ((-y / 11.0).exp(), (-y / 3.0).exp());
    [
        (1.0 + KARMAN * y).ln() / KARMAN + 7.8 * (1.0 - far - y / 11.0 * near),
        1.0 / (1.0 + KARMAN * y) + 7.8 * (far / 11.0 + near * (y / 33.0 - 1.0 / 11.0)),
    ]
}

/// Steps of Newton's method for u_τ: from the power law's they leave 2e-6 of it, at Reynolds numbers of 0.01 to 10⁸.
const NEWTON_STEPS: usize = 2;

/// u_τ² of a turbulent layer.
fn turbulent_stress(layer: &Layer, viscosity: f64) -> f64 {
    let speed = layer.velocity.length();
    let thickness = TURBULENT_THICKNESS * layer.thickness;
    let height = layer.heights[0].min(thickness).max(f64::MIN_POSITIVE);
    let reynolds = speed * height / viscosity;
    // Blasius' law of friction, or the straight profile.
    let mut friction = speed * (0.0225 * reynolds.powf(-0.25)).max(1.0 / reynolds).sqrt();
    for _ in 0..NEWTON_STEPS {
        let y = height * friction / viscosity;
        let [law, slope] = reichardt(y);
        friction -= (friction * law - speed) / (law + y * slope);
    }
    friction * friction
}

/// Thwaites' shear function.
fn thwaites(lambda: f64) -> f64 {
    if lambda >= 0.0 {
        0.22 + lambda * (1.57 - 1.8 * lambda)
    } else {
        0.22 + 1.402 * lambda + 0.018 * lambda / (0.107 + lambda)
    }
}

fn laminar_stress(layer: &Layer, (viscosity, gradient): (f64, f64)) -> f64 {
    let thickness = layer.thickness.max(f64::MIN_POSITIVE);
    let lambda = thickness * thickness / viscosity * gradient;
    let lambda = lambda.clamp(PRESSURE_GRADIENTS[0], PRESSURE_GRADIENTS[1]);
    // Speed outside a layer that is thicker than the further distance, by Pohlhausen's profile without pressure gradient.
    let part = (layer.heights[1] / (LAMINAR_THICKNESS * thickness)).min(1.0);
    let speed = layer.edge_speed() / (part * (2.0 + part * part * (part - 2.0)));
    // Where the layer is about to separate the table's fit passes zero.
    thwaites(lambda).max(0.0) * viscosity * speed / thickness
}

#[cfg(test)]
#[path = "boundary_layer_tests.rs"]
mod tests;
