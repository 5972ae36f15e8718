//! Looks at the air: around the markers and at all cells, as [`super::watch`] asks for, and what is said of a flow that breaks down.

use glam::DVec3;

use super::watch::{Alarm, Found, REFERENCE_SPEEDS, Sign, Watch, steps_between};
use super::{Coupled, Failure, Simulation};
use crate::case::scene::{Air, Flow};
use crate::gpu::DeviceError;
use crate::lattice::grid::{CellState, Extremes};

/// Cells around the markers' box that are looked at, at least, and as a share of its middle side: the shear layer where it begins.
const MARGIN_CELLS: f64 = 4.0;
const MARGIN: f64 = 0.25;

/// Distance from a marker up to which a cell is said to be at a surface [cells]; kernels reach two.
const NEAR_CELLS: f64 = 4.0;

/// Smallest size of a structure by which looks are timed [cells].
const SMALLEST_SIZE: f64 = 4.0;

/// Time after a release or a change of the lattice from which growth counts [D/U].
const SETTLING: f64 = 1.0;

/// The cells around the markers.
struct Around {
    first: [usize; 3],
    end: [usize; 3],
    /// Middle side of the markers' box [cells]: the diameter of a sphere, a disk or a canopy, the chord of most wings.
    size: f64,
    /// Share of all cells.
    share: f64,
}

impl Around {
    /// Around markers at `positions` [cells] in air of so many cells; `None` without markers.
    fn of(positions: &[[f64; 3]], cells: [usize; 3]) -> Option<Self> {
        if positions.is_empty() {
            return None;
        }
        let side = |pick: fn(f64, f64) -> f64, from: f64| -> [f64; 3] {
            std::array::from_fn(|a| positions.iter().map(|p| p[a]).fold(from, pick))
        };
        let low = side(f64::min, f64::INFINITY);
        let high = side(f64::max, f64::NEG_INFINITY);
        let mut sides: [f64; 3] = std::array::from_fn(|a| high[a] - low[a]);
        sides.sort_by(f64::total_cmp);
        let size = sides[1].max(SMALLEST_SIZE);
        let margin = MARGIN_CELLS.max(MARGIN * size);
        // Markers may have left the air.
        let first =
            std::array::from_fn(|a| ((low[a] - margin).max(0.0) as usize).min(cells[a] - 1));
        let end = std::array::from_fn(|a| {
            let end = (high[a] + margin).max(0.0) as usize + 1;
            end.clamp(first[a] + 1, cells[a])
        });
        let share = (0..3).map(|a| (end[a] - first[a]) as f64 / cells[a] as f64);
        Some(Self {
            share: share.product(),
            first,
            end,
            size,
        })
    }
}

impl Simulation {
    /// Looks at the air where that is due, and the air is not ahead.
    pub(super) fn watch(&mut self) -> Result<(), Failure> {
        if !self.watch.is_due(self.step) || self.own_steps_are_ahead() {
            return Ok(());
        }
        let whole = self.watch.whole_is_due(self.step);
        self.look_at(whole)?;
        if whole {
            self.sound_step = self.step;
        }
        Ok(())
    }

    /// Looks at all air now.
    pub(super) fn look(&mut self) -> Result<(), Failure> {
        self.look_at(true)
    }

    /// Looks around the markers, and if wanted at all cells.
    fn look_at(&mut self, whole: bool) -> Result<(), Failure> {
        let mut watch = std::mem::take(&mut self.watch);
        let alarm = self.add_look(&mut watch, whole);
        let told = match (&alarm, &self.scene.air) {
            (Ok(Some(alarm)), Some(air)) => Some(self.tell(alarm, &watch, air)),
            _ => None,
        };
        self.watch = watch;
        alarm?;
        told.map_or(Ok(()), |what| Err(self.diverged(what).into()))
    }

    fn add_look(&self, watch: &mut Watch, whole: bool) -> Result<Option<Alarm>, DeviceError> {
        let (Some(engine), Some(air)) = (&self.air, &self.scene.air) else {
            return Ok(None);
        };
        let coupled = self.coupled.as_ref();
        let reference_speed = self.fastest_expected(air, coupled);
        let found = |extremes: Extremes| Found {
            step: self.step,
            time_s: self.time_s(),
            extremes,
            reference_speed,
            slip_ratio: None,
            released: self.released(),
            settled: false,
        };
        let mut alarm = None;
        let finest = air.finest();
        let around = coupled.and_then(|coupled| Around::of(&coupled.positions(), finest.cells));
        if let (Some(around), Some(coupled)) = (&around, coupled) {
            let settling = (SETTLING * around.size / air.lattice_speed).ceil() as u64;
            let settled = self.released() && self.step >= self.origin.step + settling;
            let slip_ratio = if settled && reference_speed > 0.0 {
                let slip_m_s = coupled.slip_m_s()?;
                slip_m_s.map(|slip| slip / (reference_speed * air.units.speed_m_s()))
            } else {
                None
            };
            let near = engine.finest().extremes(around.first, around.end)?;
            if let Some(extremes) = near.map(|near| near.moved_by(finest.corner)) {
                let found = Found {
                    slip_ratio,
                    settled,
                    ..found(extremes)
                };
                let (size, share) = (around.size, around.share);
                let on_device = self.device.is_some();
                let steps = steps_between(size, air.lattice_speed, share, on_device);
                alarm = watch.add_near(&found, steps);
            }
        } else {
            watch.no_markers();
        }
        if whole
            && alarm.is_none()
            && let Some(extremes) = engine.extremes(&air.levels())?
        {
            alarm = watch.add_whole(&found(extremes));
        }
        Ok(alarm)
    }

    /// Fastest of the wind, the speed that the lattice is scaled with and all markers [cells per step].
    fn fastest_expected(&self, air: &Air, coupled: Option<&Coupled>) -> f64 {
        let wind = self.wind_speed_m_s() / air.units.speed_m_s();
        let markers = coupled.map_or(0.0, Coupled::fastest_marker);
        air.lattice_speed.max(wind).max(markers)
    }

    /// What is said of a flow that breaks down: where, how it shows, the likely cause, and what to do.
    fn tell(&self, alarm: &Alarm, watch: &Watch, air: &Air) -> String {
        let Alarm { sign, state, .. } = *alarm;
        let place = (DVec3::from_array(state.cell.map(|c| c as f64)) + 0.5) * air.units.cell_size_m;
        let ago = self.step - alarm.step;
        let mut text = format!(
            "the air at cell {:?}, ({:.3}, {:.3}, {:.3}) m, moved at {:.3e} m/s ({:.2} times the reference speed) with a density of {:.3} \
             times that of the undisturbed air: ",
            state.cell,
            place.x,
            place.y,
            place.z,
            state.speed * air.units.speed_m_s(),
            state.speed / alarm.reference_speed,
            1.0 + state.density_excess
        );
        text += &match sign {
            Sign::NotFinite if ago > 0 => {
                format!("the fastest cell {ago} steps ago, and now others are no longer finite")
            }
            Sign::NotFinite => "cells are no longer finite".to_owned(),
            Sign::Density => "a density that the method does not represent".to_owned(),
            Sign::TooFast => {
                "faster than Mach 0.69, which the method does not represent".to_owned()
            }
            Sign::ManyReferenceSpeeds => {
                format!("more than {REFERENCE_SPEEDS} times the reference speed")
            }
            Sign::SpeedGrows([a, b]) => {
                format!("the fastest cell became {a:.2} and {b:.2} times as fast in two looks")
            }
            Sign::SlipGrows([a, b, c]) => format!(
                "the slip of the air at the surfaces grew {a:.2}, {b:.2} and {c:.2} times in three looks"
            ),
        };
        let looks = watch.looks();
        if let [first, .., last] = looks {
            let ratios: Vec<String> = looks
                .iter()
                .map(|look| format!("{:.2}", look.speed_ratio()))
                .collect();
            text += &format!(
                "; near the surfaces the fastest cells moved at {} times the reference speed from step {} to {}",
                ratios.join(", "),
                first.step,
                last.step
            );
        }
        text + &self.advice(&state, air)
    }

    /// The likely cause of a breakdown at a cell, and what to do.
    fn advice(&self, state: &CellState, air: &Air) -> String {
        let cell = state.cell.map(|c| c as f64);
        let square =
            |position: &[f64; 3]| -> f64 { (0..3).map(|a| (position[a] - cell[a]).powi(2)).sum() };
        let corner = air.finest().corner;
        let positions = self.coupled.iter().flat_map(Coupled::positions);
        let positions = positions.map(|place| std::array::from_fn(|a| place[a] + corner[a] as f64));
        let nearest = positions
            .map(|place| square(&place))
            .fold(f64::INFINITY, f64::min)
            .sqrt();
        let sponge_cells = match air.flow {
            Flow::WindTunnel {
                sponge_length_m, ..
            } => sponge_length_m.unwrap_or(0.0) / air.units.cell_size_m,
            Flow::TaylorGreen { .. } => 0.0,
        };
        let dissipation = match air.eddy_viscosity {
            _ if !air.operator.stands_bluff_bodies() => {
                "take resolution.operator = \"stabilised_regularised\""
            }
            None => {
                "switch the eddy viscosity on (resolution.eddy_viscosity = { model = \"smagorinsky\", constant = 0.1 })"
            }
            Some(_) => "raise the constant of the eddy viscosity",
        };
        if nearest <= NEAR_CELLS {
            format!(
                ". The cell lies {nearest:.1} cells from a marker: the flow along the surface is not resolved; lower resolution.lattice_speed, \
                 refine, or {dissipation}"
            )
        } else if cell[0] >= air.cells[0] as f64 - sponge_cells {
            ". The cell lies in the sponge before the outlet: vortices leave through it; lengthen sponge_length_m or the tunnel, or lower \
             resolution.lattice_speed"
                .to_owned()
        } else {
            format!(
                ". The cell lies in the wake or the free flow, far from surfaces: {dissipation}, lower resolution.lattice_speed, or refine"
            )
        }
    }
}
