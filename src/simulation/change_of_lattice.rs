//! A run that goes on on another lattice: finer or coarser cells (grid sequencing), or another time step.
//!
//! Fabric, cables, payload, falling box and time go on as they are, in SI units. The air's density excess and velocity are interpolated between
//! cell centres (trilinear; at the same cells they are taken over as they are), scaled so that pressure and velocity in SI units stay, and
//! populations begin at equilibrium plus the stress beyond it, interpolated and scaled as shear per step is ([`crate::lattice::start`]; made
//! from differences of the velocity instead, the drag was 18 % off after a change that changed nothing). The forces that the last
//! `spread` owes the air are owed on, in newtons: to the same markers, or by area to those of the same triangle. Since the bare velocity
//! of forced air is u − F/2ρ in each lattice's own units (Guo forcing), that shift is exchanged, too: without that, the layer of air
//! at the sheet starts with a jolt. What slip one pass leaves is proportional to the force and to the time step: after a longer step the drag is
//! lower for a while, which callers keep small by changing it little at a time. At cut links the pressures on both faces of the sheet, boundary layers
//! and the loads of the last step go on. Impulses since release go on; the mass balance of the momentum box begins anew.
//!
//! *Not kept*: moments beyond the stress, and the held eddy viscosity, which is evaluated anew; mass and momentum of the air to more than the
//! error of interpolation; and of the exchange with the structure the difference of one step's length times the force.

use std::collections::BTreeMap;

use glam::DVec3;

use super::kernel_coupling::at_marker;
use super::{AirEngine, ClothEngine, Coupled, Failure, Levels, Origin, Simulation};
use crate::case::Scene;
use crate::case::scene::Air;
use crate::cpu::cloth::Cloth;
use crate::immersed::kernel;
use crate::lattice::nest::Level;
use crate::lattice::start::Stress;
use crate::plan::{Plan, place_markers};
use crate::units::Units;

/// Density excess and bare velocity of every cell of a lattice, x fastest [lattice units].
struct Field {
    /// Corner of the lattice [m].
    corner_m: DVec3,
    cells: [usize; 3],
    /// Axes along which it spans the lattice around it.
    spans: [bool; 3],
    /// Its own scales.
    units: Units,
    states: Vec<(f32, [f32; 3])>,
    stresses: Vec<Stress>,
}

/// Corner [m] and scales of a level of the air.
fn scales(air: &Air, level: &Level) -> (DVec3, Units) {
    let across = air.finest_cells_across(level);
    let corner_m = DVec3::from_array(level.corner.map(|n| n as f64)) * air.units.cell_size_m;
    let units = Units {
        cell_size_m: across * air.units.cell_size_m,
        time_step_s: across * air.units.time_step_s,
        ..air.units
    };
    (corner_m, units)
}

/// Of every lattice, each before those in it.
fn read(engines: &Levels, air: &Air) -> Result<Vec<Field>, Failure> {
    let levels = air.levels();
    let read = |(engine, level): (&AirEngine, &Level)| {
        let (corner_m, units) = scales(air, level);
        Ok(Field {
            corner_m,
            cells: level.cells,
            spans: level.spans,
            units,
            states: engine.macroscopic()?,
            stresses: engine.stresses()?,
        })
    };
    engines
        .engines()
        .into_iter()
        .zip(&levels)
        .map(read)
        .collect()
}

impl Field {
    fn index(&self, cell: [usize; 3]) -> usize {
        cell[0] + self.cells[0] * (cell[1] + self.cells[1] * cell[2])
    }

    /// Adds half a step under the markers' forces: bare velocity to velocity.
    fn add_half(&mut self, forces: &[Force]) {
        for (index, half) in half_steps(forces, self.cells) {
            let (excess, velocity) = &mut self.states[index];
            for a in 0..3 {
                let gain = half[a] / (1.0 + f64::from(*excess));
                velocity[a] = (f64::from(velocity[a]) + gain) as f32;
            }
        }
    }

    /// A place in cells, cell centres at whole numbers.
    fn place(&self, place_m: DVec3) -> DVec3 {
        (place_m - self.corner_m) / self.units.cell_size_m - 0.5
    }

    /// True if a place lies between cell centres of the lattice. Of an axis that it spans it holds all: below it coarser cells are left out of steps.
    fn holds(&self, place_m: DVec3) -> bool {
        let place = self.place(place_m);
        (0..3).all(|a| self.spans[a] || (0.0..=(self.cells[a] - 1) as f64).contains(&place[a]))
    }

    /// Density excess, velocity and stress at a place, in the units of another lattice.
    fn at(&self, place_m: DVec3, units: &Units) -> (f64, [f64; 3], Stress) {
        let place = self.place(place_m);
        let below: [(usize, usize, f64); 3] = std::array::from_fn(|a| {
            let place = place[a].clamp(0.0, (self.cells[a] - 1) as f64);
            let first = place.floor() as usize;
            let second = (first + 1).min(self.cells[a] - 1);
            (first, second, place - first as f64)
        });
        let mut sums = [0.0; 4];
        let mut stress = [0.0; 6];
        for corner in 0..8_usize {
            let mut weight = 1.0;
            let place = std::array::from_fn(|a| {
                let (first, second, share) = below[a];
                if corner >> a & 1 == 0 {
                    weight *= 1.0 - share;
                    first
                } else {
                    weight *= share;
                    second
                }
            });
            if weight > 0.0 {
                let (excess, velocity) = self.states[self.index(place)];
                sums[0] += weight * f64::from(excess);
                for a in 0..3 {
                    sums[a + 1] += weight * f64::from(velocity[a]);
                }
                for (sum, component) in stress.iter_mut().zip(self.stresses[self.index(place)]) {
                    *sum += weight * f64::from(component);
                }
            }
        }
        let speed = self.units.speed_m_s() / units.speed_m_s();
        // Π = −(2/3) ρ τ S, and the shear S per step.
        let shear = units.time_step_s / self.units.time_step_s;
        let pressure = self.units.pressure_pa() / units.pressure_pa();
        (
            sums[0] * pressure,
            [sums[1] * speed, sums[2] * speed, sums[3] * speed],
            stress.map(|component| (component * shear) as f32),
        )
    }
}

/// Place of a marker and the force that it owes the air in the next step [cells, lattice units].
type Force = ([f64; 3], [f64; 3]);

/// Half of what forces give to each cell in a step, by the cell's number [lattice units].
fn half_steps(forces: &[Force], cells: [usize; 3]) -> BTreeMap<usize, [f64; 3]> {
    let mut sums = BTreeMap::new();
    for (position, force) in forces {
        let axes = position.map(kernel::weights);
        for z in 0..kernel::WIDTH {
            for y in 0..kernel::WIDTH {
                for x in 0..kernel::WIDTH {
                    // Beyond sides that repeat, or not at all.
                    let cell: [usize; 3] = std::array::from_fn(|a| {
                        let place = axes[a].0 + [x, y, z][a] as i64;
                        place.rem_euclid(cells[a] as i64) as usize
                    });
                    let weight = 0.5 * axes[0].1[x] * axes[1].1[y] * axes[2].1[z];
                    let index = cell[0] + cells[0] * (cell[1] + cells[1] * cell[2]);
                    let sum: &mut [f64; 3] = sums.entry(index).or_default();
                    for a in 0..3 {
                        sum[a] += weight * force[a];
                    }
                }
            }
        }
    }
    sums
}

/// The same forces, in newtons, at the markers of another lattice: those of the fabric if the cells differ, all of them if not.
fn on_lattice(old: &Coupled, scene: &Scene, units: &Units, cloth: Option<&Cloth>) -> Vec<Force> {
    let factor = old.units().force_n() / units.force_n();
    let scaled = |force: [f64; 3], share: f64| force.map(|f| f * factor * share);
    if old.units().cell_size_m == units.cell_size_m {
        return old
            .pending_forces()
            .into_iter()
            .map(|(place, force)| (place, scaled(force, 1.0)))
            .collect();
    }
    let Some(cloth) = cloth else {
        return Vec::new();
    };
    // Force and area by triangle.
    let mut sums = vec![([0.0; 3], 0.0); cloth.structure.triangles.len()];
    for (marker, (_, force)) in old.markers().iter().zip(old.pending_forces()) {
        let (sum, area_m2) = &mut sums[marker.triangle as usize];
        for a in 0..3 {
            sum[a] += force[a];
        }
        *area_m2 += marker.area_m2;
    }
    place_markers(scene)
        .iter()
        .map(|marker| {
            let (force, area_m2) = sums[marker.triangle as usize];
            let share = if area_m2 > 0.0 {
                marker.area_m2 / area_m2
            } else {
                0.0
            };
            let place = units.position_to_lattice(at_marker(cloth, marker, &cloth.positions_m));
            (place, scaled(force, share))
        })
        .collect()
}

impl Simulation {
    /// Goes on on the lattice of `scene`, which differs from this one's in the cells and scales of its air and in its time step alone. Only
    /// after release, and between spans of the fabric ([`Simulation::spans_are_over`]). After an error the simulation cannot go on.
    pub fn change_lattice(&mut self, scene: Scene, mut plan: Plan) -> Result<(), Failure> {
        let (time_s, step) = (self.time_s(), self.step);
        let (Some(old), Some(air), true) = (&self.scene.air, self.air.take(), self.released())
        else {
            return Err(Failure::Start(
                "only air whose structure has been released goes on on another lattice".to_owned(),
            ));
        };
        let (Some(new), Some(time)) = (&scene.air, scene.time) else {
            return Err(Failure::Start("the other lattice has no air".to_owned()));
        };
        let mut fields = read(&air, old)?;
        let carried = match self.impulses.take() {
            Some(impulses) => Some(impulses.into_carried(air.finest())?),
            None => None,
        };
        let mut owed = Vec::new();
        let mut links = None;
        if let Some(coupled) = self.coupled.take() {
            fields[old.depth()].add_half(&coupled.pending_forces());
            owed = on_lattice(&coupled, &scene, &new.units, self.cloth.as_ref());
            links = coupled.into_links();
        }
        let finest = new.finest();
        let shifts = half_steps(&owed, finest.cells);
        plan.start_steps = self.plan.start_steps;
        // Before the new lattice is made: both need not fit.
        drop(air);
        self.cloth_engine = ClothEngine::Host;
        let initial = |level: &Level, cell: [usize; 3]| {
            let (corner_m, units) = scales(new, level);
            let place_m =
                corner_m + (DVec3::from_array(cell.map(|n| n as f64)) + 0.5) * units.cell_size_m;
            let holder = fields.iter().rposition(|field| field.holds(place_m));
            let (excess, velocity, stress) = fields[holder.unwrap_or(0)].at(place_m, &units);
            if *level != finest {
                return (excess, velocity, stress);
            }
            let index = cell[0] + finest.cells[0] * (cell[1] + finest.cells[1] * cell[2]);
            let shift = shifts.get(&index).copied().unwrap_or_default();
            let bare = std::array::from_fn(|a| velocity[a] - shift[a] / (1.0 + excess));
            (excess, bare, stress)
        };
        let air = Levels::of_air(new, &plan, self.device.as_ref(), Some(&initial))?;
        let device = self.device.clone();
        let next = Self::assemble(scene, plan, device, Some(air), self.cloth.take())?;
        *self = Self {
            descent: self
                .descent
                .take()
                .map(|descent| descent.with_time_step(time.step_s)),
            cadence: self.cadence,
            drags: std::mem::take(&mut self.drags),
            opening: self.opening.take(),
            origin: Origin { step, time_s },
            step,
            sound_step: step,
            largest_marker_motion: self.largest_marker_motion,
            cost: self.cost,
            account: self.account.clone(),
            energy: self.energy.clone(),
            ..next
        };
        self.count_steps();
        if let (Some(coupled), Some(air)) = (&mut self.coupled, &self.air) {
            let surfaces = (self.cloth.as_ref(), time_s);
            let left = coupled.go_on(air.finest(), surfaces, &owed, links.as_deref())?;
            self.still_inside(left)?;
        }
        self.start_impulses()?;
        if let (Some(impulses), Some(carried)) = (&mut self.impulses, carried) {
            impulses.carry(carried);
        }
        Ok(())
    }

    /// Steps to the end of the scene, as they are since the last change of the lattice.
    pub(super) fn count_steps(&mut self) {
        if let (Some(time), true) = (self.scene.time, self.origin.time_s > 0.0) {
            let left = (time.end_s - self.origin.time_s) / time.step_s;
            let done = self.origin.step - self.plan.start_steps;
            self.plan.steps = done.saturating_add(left.ceil().max(0.0) as u64);
        }
    }

    /// True if no span of several steps between solves of the fabric is under way.
    #[must_use]
    pub fn spans_are_over(&self) -> bool {
        self.cadence.is_none_or(|cadence| cadence.begins(self.step))
    }

    /// Fastest cell, or marker [cells per step].
    pub fn fastest_in_lattice(&self) -> Result<f64, Failure> {
        let Some(air) = &self.air else {
            return Ok(0.0);
        };
        let levels = (self.scene.air.as_ref()).map_or_else(Vec::new, Air::levels);
        let found = air.extremes(&levels)?.and_then(|found| found.fastest);
        let markers = self.coupled.as_ref().map_or(0.0, Coupled::fastest_marker);
        Ok(found
            .map_or(f64::INFINITY, |state| state.speed)
            .max(markers))
    }
}
