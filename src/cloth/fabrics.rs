//! Structures sewn of several fabrics: which law, thickness and yield stress a triangle has.
//!
//! The first fabric is the structure's own ([`super::Structure::membrane`], [`super::Structure::thickness_m`], [`super::Structure::yield_stress_pa`]);
//! the others stand beside it. A structure of one fabric therefore costs nothing more, and computes the same bits, as if there were no
//! others: the number of a triangle's fabric fills a gap in its layout and is 0.

use super::Triangle;
use crate::fabric::Fabric;
use crate::fabric::membrane::Membrane;

/// A fabric beside the first.
#[derive(Debug, Clone)]
pub struct SewnFabric {
    /// Law of its triangles.
    pub membrane: Membrane,
    /// Thickness [m].
    pub thickness_m: f64,
    /// Von Mises stress from which it is flagged as yielding [Pa]; `None`: never.
    pub yield_stress_pa: Option<f64>,
}

impl From<&Fabric> for SewnFabric {
    fn from(fabric: &Fabric) -> Self {
        Self {
            membrane: fabric.membrane(),
            thickness_m: fabric.thickness_m,
            yield_stress_pa: fabric.yield_stress_pa,
        }
    }
}

/// Laws of all triangles of a structure.
#[derive(Debug, Clone, Copy)]
pub struct Laws<'a> {
    pub(super) first: &'a Membrane,
    pub(super) further: &'a [SewnFabric],
}

impl<'a> Laws<'a> {
    /// Law of a triangle.
    #[inline]
    #[must_use]
    pub fn of(self, triangle: &Triangle) -> &'a Membrane {
        match (triangle.fabric as usize).checked_sub(1) {
            None => self.first,
            Some(further) => &self.further[further].membrane,
        }
    }

    /// All laws, the first fabric's first.
    pub fn all(self) -> impl Iterator<Item = &'a Membrane> {
        std::iter::once(self.first).chain(self.further.iter().map(|fabric| &fabric.membrane))
    }
}

/// Share of compressive stiffness below which fabric counts as tension-only: what keeps more is meant to push, as a plate is.
pub const TENSION_ONLY: f64 = 0.1;
