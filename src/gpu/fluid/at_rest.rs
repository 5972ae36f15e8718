//! What cut links add to populations at rest, cell by cell: sums in the order of links, so that they do not depend on the number of threads.

use rayon::prelude::*;

use crate::cut_links::places::Places;
use crate::cut_links::{Changed, CutLink, SIDES};

/// Cells, links and changes that one task works on.
const AT_ONCE: usize = 1024;

/// Which sides of links, and which changed populations behind them, add to which cell.
#[derive(Debug, Default)]
pub(super) struct AtRest {
    /// Number of the search that found the links, and how many populations change.
    made_of: (u64, usize),
    /// Element of the cell, and number of what is added: 2 · link + side, and behind all of those the changes.
    order: Vec<(u32, u32)>,
    /// Where those of a cell begin; one more at the end.
    starts: Vec<u32>,
}

impl AtRest {
    /// Lays out what `links` that a `search` found and populations at rest that are `changed` add to.
    pub(super) fn lay(
        &mut self,
        places: &Places,
        (search, links): (u64, &[CutLink]),
        changed: &[Changed],
    ) {
        if self.made_of == (search, changed.len()) {
            return;
        }
        let order = &mut self.order;
        order.resize(2 * links.len() + changed.len(), Default::default());
        let (of_links, of_changes) = order.split_at_mut(2 * links.len());
        (of_links.par_chunks_mut(2).zip(links).enumerate())
            .with_min_len(AT_ONCE)
            .for_each(|(number, (sides, link))| {
                for side in SIDES {
                    sides[side] = (places.rest(link, side) as u32, (2 * number + side) as u32);
                }
            });
        for (number, change) in changed.iter().enumerate() {
            let element = places.leaving(change.cell)(0).1;
            of_changes[number] = (element as u32, (2 * links.len() + number) as u32);
        }
        order.par_sort_unstable();
        self.starts.clear();
        let mut last = None;
        for (place, (element, _)) in self.order.iter().enumerate() {
            if last != Some(element) {
                self.starts.push(place as u32);
                last = Some(element);
            }
        }
        self.starts.push(self.order.len() as u32);
        self.made_of = (search, changed.len());
    }

    /// How many cells are added to.
    pub(super) fn count(&self) -> usize {
        self.starts.len().saturating_sub(1)
    }

    /// Numbers of what is added to each cell, in the order of cells.
    pub(super) fn parts(&self) -> impl Iterator<Item = &[(u32, u32)]> {
        (self.starts.windows(2)).map(|bounds| &self.order[bounds[0] as usize..bounds[1] as usize])
    }

    /// Elements of the cells.
    pub(super) fn elements(&self) -> impl Iterator<Item = u32> {
        self.starts[..self.count()]
            .iter()
            .map(|start| self.order[*start as usize].0)
    }

    /// Puts into `sums` what is added to every cell: `rest` by every side of a link, and what is `changed`.
    pub(super) fn add_up(&self, rest: &[[f64; 2]], changed: &[Changed], sums: &mut [f32]) {
        (sums.par_iter_mut().zip(self.starts.par_windows(2)))
            .with_min_len(AT_ONCE)
            .for_each(|(sum, bounds)| {
                let [first, end] = [bounds[0], bounds[1]].map(|place| place as usize);
                let of = |&(_, number): &(u32, u32)| {
                    let number = number as usize;
                    match rest.get(number / 2) {
                        Some(sides) => sides[number % 2],
                        None => changed[number - 2 * rest.len()].change,
                    }
                };
                *sum = self.order[first..end].iter().map(of).sum::<f64>() as f32;
            });
    }
}
