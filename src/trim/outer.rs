//! Pressure outside, from panels to any place of the skin.
//!
//! Linear in both coordinates of [`super::skin`] between the centres of panels, constant beyond the outermost. A tip has the pressure of its cap,
//! which flow around the edge of the tip is left out of (see [`crate::aero::potential_flow`]).

use serde::{Deserialize, Serialize};

use super::skin::Skin;
use crate::aero::surface::PanelSurface;
use crate::geometry::table::lookup;

/// Coefficients of pressure over the skin of the half wing.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct OuterPressure {
    /// Middles of the strips [cells from the middle].
    pub strips: Vec<f64>,
    /// Middles of the panels, as s.
    pub around: Vec<f64>,
    /// Coefficients, strip by strip.
    pub coefficients: Vec<f64>,
    /// On the cap: points (x/c, coefficient), growing.
    tip: Vec<[f64; 2]>,
}

/// Index before and share of the next, of a place among growing ones.
fn between(places: &[f64], at: f64) -> (usize, f64) {
    if places.len() < 2 {
        return (0, 0.0);
    }
    let i = places
        .partition_point(|p| *p <= at)
        .clamp(1, places.len() - 1)
        - 1;
    let share = (at - places[i]) / (places[i + 1] - places[i]);
    (i, share.clamp(0.0, 1.0))
}

impl OuterPressure {
    /// From the coefficients of a surface's panels.
    #[must_use]
    pub fn new(skin: &Skin, surface: &PanelSurface, coefficients: &[f64]) -> Self {
        let around: Vec<f64> = skin
            .around
            .windows(2)
            .map(|pair| 0.5 * (pair[0] + pair[1]))
            .collect();
        let count = surface.spanwise * surface.chordwise;
        let mut tip: Vec<[f64; 2]> = surface
            .caps
            .iter()
            .flat_map(|cap| {
                let square = |i: usize| skin.around[i] * skin.around[i];
                let coefficients = coefficients[cap.first..].iter().enumerate();
                coefficients
                    .take(skin.per_side)
                    .map(move |(i, c)| [0.5 * (square(i) + square(i + 1)), *c])
            })
            .collect();
        tip.reverse();
        Self {
            strips: skin.strip_middles(),
            around,
            coefficients: coefficients[..count].to_vec(),
            tip,
        }
    }

    /// At a distance from the middle, in cells, and a place s around the section.
    #[must_use]
    pub fn at(&self, cells: f64, s: f64) -> f64 {
        let (strip, across) = between(&self.strips, cells);
        let (panel, along) = between(&self.around, s);
        let row = self.around.len();
        let value = |strip: usize| {
            let first = strip * row + panel;
            let next = (first + 1).min((strip + 1) * row - 1);
            self.coefficients[first] + along * (self.coefficients[next] - self.coefficients[first])
        };
        let here = value(strip);
        if across == 0.0 {
            return here;
        }
        here + across * (value(strip + 1) - here)
    }

    /// The outermost middles of panels between two places s, or these where fewer than two lie there: what stands before a mouth, without the outline beyond its lips.
    #[must_use]
    pub fn within(&self, places: [f64; 2]) -> [f64; 2] {
        let is_there = |s: &&f64| (places[0]..=places[1]).contains(*s);
        let mut middles = self.around.iter().filter(is_there);
        match (middles.next(), middles.next_back()) {
            (Some(first), Some(last)) => [*first, *last],
            _ => places,
        }
    }

    /// On a tip, at a place per chord; that of the outermost strip where the wing ends in a point.
    #[must_use]
    pub fn at_tip(&self, place: f64) -> f64 {
        if self.tip.is_empty() {
            let last = self.strips.last().copied().unwrap_or(0.0);
            let s = place.max(0.0).sqrt();
            return 0.5 * (self.at(last, s) + self.at(last, -s));
        }
        lookup(&self.tip, place)
    }
}
