//! How fast the wall moves that the air meets at a cut.

use glam::DVec3;

use crate::cloth::patches::Patches;
use crate::cut_links::Cut;

/// Velocities of a surface at its cuts: of the very point, or the mean of those who share what the air does there.
#[derive(Debug)]
pub struct WallVelocities<'a> {
    triangles: &'a [[u32; 3]],
    /// Of the nodes.
    velocities: &'a [DVec3],
    patches: Option<&'a Patches>,
    /// Over those who share, of every triangle that does; empty where nothing shares or moves.
    means: Vec<DVec3>,
    stand: bool,
}

impl<'a> WallVelocities<'a> {
    /// Of triangles whose nodes move with `velocities`, and of which the first share so.
    #[must_use]
    pub fn new(
        triangles: &'a [[u32; 3]],
        patches: Option<&'a Patches>,
        velocities: &'a [DVec3],
    ) -> Self {
        let stand = velocities.iter().all(|velocity| *velocity == DVec3::ZERO);
        Self {
            means: match patches {
                Some(patches) if !stand => patches.means(triangles, velocities),
                _ => Vec::new(),
            },
            triangles,
            velocities,
            patches,
            stand,
        }
    }

    /// That at a cut.
    #[inline(always)]
    #[must_use]
    pub fn at(&self, cut: &Cut) -> DVec3 {
        if self.stand {
            return DVec3::ZERO;
        }
        if self.patches.is_some_and(|p| p.shares(cut.triangle)) {
            return self.means[cut.triangle as usize];
        }
        let [a, b, c] = self.triangles[cut.triangle as usize];
        let [of_a, of_b, of_c] = cut.weights;
        let of = |node: u32| self.velocities[node as usize];
        of(a) * of_a + of(b) * of_b + of(c) * of_c
    }
}
