//! What comes back to all sides along which the air slides: energy that is held block by block ([`super::blocks`]), and the mass that the wall owes the air.

use std::ops::Range;

use glam::DVec3;
use rayon::prelude::*;

use super::blocks::LossOfBlock;
use super::energy::Energy;
use super::images::Images;
use super::slide::Leaving;
use super::{Return, SIDES};

/// Links that one task works on.
const LINKS_AT_ONCE: usize = 512;

/// Blocks that one task works on.
const BLOCKS_AT_ONCE: usize = 16;

/// What comes back, and the mass that is owed.
#[derive(Debug, Clone, Default)]
pub struct Reflections {
    /// By image.
    reflected: Vec<Reflected>,
    /// By block.
    losses: Vec<LossOfBlock>,
    /// What its sides get, by weight.
    given: Vec<f64>,
    returned: f64,
}

/// What comes back to a side.
#[derive(Debug, Clone, Copy, Default)]
struct Reflected {
    back: Return,
    /// Velocity of the air at the wall along the direction in which it leaves, and the weight of that.
    velocity: f64,
    weight: f64,
}

impl Reflections {
    /// Puts what comes back where the air slides into `returns`, by what was taken and is `leaving` the cells of the images. `wall` tells the wall's velocity at a side of a link.
    pub fn put(
        &mut self,
        images: &Images,
        leaving: &[Leaving],
        wall: impl Fn(usize, usize) -> DVec3 + Sync,
        returns: &mut [[Return; 2]],
    ) {
        self.reflect(images, leaving, wall);
        self.carry(images, returns);
    }

    /// Reflects what left, block by block. Less slides in blocks where the wall would give the air more energy than along a plane, and more where it would give less.
    ///
    /// Populations of images are copies: where the air at the image has more energy than at the wall, energy comes from nowhere. Round a nose that was a thrust
    /// (docs/results/2026-11-28-energy-of-sliding-walls.md). Where it has less, walls brake
    /// (docs/results/2026-11-28-walls-that-take-no-energy.md).
    fn reflect(
        &mut self,
        images: &Images,
        leaving: &[Leaving],
        wall: impl Fn(usize, usize) -> DVec3 + Sync,
    ) {
        let (blocks, all, air) = (images.blocks(), images.all(), (leaving, images.air()));
        self.reflected.resize(all.len(), Reflected::default());
        self.losses.resize(blocks.count(), LossOfBlock::default());
        let of_block = |sides: Range<usize>, reflected: &mut [Reflected]| {
            let mut energy = Energy::default();
            let (mut along, mut lost) = (0.0, 0.0);
            for (image, reflected) in all[sides].iter().zip(&mut *reflected) {
                let (link, side) = image.place();
                let (back, loss) = image.returned(air, wall(link, side));
                energy += loss.energy;
                along += loss.along;
                lost += loss.all;
                *reflected = Reflected {
                    back,
                    velocity: loss.velocity,
                    weight: image.weight(),
                };
            }
            let share = energy.share();
            for reflected in reflected {
                reflected.back.blend(share);
            }
            LossOfBlock {
                along: share * along,
                beyond: share * (lost - along),
            }
        };
        (blocks.tasks(&mut self.losses, &mut self.reflected))
            .into_par_iter()
            .for_each(|(task, losses, mut reflected)| {
                for (block, loss) in task.zip(losses) {
                    let sides = blocks.sides(block);
                    let own = reflected.split_off_mut(..sides.len());
                    *loss = of_block(sides, own.unwrap_or_default());
                }
            });
    }

    /// What is given back arrives with the velocity u of the air along the wall: of a mass m, −3 m d·u comes along −d, the rest of it at rest. It follows from what links lose where the wall
    /// goes on as it moves, so that the fabric knows of it in its step.
    fn carry(&mut self, images: &Images, returns: &mut [[Return; 2]]) {
        images.blocks().share(&self.losses, &mut self.given);
        (returns.par_iter_mut().zip(images.of_links()))
            .with_min_len(LINKS_AT_ONCE)
            .for_each(|(returns, sides)| {
                for side in SIDES {
                    if let Some((image, block)) = sides[side].get() {
                        let Reflected {
                            back,
                            velocity,
                            weight,
                        } = self.reflected[image];
                        returns[side] = Return {
                            further: back.further - 3.0 * self.given[block] * weight * velocity,
                            ..back
                        };
                    }
                }
            });
    }

    /// Gives back what the air lost in the step at the sides where it slides, `rest` of each: what leaves along a plane in equal parts, by weight, to all sides that look at the same space, what is lost
    /// beyond it to those of the same block.
    ///
    /// Along a plane wall in a uniform stream some sides lose what others gain. That must not come back to the side itself: the wall would be rough.
    pub fn keep_mass(&mut self, images: &Images, rest: &mut [[f64; 2]]) {
        let blocks = images.blocks();
        let lost = &*rest;
        (self.losses.par_iter_mut().enumerate())
            .with_min_len(BLOCKS_AT_ONCE)
            .for_each(|(block, loss)| {
                let sides = images.sides_of(blocks.sides(block));
                let all: f64 = sides.map(|(link, side)| lost[link][side]).sum();
                loss.beyond = all - loss.along;
            });
        self.returned += blocks.share(&self.losses, &mut self.given);
        (rest.par_iter_mut().zip(images.of_links()))
            .with_min_len(LINKS_AT_ONCE)
            .for_each(|(rest, sides)| {
                for side in SIDES {
                    if let Some((image, block)) = sides[side].get() {
                        rest[side] = self.given[block] * self.reflected[image].weight;
                    }
                }
            });
    }

    /// Mass given back to the air since this was made, loss and gain alike.
    #[must_use]
    pub const fn returned(&self) -> f64 {
        self.returned
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cut_links::images::Asked;
    use crate::cut_links::slide::Slides;
    use crate::cut_links::{CutLinks, Domain};
    use crate::lattice::WEIGHTS;

    /// Numbers from −1 to 1 that look random.
    fn noise(number: usize) -> f64 {
        let mixed = (number as u64 + 1).wrapping_mul(0x9e37_79b9_7f4a_7c15);
        (mixed >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
    }

    /// On a plate along which air slides on one face, in several tasks: the other face is left as it is, all mass that is lost is given back, and the number of threads changes no bit.
    #[test]
    fn mass_is_given_back_whatever_the_threads() {
        let corners = [[4.0, 4.0], [60.0, 6.0], [61.0, 60.0], [5.0, 61.0]];
        let positions = corners.map(|[x, y]| DVec3::new(x, y, 20.3 + 0.2 * x));
        let domain = Domain {
            cells: [64; 3],
            repeats: [false; 3],
            kept: 0,
            open_from: None,
        };
        let mut links = CutLinks::default();
        (links.find(&positions, &[[0, 1, 2], [2, 3, 0]], &domain)).unwrap();
        let normal = (positions[1] - positions[0]).cross(positions[3] - positions[0]);
        let mut images = Images::default();
        images.find(&links, &domain, |_, side| {
            (side == 0).then(|| Slides {
                normal: normal.normalize(),
                space: 0,
                modelled: false,
            })
        });
        let count = links.links().len();
        assert!(images.blocks().tasks(&mut [(); 0], &mut [(); 0]).len() > 3);
        let leaving: Vec<Leaving> = (0..images.cells(Asked::Images).len())
            .map(|cell| std::array::from_fn(|i| 0.01 * WEIGHTS[i] * noise(19 * cell + i)))
            .collect();
        images.take(&leaving);
        let before: Vec<[Return; 2]> = (0..count)
            .map(|link| {
                SIDES.map(|side| Return {
                    out: 1e-3 * noise(2 * link + side),
                    share: 0.5,
                    ..Return::default()
                })
            })
            .collect();
        let lost: Vec<[f64; 2]> = (0..count)
            .map(|link| SIDES.map(|side| 1e-3 * noise(7 * link + side)))
            .collect();
        let with_threads = |threads: usize| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads);
            pool.build().unwrap().install(|| {
                let (mut returns, mut rest) = (before.clone(), lost.clone());
                let mut reflections = Reflections::default();
                reflections.put(&images, &leaving, |_, _| DVec3::ZERO, &mut returns);
                reflections.keep_mass(&images, &mut rest);
                (returns, rest, reflections.returned())
            })
        };
        let (returns, rest, returned) = with_threads(1);
        let among_three = with_threads(3);
        assert_eq!((&returns, &rest, &returned), {
            let (returns, rest, returned) = &among_three;
            (returns, rest, returned)
        });
        assert!(returned > 0.0);
        let slide = images.sides().count();
        assert!(slide > 4000, "{slide}");
        let mut changed = 0;
        for (number, sides) in images.of_links().iter().enumerate() {
            assert_eq!(returns[number][1], before[number][1]);
            assert_eq!(rest[number][1], lost[number][1]);
            if sides[0].get().is_none() {
                assert_eq!(returns[number][0], before[number][0]);
                assert_eq!(rest[number][0], lost[number][0]);
            } else {
                changed += usize::from(returns[number][0] != before[number][0]);
            }
        }
        assert_eq!(changed, slide);
        let sum = |of: &[[f64; 2]]| of.iter().flatten().sum::<f64>();
        assert!((sum(&rest) - sum(&lost)).abs() < 1e-12 * slide as f64);
    }
}
