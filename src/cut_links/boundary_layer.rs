//! Boundary layers that the cells do not hold: the shear stress that a wall along which the air slides gets from a model.
//!
//! Every face of every triangle carries the velocity of the air two to three cells off, and the momentum thickness θ of the layer there. Between a face and those upstream of it, a
//! distance s along the flow apart, von Kármán's momentum integral holds, with U the velocity beside the layer:
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
//! * laminar: l(λ) ν U/θ with Thwaites' l, λ = θ²/ν dU/ds; inside the layer U follows from u by Pohlhausen's profile without pressure gradient.
//!
//! *Departure*: wall models of large-eddy simulations suppose that y lies inside the layer. Here the layer is mostly thinner than a cell, and a law of the wall alone would give it the
//! friction of one as thick as y: by arithmetic, some 40 % less on a plate of 16 cells at Re = 10⁵.

use glam::DVec3;
use rayon::prelude::*;

use super::spaces::Spaces;

/// Share of a step that a face takes of the velocity that its links see now.
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

/// What a link sees of the air beside its face.
#[derive(Debug, Clone, Copy)]
pub struct Sample {
    /// Where.
    pub face: Face,
    /// Velocity of the air beyond that of the wall [cells per step].
    pub velocity: DVec3,
    /// Distance from the wall [cells].
    pub height: f64,
}

/// State of the layer on one face.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
struct Layer {
    /// Velocity of the air beyond that of the wall [cells per step].
    velocity: DVec3,
    /// Distance from the wall of where it was taken; 0 before anything was [cells].
    height: f64,
    /// Momentum thickness θ [cells].
    thickness: f64,
    /// That velocity over the one at the edge of the layer; 1 outside it.
    fullness: f64,
}

impl Layer {
    /// Velocity at the edge of the layer [cells per step].
    fn edge_speed(&self) -> f64 {
        self.velocity.length() / self.fullness
    }

    /// Velocity where it was taken over the one at the edge: by the seventh root, or Pohlhausen's profile.
    fn fullness_at(&self, turbulent: bool) -> f64 {
        if turbulent {
            let part = self.height / (TURBULENT_THICKNESS * self.thickness);
            return part.min(1.0).powf(1.0 / 7.0);
        }
        let part = (self.height / (LAMINAR_THICKNESS * self.thickness)).min(1.0);
        part * (2.0 + part * part * (part - 2.0))
    }
}

/// Numbers of one face in a checkpoint: velocity, height, momentum thickness, fullness.
pub type Saved = [f64; 6];

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
    sums: Vec<(DVec3, f64, f64)>,
    /// On every face, from the air to the wall [density × cells² per step²].
    stresses: Vec<DVec3>,
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
    /// On the triangles that are `modelled`, in air of this kinematic viscosity [cells² per step]; along a flat plate layers turn turbulent at the Reynolds number `transition_reynolds` of the
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
            sums: Vec::new(),
            stresses: vec![DVec3::ZERO; faces],
        })
    }

    /// Stress on a face, from the air to the wall [density × cells² per step²]; none where no layer is modelled.
    #[must_use]
    pub fn stress(&self, face: Face) -> DVec3 {
        self.stresses[face]
    }

    /// Momentum thickness of the layer on a face [cells].
    #[must_use]
    pub fn momentum_thickness(&self, face: Face) -> f64 {
        self.layers[face].thickness
    }

    /// Takes what the links of this step see, and marches by one triangle.
    pub fn step(&mut self, shape: Shape<'_>, samples: impl Iterator<Item = Sample>) {
        self.take(shape, samples);
        self.march(shape);
    }

    fn take(&mut self, shape: Shape<'_>, samples: impl Iterator<Item = Sample>) {
        self.sums.clear();
        self.sums.resize(self.layers.len(), (DVec3::ZERO, 0.0, 0.0));
        for sample in samples {
            let (velocity, height, count) = &mut self.sums[sample.face];
            *velocity += sample.velocity;
            *height += sample.height;
            *count += 1.0;
        }
        std::mem::swap(&mut self.layers, &mut self.before);
        self.layers.resize(self.before.len(), Layer::default());
        let (before, sums, modelled) = (&self.before, &self.sums, &self.modelled);
        (self.layers.par_iter_mut().zip(sums).enumerate())
            .with_min_len(FACES_AT_ONCE)
            .for_each(|(face, (layer, (velocity, height, count)))| {
                *layer = before[face];
                if !modelled[face / 2] {
                    return;
                }
                let (velocity, height) = if *count > 0.0 {
                    (*velocity / *count, *height / *count)
                } else {
                    // No link cuts a triangle that is smaller than a cell: what those about it see.
                    let about = (shape.spaces.beside(face).into_iter().flatten())
                        .map(|other| &before[other as usize])
                        .filter(|other| other.height > 0.0);
                    let (mut sum, mut height, mut count) = (DVec3::ZERO, 0.0, 0.0);
                    for other in about {
                        sum += other.velocity;
                        height += other.height;
                        count += 1.0;
                    }
                    if count == 0.0 {
                        return;
                    }
                    (sum / count, height / count)
                };
                let normal = shape.normals[face / 2];
                let along = velocity - normal * normal.dot(velocity);
                let new = if layer.height > 0.0 {
                    NEW_SHARE
                } else {
                    layer.fullness = 1.0;
                    1.0
                };
                layer.velocity += (along - layer.velocity) * new;
                layer.height += (height - layer.height) * new;
            });
    }

    fn march(&mut self, shape: Shape<'_>) {
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
        (self
            .layers
            .par_iter_mut()
            .zip(&mut self.stresses)
            .enumerate())
        .with_min_len(FACES_AT_ONCE)
        .for_each(|(face, (layer, stress))| {
            let speed = layer.velocity.length();
            if !modelled[face / 2] || layer.height == 0.0 || speed == 0.0 {
                *stress = DVec3::ZERO;
                return;
            }
            let upstream = upstream(face, layer, (before, modelled), shape);
            let grown = grown(&upstream, layer.edge_speed(), (viscosity, transition));
            layer.thickness = grown.thickness.clamp(THINNEST, thickest);
            // At once it would swing: θ falls with the third power of what is taken for the velocity at the edge.
            layer.fullness += NEW_SHARE * (layer.fullness_at(grown.turbulent) - layer.fullness);
            let of_wall = if grown.turbulent {
                turbulent_stress(layer, viscosity)
            } else {
                laminar_stress(layer, (viscosity, grown.gradient))
            };
            *stress = layer.velocity * (of_wall / speed).min(MOST_OF_VELOCITY);
        });
    }

    /// What a checkpoint keeps.
    #[must_use]
    pub fn saved(&self) -> Vec<Saved> {
        (self.layers.iter())
            .map(|layer| {
                let [x, y, z] = layer.velocity.to_array();
                [x, y, z, layer.height, layer.thickness, layer.fullness]
            })
            .collect()
    }

    /// Goes on from it.
    pub fn go_on(&mut self, saved: &[Saved]) {
        for (layer, &[x, y, z, height, thickness, fullness]) in self.layers.iter_mut().zip(saved) {
            *layer = Layer {
                velocity: DVec3::new(x, y, z),
                height,
                thickness,
                fullness,
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
        *inflow = match other.filter(|&other| modelled[other / 2] && before[other].height > 0.0) {
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
    (0..=n).map(|k| a.powi(k) * b.powi(n - k)).sum::<f64>() / f64::from(n + 1)
}

/// The layer on a face at whose edge the air has `speed`, from those upstream.
fn grown(upstream: &[Inflow; 3], speed: f64, (viscosity, transition): (f64, f64)) -> Grown {
    let (mut laminar, mut turbulent) = (0.0, 0.0);
    let (mut faster, mut farther) = (0.0, 0.0);
    for from in upstream.iter().filter(|from| from.share > 0.0) {
        let ratio = (from.speed / speed).min(FASTEST_UPSTREAM);
        laminar += from.share
            * (from.thickness.powi(2) * ratio.powi(6)
                + 0.45 * viscosity / speed * mean_power(ratio, 1.0, 5) * from.distance);
        let power = 0.2;
        turbulent += from.share
            * (from.thickness.powf(1.0 + power) * ratio.powf(4.0 + power)
                + 0.0106
                    * (viscosity / speed).powf(power)
                    * mean_power(ratio, 1.0, 4)
                    * from.distance);
        faster += from.share * (speed - from.speed);
        farther += from.share * from.distance;
    }
    let gradient = if farther > 0.0 { faster / farther } else { 0.0 };
    let laminar: f64 = laminar.sqrt();
    if speed * laminar / viscosity > transition {
        Grown {
            thickness: turbulent.powf(1.0 / 1.2),
            turbulent: true,
            gradient,
        }
    } else {
        Grown {
            thickness: laminar,
            turbulent: false,
            gradient,
        }
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

/// Steps of Newton's method for u_τ: from the power law's it needs three.
const NEWTON_STEPS: usize = 4;

/// u_τ² of a turbulent layer.
fn turbulent_stress(layer: &Layer, viscosity: f64) -> f64 {
    let speed = layer.velocity.length();
    let thickness = TURBULENT_THICKNESS * layer.thickness;
    let height = layer.height.min(thickness).max(f64::MIN_POSITIVE);
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
    // Where the layer is about to separate the table's fit passes zero.
    thwaites(lambda).max(0.0) * viscosity * layer.edge_speed() / thickness
}

#[cfg(test)]
#[path = "boundary_layer_tests.rs"]
mod tests;
