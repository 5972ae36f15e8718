//! Parts of a surface that cuts links along which the air slides, and the mass that it owes the air there ([`crate::cut_links::slide`]).

use glam::DVec3;

use crate::cut_links::spaces::Spaces;
use crate::cut_links::{CutLink, Images, Leaving, SIDES};
use crate::lattice::WEIGHTS;

/// Where the air slides along the surface.
#[derive(Debug)]
pub(super) struct Sliding {
    /// Of the triangles.
    slides: Vec<bool>,
    pub(super) images: Images,
    /// What left the cells of the images.
    pub(super) leaving: Vec<Leaving>,
    spaces: Spaces,
    /// Of every space: what its sides lost in the step, and the sum of their weights.
    sums: Vec<[f64; 2]>,
    returned: f64,
}

impl Sliding {
    /// Along the triangles for which `slides` is true; `None` where there are none. The nodes of all stand at `positions` at first, in any unit.
    pub(super) fn new(
        slides: Vec<bool>,
        triangles: &[[u32; 3]],
        positions: &[DVec3],
    ) -> Option<Self> {
        slides.contains(&true).then(|| Self {
            slides,
            images: Images::default(),
            leaving: Vec::new(),
            spaces: Spaces::new(triangles, positions),
            sums: Vec::new(),
            returned: 0.0,
        })
    }

    /// True along a triangle.
    pub(super) fn along(&self, triangle: u32) -> bool {
        self.slides[triangle as usize]
    }

    /// Mass given back to the air since this was made, loss and gain alike.
    pub(super) const fn returned(&self) -> f64 {
        self.returned
    }

    /// Gives back what the air lost in the step at all sides where it slides, `rest` of each: in equal parts, by weight, to those that look at the same space.
    ///
    /// Along a plane wall in a uniform stream some sides lose what others gain, so that what each lost must not come back to itself: it would be rough.
    pub(super) fn keep_mass(
        &mut self,
        links: &[CutLink],
        normals: &[DVec3],
        rest: &mut [[f64; 2]],
    ) {
        let (slides, spaces, sums) = (&self.slides, &self.spaces, &mut self.sums);
        let space = |link: &CutLink, side: usize| {
            let triangle = link.cuts[side].triangle;
            let towards = normals[triangle as usize].dot(link.direction()) > 0.0;
            slides[triangle as usize]
                .then(|| spaces.of(triangle, usize::from(towards == (side == 0))))
        };
        sums.clear();
        sums.resize(spaces.count(), [0.0; 2]);
        for (link, rest) in links.iter().zip(&*rest) {
            for side in SIDES {
                if let Some(space) = space(link, side) {
                    sums[space][0] += rest[side];
                    sums[space][1] += WEIGHTS[link.leaving(side)];
                }
            }
        }
        for (link, rest) in links.iter().zip(rest) {
            for side in SIDES {
                if let Some(space) = space(link, side) {
                    let [lost, weights] = sums[space];
                    rest[side] = lost / weights * WEIGHTS[link.leaving(side)];
                }
            }
        }
        self.returned += sums.iter().map(|[lost, _]| lost.abs()).sum::<f64>();
    }
}
