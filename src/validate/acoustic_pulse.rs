//! A packet of plane sound waves in a wind: how much of it comes back from the outlet, the inlet and a side, at 0° and 30° (in the full set 45°, too) to the normal.
//!
//! The packet has a Gaussian envelope along the normal of the face, as wide as its waves are long, and is periodic along the face. When it has met
//! the face, the largest density excess that is left is what came back. It is compared with the packet in air without faces at the same time. The
//! operator is that of tunnels at high Reynolds numbers; TRT breaks down in them.

use std::f64::consts::TAU;

use super::flows::states;
use super::report::Gate;
use super::session::{Session, Stop};
use crate::lattice::grid::{Faces, Setup, Sides, StreamwiseEnds, Wall};
use crate::lattice::{Operator, SOUND_SPEED_SQUARED};
use crate::measure::extremes::largest;

/// Largest density excess of the packet.
const AMPLITUDE: f64 = 1e-3;

/// Widths of the envelope between the middle of the packet and the face, and on its other side.
const WIDTHS: f64 = 4.0;

/// What came back at most of a wave at 0° or 30°.
const REFLECTED: f64 = 0.05;

/// A face of the box.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Face {
    Outlet,
    Inlet,
    Side,
}

impl Face {
    const fn name(self) -> &'static str {
        match self {
            Self::Outlet => "outlet",
            Self::Inlet => "inlet",
            Self::Side => "absorbing side",
        }
    }

    /// Axis of its normal.
    const fn axis(self) -> usize {
        match self {
            Self::Outlet | Self::Inlet => 0,
            Self::Side => 1,
        }
    }

    /// 1 at the upper end of the axis, −1 at the lower one.
    const fn sign(self) -> f64 {
        match self {
            Self::Outlet | Self::Side => 1.0,
            Self::Inlet => -1.0,
        }
    }
}

pub(super) fn compute(session: &mut Session) -> Result<(), Stop> {
    // The fundamental between sides 48 cells apart is as long as the longer waves.
    let wave_length = session.size(48.0, 96.0);
    let angles_deg: &[f64] = session.size(&[0.0, 30.0], &[0.0, 30.0, 45.0]);
    let winds: &[f64] = session.size(&[0.08], &[0.05, 0.08]);
    for face in [Face::Outlet, Face::Inlet, Face::Side] {
        for &angle_deg in angles_deg {
            for &wind in winds {
                let packet = Packet {
                    face,
                    angle: angle_deg.to_radians(),
                    wave_length,
                    wind,
                };
                let back = packet.reflected(session)?;
                let what = format!(
                    "{}, {angle_deg}°, wind {wind}: reflected/incident",
                    face.name()
                );
                let row = session.row(packet.cells(), what, back);
                if angle_deg <= 30.0 {
                    row.gate(Gate::AtMost(REFLECTED));
                }
            }
        }
    }
    Ok(())
}

/// The packet and the face that it meets.
#[derive(Debug, Clone, Copy)]
struct Packet {
    face: Face,
    /// Between its way and the normal [rad].
    angle: f64,
    /// [cells]
    wave_length: f64,
    /// Along x [cells per step].
    wind: f64,
}

impl Packet {
    /// Cells along and across the normal: one period along the face.
    fn cells(&self) -> [usize; 3] {
        let along = (2.0 * WIDTHS * self.wave_length).round() as usize + 20;
        let across = if self.angle == 0.0 {
            4
        } else {
            (self.wave_length / self.angle.sin()).round() as usize
        };
        let mut cells = [1; 3];
        cells[self.face.axis()] = along;
        cells[1 - self.face.axis()] = across;
        cells
    }

    fn reflected(&self, session: &mut Session) -> Result<f64, Stop> {
        let axis = self.face.axis();
        let (ends, sides) = match self.face {
            Face::Side => (
                StreamwiseEnds::Periodic,
                Sides::Each([Faces::Walls([Wall::Absorbing; 2]), Faces::Periodic]),
            ),
            Face::Inlet | Face::Outlet => (StreamwiseEnds::InletOutlet, Sides::Periodic),
        };
        let cells = self.cells();
        let tunnel = Setup {
            cells,
            ends,
            sides,
            relaxation_time: 0.5001,
            inlet_profile: None,
            sponge_cells: None,
            idle: None,
            operator: Operator::StabilisedRegularised,
            eddy_viscosity: None,
        };
        // The same packet where it meets nothing: the method itself damps and spreads it on its way.
        let mut endless = Setup {
            ends: StreamwiseEnds::Periodic,
            sides: Sides::Periodic,
            ..tunnel.clone()
        };
        endless.cells[axis] *= 3;
        let left = self.largest_at_the_end(session, tunnel, 0)?;
        let endless = self.largest_at_the_end(session, endless, cells[axis])?;
        // A packet that grows where it meets nothing is no measure.
        Ok(if endless <= AMPLITUDE {
            left / endless
        } else {
            f64::NAN
        })
    }

    /// Largest density excess when what came back is where the packet began; `before` cells lie before the box.
    fn largest_at_the_end(
        &self,
        session: &mut Session,
        setup: Setup,
        before: usize,
    ) -> Result<f64, Stop> {
        let sound = SOUND_SPEED_SQUARED.sqrt();
        let (axis, sign) = (self.face.axis(), self.face.sign());
        let way = WIDTHS * self.wave_length;
        let middle = if sign > 0.0 {
            self.cells()[axis] as f64 - way
        } else {
            way
        } + before as f64;
        let wave_number = TAU / self.wave_length;
        let [along, across] = [self.angle.cos(), self.angle.sin()];
        let wind = self.wind;
        let width = self.wave_length;
        let initial = move |cell: [usize; 3]| {
            let from_middle = cell[axis] as f64 + 0.5 - middle;
            let sideways = cell[1 - axis] as f64 + 0.5;
            let phase = wave_number * (sign * along * from_middle + across * sideways);
            let excess = AMPLITUDE * (-0.5 * (from_middle / width).powi(2)).exp() * phase.cos();
            let mut velocity = [0.0; 3];
            velocity[axis] = sign * along * sound * excess;
            velocity[1 - axis] = across * sound * excess;
            velocity[0] += wind;
            (excess, velocity)
        };
        let wind_there = if axis == 0 { sign * wind } else { 0.0 };
        let [there, back] = [1.0, -1.0].map(|way| along * sound + way * wind_there);
        let mut air = session.air(setup, &initial)?;
        air.set_inlet_velocity([wind, 0.0, 0.0]);
        session.advance(&mut air, (way / there + way / back).round() as usize, None)?;
        // A flow that broke down must not pass for silence.
        Ok(largest(
            states(&air)?.iter().map(|(excess, _)| excess.abs()),
        ))
    }
}
