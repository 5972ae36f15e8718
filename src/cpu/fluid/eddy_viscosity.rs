//! Stage `eddy_viscosity`: the eddy part of every cell's relaxation time, 3 ν_t, from the velocity gradient of its neighbours
//! ([`crate::lattice::eddy_viscosity`]), for the steps until it is evaluated again.
//!
//! Central differences of the bare velocity that the next collision will find; beyond a face stands what the boundary condition puts
//! there. Velocities of three planes are kept at a time, so that nothing is stored per cell but the result.

use std::ops::Range;

use pulp::{Simd, WithSimd};
use rayon::prelude::*;

use super::{Fluid, Stored};
use crate::lattice::eddy_viscosity::{GradientModel, vreman, wale};
use crate::lattice::grid::{Beyond, beyond};
use crate::lattice::operators::{Populations, bare_moments, scale};
use crate::lattice::{DIRECTION_COUNT, Lanes, Number, Real};

/// Most planes that a thread takes at once; every slab reads two planes more.
const SLAB_PLANES: usize = 32;

impl<T: Real, P: Stored<Real = T>> Fluid<P> {
    /// Stage `eddy_viscosity` before the step to come; does nothing where no model needs it, where it is not due, or done.
    pub fn eddy_viscosity(&mut self) {
        let Some(held) = &self.held_eddy_viscosity else {
            return;
        };
        if !self.steps.is_multiple_of(held.every) || held.evaluated == Some(self.steps) {
            return;
        }
        let Some(mut held) = self.held_eddy_viscosity.take() else {
            return;
        };
        let [nx, ny, nz] = self.setup.cells;
        let planes = nz
            .div_ceil(rayon::current_num_threads())
            .clamp(1, SLAB_PLANES);
        let faces = beyond(&self.setup, self.inlet_velocity);
        let (model, factor) = (held.model, held.factor);
        held.relaxation_times
            .par_chunks_mut(planes * nx * ny)
            .enumerate()
            .for_each(|(slab, relaxation_times)| {
                self.instructions.dispatch(EvaluateSlab {
                    fluid: self,
                    faces: &faces,
                    model,
                    factor,
                    first_plane: slab * planes,
                    relaxation_times,
                    room: P::room(DIRECTION_COUNT * nx),
                });
            });
        held.evaluated = Some(self.steps);
        self.held_eddy_viscosity = Some(held);
    }

    /// Eddy viscosity ν_t of every cell as the stage of that name left it, x fastest, `[cell_count]`; `None` where no model needs the stage.
    #[must_use]
    pub fn eddy_viscosities(&self) -> Option<Vec<f64>> {
        let held = self.held_eddy_viscosity.as_ref()?;
        Some(
            held.relaxation_times
                .iter()
                .map(|time| time.to_f64() / 3.0)
                .collect(),
        )
    }

    /// Velocity of the cells of a row, component by component.
    #[inline(always)]
    fn row_velocity<S: Simd>(
        &self,
        simd: S,
        y: usize,
        z: usize,
        out: [&mut [T]; 3],
        room: &mut [T],
    ) {
        let index = self.grid.index([0, y as i64, z as i64]);
        let nx = self.setup.cells[0];
        let mut vectors: [&[T::Vector<S>]; DIRECTION_COUNT] = [&[]; DIRECTION_COUNT];
        let mut parts: [&[T]; DIRECTION_COUNT] = [&[]; DIRECTION_COUNT];
        let mut rooms = room.chunks_exact_mut(nx);
        for direction in 0..DIRECTION_COUNT {
            let (array, first) = self.grid.slot(index, direction, self.odd);
            let kept = &self.populations[array][first..first + nx];
            let values = P::values(kept, rooms.next().unwrap_or_default());
            (vectors[direction], parts[direction]) = T::vectors::<S>(values);
        }
        let zero = Lanes::<S, T>::splat(simd, T::default());
        let [x, y, z] = out;
        let (x, y, z) = (
            T::vectors_mut::<S>(x),
            T::vectors_mut::<S>(y),
            T::vectors_mut::<S>(z),
        );
        for i in 0..vectors[0].len() {
            let mut f = [zero; DIRECTION_COUNT];
            for direction in 0..DIRECTION_COUNT {
                f[direction] = Lanes::new(simd, vectors[direction][i]);
            }
            let u = velocity(&f);
            x.0[i] = u[0].vector;
            y.0[i] = u[1].vector;
            z.0[i] = u[2].vector;
        }
        if !parts[0].is_empty() {
            let mut f = [zero; DIRECTION_COUNT];
            for direction in 0..DIRECTION_COUNT {
                f[direction] = Lanes::new(simd, T::load_part(simd, parts[direction]));
            }
            let u = velocity(&f);
            T::store_part(simd, x.1, u[0].vector);
            T::store_part(simd, y.1, u[1].vector);
            T::store_part(simd, z.1, u[2].vector);
        }
    }
}

/// Bare velocity of the cells of a vector.
#[inline(always)]
fn velocity<N: Number>(f: &Populations<N>) -> [N; 3] {
    let (excess, momentum) = bare_moments(f);
    let one = excess.constant(1.0);
    scale(one / (one + excess), momentum)
}

/// Velocities of a plane of cells with one layer of ghosts around it, component by component.
#[derive(Debug, Clone)]
struct Plane<T> {
    components: [Vec<T>; 3],
    /// Cells along x and y.
    cells: [usize; 2],
}

impl<T: Real> Plane<T> {
    fn new(cells: [usize; 2]) -> Self {
        let length = (cells[0] + 2) * (cells[1] + 2);
        Self {
            components: std::array::from_fn(|_| vec![T::default(); length]),
            cells,
        }
    }

    const fn stride(&self) -> usize {
        self.cells[0] + 2
    }

    /// Elements of the cells of a row.
    const fn row(&self, y: usize) -> Range<usize> {
        let first = (y + 1) * self.stride() + 1;
        first..first + self.cells[0]
    }

    /// Fills in the ghosts that the cells of a row have their velocity gradient from.
    fn fill_ghosts(&mut self, faces: &[[Beyond; 2]; 3]) {
        let [nx, ny] = self.cells;
        for y in 0..ny {
            let row = self.row(y);
            for (ghost, nearest, opposite, face) in [
                (
                    row.start - 1,
                    [row.start, row.start + 1],
                    row.end - 1,
                    faces[0][0],
                ),
                (row.end, [row.end - 1, row.end - 2], row.start, faces[0][1]),
            ] {
                self.fill_ghost(ghost, nearest, opposite, face);
            }
        }
        let (first, last) = (self.row(0).start, self.row(ny - 1).start);
        let stride = self.stride();
        for (ghost, nearest, opposite, face) in [
            (first - stride, [first, first + stride], last, faces[1][0]),
            (last + stride, [last, last - stride], first, faces[1][1]),
        ] {
            for x in 0..nx {
                self.fill_ghost(ghost + x, nearest.map(|n| n + x), opposite + x, face);
            }
        }
    }

    /// From the two cells nearest to the face.
    fn fill_ghost(
        &mut self,
        ghost: usize,
        [at_face, next]: [usize; 2],
        opposite: usize,
        face: Beyond,
    ) {
        for (a, component) in self.components.iter_mut().enumerate() {
            component[ghost] = match face {
                Beyond::Periodic => component[opposite],
                Beyond::Ghost { factor, offset } => {
                    T::of(factor[a]) * component[at_face] + T::of(offset[a])
                }
                Beyond::Extrapolated => {
                    let here = component[at_face];
                    here + (here - component[next])
                }
            };
        }
    }
}

/// The work on a run of planes, compiled once per instruction set.
struct EvaluateSlab<'a, P: Stored> {
    fluid: &'a Fluid<P>,
    faces: &'a [[Beyond; 2]; 3],
    model: GradientModel,
    factor: f64,
    first_plane: usize,
    /// Of the cells of these planes.
    relaxation_times: &'a mut [P::Real],
    /// Of a row's populations.
    room: Vec<P::Real>,
}

impl<T: Real, P: Stored<Real = T>> WithSimd for EvaluateSlab<'_, P> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(mut self, simd: S) {
        let [nx, ny, _] = self.fluid.setup.cells;
        let mut planes: [Plane<T>; 3] = std::array::from_fn(|_| Plane::new([nx, ny]));
        let first = self.first_plane as i64;
        self.fill_plane(simd, first - 1, &mut planes[1]);
        self.fill_plane(simd, first, &mut planes[2]);
        for z in 0..self.relaxation_times.len() / (nx * ny) {
            planes.rotate_left(1);
            self.fill_plane(simd, first + z as i64 + 1, &mut planes[2]);
            for y in 0..ny {
                let start = (z * ny + y) * nx;
                let out = &mut self.relaxation_times[start..start + nx];
                evaluate_row(simd, &planes, y, self.model, self.factor, out);
            }
        }
    }
}

impl<T: Real, P: Stored<Real = T>> EvaluateSlab<'_, P> {
    /// Velocities of the cells of plane z.
    #[inline(always)]
    fn read_plane<S: Simd>(&mut self, simd: S, z: usize, plane: &mut Plane<T>) {
        for y in 0..self.fluid.setup.cells[1] {
            let row = plane.row(y);
            let out = plane.components.each_mut().map(|c| &mut c[row.clone()]);
            self.fluid.row_velocity(simd, y, z, out, &mut self.room);
            let Some(ends) = &self.fluid.exchanged_ends else {
                continue;
            };
            // What has arrived at the ends of a box's rows is not in place yet.
            let nx = row.len();
            for x in [0, 1, nx - 2, nx - 1] {
                if let Some(f) = ends.waiting_at([x, y, z]) {
                    let u = velocity(&f);
                    for (component, u) in plane.components.iter_mut().zip(u) {
                        component[row.start + x] = u;
                    }
                }
            }
        }
    }

    /// Velocities of plane z, which may lie one beyond the faces.
    #[inline(always)]
    fn fill_plane<S: Simd>(&mut self, simd: S, z: i64, plane: &mut Plane<T>) {
        let nz = self.fluid.setup.cells[2];
        let last = nz as i64 - 1;
        let at_face = z.clamp(0, last);
        let face = self.faces[2][usize::from(z > last)];
        let origin = match face {
            Beyond::Periodic => z.rem_euclid(nz as i64),
            Beyond::Ghost { .. } | Beyond::Extrapolated => at_face,
        };
        self.read_plane(simd, origin as usize, plane);
        if matches!(face, Beyond::Extrapolated) && z != at_face {
            let mut next = plane.clone();
            self.read_plane(simd, (2 * at_face - z) as usize, &mut next);
            for (component, next) in plane.components.iter_mut().zip(&next.components) {
                for (u, next) in component.iter_mut().zip(next) {
                    *u = *u + (*u - *next);
                }
            }
        }
        if let Beyond::Ghost { factor, offset } = face
            && z != at_face
        {
            for (a, component) in plane.components.iter_mut().enumerate() {
                let (factor, offset) = (T::of(factor[a]), T::of(offset[a]));
                for u in component {
                    *u = factor * *u + offset;
                }
            }
        }
        plane.fill_ghosts(self.faces);
    }
}

/// Velocities below and above along every axis, component by component.
type Neighbours<'a, V> = [[[&'a [V]; 3]; 2]; 3];

/// 3 ν_t of the cells of a row of the middle plane.
#[inline(always)]
fn evaluate_row<S: Simd, T: Real>(
    simd: S,
    planes: &[Plane<T>; 3],
    y: usize,
    model: GradientModel,
    factor: f64,
    out: &mut [T],
) {
    let row = planes[1].row(y);
    let stride = planes[1].stride();
    // Below and above along x, y, z.
    let neighbours = [
        [(1, row.start - 1), (1, row.start + 1)],
        [(1, row.start - stride), (1, row.start + stride)],
        [(0, row.start), (2, row.start)],
    ];
    let mut vectors: Neighbours<T::Vector<S>> = [[[&[]; 3]; 2]; 3];
    let mut parts: Neighbours<T> = [[[&[]; 3]; 2]; 3];
    for (axis, sides) in neighbours.into_iter().enumerate() {
        for (side, (plane, first)) in sides.into_iter().enumerate() {
            for (a, component) in planes[plane].components.iter().enumerate() {
                (vectors[axis][side][a], parts[axis][side][a]) =
                    T::vectors::<S>(&component[first..first + row.len()]);
            }
        }
    }
    let zero = Lanes::<S, T>::splat(simd, T::default());
    let (whole, rest) = T::vectors_mut::<S>(out);
    for i in 0..whole.len() {
        let mut gradient = [[zero; 3]; 3];
        for axis in 0..3 {
            for a in 0..3 {
                let [below, above] = [vectors[axis][0][a][i], vectors[axis][1][a][i]];
                gradient[axis][a] = difference(Lanes::new(simd, below), Lanes::new(simd, above));
            }
        }
        whole[i] = relaxation_time(&gradient, model, factor).vector;
    }
    if !rest.is_empty() {
        let mut gradient = [[zero; 3]; 3];
        for axis in 0..3 {
            for a in 0..3 {
                let below = T::load_part(simd, parts[axis][0][a]);
                let above = T::load_part(simd, parts[axis][1][a]);
                gradient[axis][a] = difference(Lanes::new(simd, below), Lanes::new(simd, above));
            }
        }
        let value = relaxation_time(&gradient, model, factor).vector;
        T::store_part(simd, rest, value);
    }
}

/// Central difference.
#[inline(always)]
fn difference<N: Number>(below: N, above: N) -> N {
    below.constant(0.5) * (above - below)
}

/// 3 ν_t.
#[inline(always)]
fn relaxation_time<N: Number>(gradient: &[[N; 3]; 3], model: GradientModel, factor: f64) -> N {
    let value = match model {
        GradientModel::Wale => wale(gradient),
        GradientModel::Vreman => vreman(gradient),
    };
    value.constant(factor) * value
}
