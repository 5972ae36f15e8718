//! What comes back to all sides along which the air slides, energy held block by block (`blocks`). And the mass that the wall owes the air.

use std::ops::Range;

use glam::DVec3;
use rayon::prelude::*;

use super::blocks::LossOfBlock;
use super::cell_states::CellState;
use super::energy::Energy;
use super::images::Images;
use super::{Return, SIDES};
use crate::lattice::Real;

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
    /// Puts what comes back where the air slides into `returns`, by the states of the `cells` of the images. `wall` tells the wall's velocity at a side of a link.
    pub fn put<R: Real>(
        &mut self,
        images: &Images,
        cells: &[CellState<R>],
        wall: impl Fn(usize, usize) -> DVec3 + Sync,
        returns: &mut [[Return; 2]],
    ) {
        self.reflect(images, cells, wall);
        self.carry(images, returns);
    }

    /// Reflects what left, block by block. Less slides in blocks where the wall would give the air more energy than along a plane, and more where it would give less.
    ///
    /// Populations of images are copies: where the air at the image has more energy than at the wall, energy comes from nowhere. Round a nose that was a thrust
    /// (docs/results/2026-11-28-energy-of-sliding-walls.md). Where it has less, walls brake
    /// (docs/results/2026-11-28-walls-that-take-no-energy.md).
    fn reflect<R: Real>(
        &mut self,
        images: &Images,
        cells: &[CellState<R>],
        wall: impl Fn(usize, usize) -> DVec3 + Sync,
    ) {
        let (blocks, all) = (images.blocks(), images.all());
        self.reflected.resize(all.len(), Reflected::default());
        self.losses.resize(blocks.count(), LossOfBlock::default());
        let of_block = |sides: Range<usize>, reflected: &mut [Reflected]| {
            let mut energy = Energy::default();
            let (mut along, mut lost) = (0.0, 0.0);
            for (image, reflected) in all[sides].iter().zip(&mut *reflected) {
                let (link, side) = image.place();
                let (back, loss) = image.returned(cells, wall(link, side));
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

    /// What is given back arrives with the velocity u of the air along the wall: of a mass m, −3 m d·u comes along −d, the rest of it at rest. It follows from what links lose
    /// where the wall goes on as it moves. So the fabric knows of it in its step.
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

    /// Gives back what the air lost in the step at the sides where it slides, `rest` of each. What leaves along a plane goes in equal parts, by weight, to all sides that look at the same space. What is
    /// lost beyond it goes to those of the same block.
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
    use std::collections::HashMap;

    use super::*;
    use crate::cut_links::blocks::Key;
    use crate::cut_links::images::Asked;
    use crate::cut_links::slide::{self, Image, Slides};
    use crate::cut_links::{CutLink, CutLinks, Domain};
    use crate::lattice::WEIGHTS;

    /// Numbers from −1 to 1 that look random.
    fn noise(number: usize) -> f64 {
        let mixed = (number as u64 + 1).wrapping_mul(0x9e37_79b9_7f4a_7c15);
        (mixed >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
    }

    /// A plate along whose faces, each a space, air slides, in several tasks, but for a strip where it sticks. Each side gets what its own block and space give it, as found by
    /// looking all sides up one by one; all mass that is lost is given back; the number of threads changes no bit.
    #[test]
    fn every_side_gets_its_own() {
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
        let normal = normal.normalize();
        let space = |link: &CutLink, side: usize| slide::face(link, side, normal) as u32 % 2;
        let mut images = Images::default();
        images.find(&links, &domain, |link, side| {
            (link.cells[side][1] > 20).then(|| Slides {
                normal,
                space: space(link, side),
                modelled: false,
            })
        });
        let count = links.links().len();
        assert!(images.blocks().task_count() > 3);
        let leaving = |cell: usize| {
            std::array::from_fn(|i| WEIGHTS[i] * (0.02 + 0.01 * noise(19 * cell + i)))
        };
        let cells: Vec<CellState<f64>> = (0..images.cells(Asked::Images).len())
            .map(|cell| CellState::new(leaving(cell)))
            .collect();
        let before = vec![[Return::default(); 2]; count];
        let lost: Vec<[f64; 2]> = (0..count)
            .map(|link| SIDES.map(|side| 1e-3 * (0.1 + noise(2 * link + side))))
            .collect();
        let wall = |link: usize, side: usize| {
            DVec3::new(0.02, 0.01, 0.03) * (1.0 + 0.1 * noise(2 * link + side))
        };
        let with_threads = |threads: usize| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads);
            pool.build().unwrap().install(|| {
                let (mut returns, mut rest) = (before.clone(), lost.clone());
                let mut reflections = Reflections::default();
                reflections.put(&images, &cells, wall, &mut returns);
                reflections.keep_mass(&images, &mut rest);
                (returns, rest, reflections.returned())
            })
        };
        let (returns, rest, returned) = with_threads(1);
        let among_three = with_threads(3);
        assert_eq!((&returns, &rest, returned), {
            let (returns, rest, returned) = &among_three;
            (returns, rest, *returned)
        });

        let mut blocks: HashMap<Key, Vec<&Image>> = HashMap::new();
        for image in images.all() {
            let (number, side) = image.place();
            let link = &links.links()[number];
            let cut = links.cut_around(link.cells[side]).count();
            let key = Key::new(space(link, side), link.cells[side], cut);
            blocks.entry(key).or_default().push(image);
        }
        // By space: what passes along planes, and the weight.
        let mut of_spaces = [[0.0; 2]; 2];
        let answer = |image: &Image| {
            let (number, side) = image.place();
            image.returned(&cells, wall(number, side))
        };
        let share_of = |block: &[&Image]| {
            let mut energy = Energy::default();
            for image in block {
                energy += answer(image).1.energy;
            }
            energy.share()
        };
        let mut shares = Vec::new();
        for block in blocks.values() {
            let share = share_of(block);
            shares.push(share);
            for image in block {
                let (number, side) = image.place();
                let sum = &mut of_spaces[space(&links.links()[number], side) as usize];
                sum[0] += share * answer(image).1.along;
                sum[1] += image.weight();
            }
        }
        // Blocks differ.
        let least = shares.iter().copied().fold(f64::INFINITY, f64::min);
        assert!(least < 0.9, "{least}");
        for block in blocks.values() {
            let share = share_of(block);
            let weight: f64 = block.iter().map(|image| image.weight()).sum();
            let along: f64 = block
                .iter()
                .map(|image| share * answer(image).1.along)
                .sum();
            let all: f64 = block.iter().map(|image| share * answer(image).1.all).sum();
            let of_rest: f64 = (block.iter())
                .map(|image| image.place())
                .map(|(number, side)| lost[number][side])
                .sum();
            for image in block {
                let (number, side) = image.place();
                let [passes, weights] = of_spaces[space(&links.links()[number], side) as usize];
                let given = |all: f64| image.weight() * (passes / weights + (all - along) / weight);
                let (mut back, loss) = answer(image);
                back.blend(share);
                back.further -= 3.0 * given(all) * loss.velocity;
                let put = returns[number][side];
                let off = [put.out - back.out, put.further - back.further];
                assert!(off.iter().all(|off| off.abs() < 1e-15), "{put:?} {back:?}");
                assert_eq!(put.strength, back.strength);
                let off = rest[number][side] - given(of_rest);
                assert!(off.abs() < 1e-15, "{off}");
            }
        }
        let slide = images.sides().count();
        assert!(slide > 4000 && slide < 2 * count, "{slide}");
        for (number, sides) in images.of_links().iter().enumerate() {
            for side in SIDES {
                assert_eq!(images.stick()[number][side], sides[side].get().is_none());
                if sides[side].get().is_none() {
                    assert_eq!(returns[number][side], before[number][side]);
                    assert_eq!(rest[number][side], lost[number][side]);
                }
            }
        }
        let sum = |of: &[[f64; 2]]| of.iter().flatten().sum::<f64>();
        assert!((sum(&rest) - sum(&lost)).abs() < 1e-15 * slide as f64);
    }
}
