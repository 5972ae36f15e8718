//! Numbers that belong together, told pair by pair: faces of one space, nodes of one piece.

/// Sets of the numbers from 0 on, each alone at first.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Sets {
    parents: Vec<u32>,
}

impl Sets {
    /// Each number alone.
    #[must_use]
    pub fn new(count: usize) -> Self {
        Self {
            parents: (0..count as u32).collect(),
        }
    }

    /// Smallest number of the set that a number belongs to.
    pub fn first(&mut self, mut number: u32) -> u32 {
        while self.parents[number as usize] != number {
            let next = self.parents[self.parents[number as usize] as usize];
            self.parents[number as usize] = next;
            number = next;
        }
        number
    }

    /// Joins the sets of two numbers; the order in which pairs are told does not matter.
    pub fn join(&mut self, a: u32, b: u32) {
        let (a, b) = (self.first(a), self.first(b));
        self.parents[a.max(b) as usize] = a.min(b);
    }

    /// Smallest number of the set of each number.
    #[must_use]
    pub fn into_firsts(mut self) -> Vec<u32> {
        (0..self.parents.len() as u32)
            .map(|number| self.first(number))
            .collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pairs_make_the_same_sets_in_any_order() {
        let mut pairs = [[7, 3], [3, 5], [1, 2], [5, 7], [0, 1], [6, 6]];
        for _ in 0..pairs.len() {
            let mut sets = Sets::new(8);
            for [a, b] in pairs {
                sets.join(a, b);
            }
            assert_eq!(sets.first(7), 3);
            assert_eq!(sets.into_firsts(), [0, 0, 0, 3, 4, 3, 6, 3]);
            pairs.rotate_left(1);
        }
    }
}
