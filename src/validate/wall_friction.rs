//! Friction of a plate along the stream, whose boundary layer the cells do not hold: by the model of cut links, against Prandtl and Schlichting's law, and Blasius' where it is laminar.
//!
//! The plate is a sheet with air on both sides, turned in the lattice together with the stream. The box repeats. It is 3 × 2 lengths of the plate large, and the stream goes 2.5 lengths, of which the
//! last is judged: the wake has not come round by then, or has passed.

use glam::{DQuat, DVec3};

use super::flows::periodic;
use super::report::Gate;
use super::session::{Session, Stop};
use super::sliding_wall::step;
use crate::case::coupling::Friction;
use crate::lattice::Operator;
use crate::simulation::CutSurface;

/// Speed of the stream [cells per step].
const SPEED: f64 = 0.1;

/// Box, in lengths of the plate; cells across.
const BOX: [usize; 2] = [3, 2];
const ACROSS: usize = 4;

/// Lengths that the stream goes, and those of them, at the end, that are judged.
const LENGTHS: f64 = 2.5;
const JUDGED: f64 = 1.0;

/// Distance of the friction from the published law.
const BAND: f64 = 0.2;

/// A Reynolds number of the run at which nothing turns turbulent.
const LAMINAR: f64 = 1e9;

pub(super) fn compute(session: &mut Session) -> Result<(), Stop> {
    let all = [
        [1e5, 0.0],
        [1e5, 15.0],
        [1e5, 30.0],
        [1e6, 0.0],
        [1e6, 15.0],
        [1e6, 30.0],
        [1e7, 0.0],
        [1e7, 15.0],
        [1e7, 30.0],
    ];
    let some = [[1e5, 0.0], [1e6, 15.0], [1e7, 30.0]];
    for cells in session.size(&[16_usize, 32][..], &[16, 32, 64, 128]) {
        for [reynolds, turned_deg] in session.size(&some[..], &all) {
            let plate = Plate {
                cells: *cells,
                reynolds: *reynolds,
                turned_deg: *turned_deg,
            };
            let friction = plate.friction(session, Friction::Model, 0.0)?;
            let law = 0.455 / reynolds.log10().powf(2.58);
            let row = session.row(plate.grid(), plate.name("turbulent"), friction);
            row.reference(law, "Prandtl and Schlichting, 0.455/(log Re)^2.58")
                .gate(Gate::Within(BAND));
        }
    }
    for cells in session.size(&[32_usize][..], &[16, 32, 64, 128]) {
        let plate = Plate {
            cells: *cells,
            reynolds: 1e5,
            turned_deg: 15.0,
        };
        let friction = plate.friction(session, Friction::Model, LAMINAR)?;
        let law = 1.328 / plate.reynolds.sqrt();
        session
            .row(plate.grid(), plate.name("laminar"), friction)
            .reference(law, "Blasius, 1.328 Re^-1/2")
            .gate(Gate::Within(BAND));
        let friction = plate.friction(session, Friction::None, 0.0)?;
        session.row(plate.grid(), plate.name("the air slides"), friction);
        let friction = plate.friction(session, Friction::NoSlip, 0.0)?;
        session.row(plate.grid(), plate.name("the air sticks"), friction);
    }
    Ok(())
}

struct Plate {
    /// Along its length.
    cells: usize,
    /// Of its length.
    reynolds: f64,
    turned_deg: f64,
}

impl Plate {
    fn name(&self, what: &str) -> String {
        let Self {
            cells, turned_deg, ..
        } = self;
        let power = self.reynolds.log10();
        format!("plate of {cells} cells, Re 10^{power:.0}, turned {turned_deg}°, {what}: C_F")
    }

    fn grid(&self) -> [usize; 3] {
        [BOX[0] * self.cells, BOX[1] * self.cells, ACROSS]
    }

    /// Nodes, and triangles about a cell long.
    fn mesh(&self, along: DVec3) -> (Vec<DVec3>, Vec<[u32; 3]>) {
        let grid = self.grid();
        let length = self.cells as f64;
        // Its middle stands a third down the box, not on a cell's centre.
        let middle = DVec3::new(
            grid[0] as f64 / 3.0 + 0.37,
            0.5 * grid[1] as f64 - 0.31,
            -0.5,
        );
        let front = middle - along * (0.5 * length);
        let mut positions = Vec::new();
        for i in 0..=self.cells {
            positions.extend((0..=ACROSS).map(|j| front + along * i as f64 + DVec3::Z * j as f64));
        }
        let row = ACROSS as u32 + 1;
        let mut triangles = Vec::new();
        for i in 0..self.cells as u32 {
            for j in 0..ACROSS as u32 {
                let [a, b] = [i * row + j, (i + 1) * row + j];
                triangles.extend([[a, b, b + 1], [a, b + 1, a + 1]]);
            }
        }
        (positions, triangles)
    }

    /// Coefficient of friction of both sides, mean over the last of the lengths.
    fn friction(
        &self,
        session: &mut Session,
        friction: Friction,
        transition_reynolds: f64,
    ) -> Result<f64, Stop> {
        let length = self.cells as f64;
        let along = DQuat::from_rotation_z(self.turned_deg.to_radians()) * DVec3::X;
        let relaxation_time = 0.5 + 3.0 * SPEED * length / self.reynolds;
        let setup = periodic(
            self.grid(),
            relaxation_time,
            Operator::StabilisedRegularised,
        );
        let mut air = session.air(setup, &|_| (0.0, (along * SPEED).to_array()))?;
        let (positions, triangles) = self.mesh(along);
        let count = triangles.len();
        let mut surface = CutSurface::new(&air, triangles, positions.len(), (0, None))
            .with_friction(vec![friction; count], transition_reynolds, &positions);
        let steps = |lengths: f64| (lengths * length / SPEED) as usize;
        let (all, judged) = (steps(LENGTHS), steps(JUDGED));
        let mut drag = 0.0;
        for done in 0..all {
            let force = step(session, &mut air, &mut surface, &positions)?;
            if done + judged >= all {
                drag -= force.dot(along);
            }
        }
        let sides = 2.0 * length * ACROSS as f64;
        Ok(drag / (0.5 * SPEED * SPEED * sides * judged as f64))
    }
}
