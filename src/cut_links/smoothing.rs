//! Fields on the nodes of a sheet, smoothed along it.

use super::faces::Neighbours;

/// Most smoothing steps.
const MOST_STEPS: f64 = 12.0;

/// Smooths fields about some of a sheet's nodes.
#[derive(Debug, Clone)]
pub(super) struct Smoothing {
    /// Nodes about which it does.
    nodes: Vec<u32>,
    /// Where what each of them takes begins; one more at the end.
    starts: Vec<u32>,
    /// From which node, and what share of it.
    taken: Vec<(u32, f64)>,
    steps: usize,
}

impl Smoothing {
    /// Steps for fields that reach as far as one step along edges whose length has this inverse square does.
    pub fn steps(inverse_squared: f64) -> usize {
        inverse_squared.ceil().clamp(1.0, MOST_STEPS) as usize
    }

    /// About the nodes `from`, and as many edges around these as fields, and what is divided by them, are spread over.
    pub fn new(triangles: &[[u32; 3]], mut from: Vec<bool>, steps: usize) -> Self {
        let neighbours = Neighbours::new(triangles, from.len());
        // Flow is spread over so many edges; areas there are smoothed over as many again.
        for _ in 0..2 * steps {
            let last = from.clone();
            for (node, reached) in from.iter_mut().enumerate() {
                *reached |= (neighbours.of(node).iter()).any(|other| last[*other as usize]);
            }
        }
        let nodes = numbers(&from);
        let (mut starts, mut taken) = (vec![0], Vec::new());
        for &node in &nodes {
            // A neighbour at two triangles counts twice, and gives in equal parts.
            let mut around = neighbours.of(node as usize).to_vec();
            around.sort_unstable();
            for same in around.chunk_by(|one, other| one == other) {
                let of_other = neighbours.of(same[0] as usize).len();
                taken.push((same[0], same.len() as f64 / (2.0 * of_other as f64)));
            }
            starts.push(taken.len() as u32);
        }
        Self {
            nodes,
            starts,
            taken,
            steps,
        }
    }

    /// Nodes about which it smooths.
    pub fn nodes(&self) -> impl Iterator<Item = usize> {
        self.nodes.iter().map(|node| *node as usize)
    }

    /// Smooths a field. Every node gives half of its own away, in equal parts: nothing is lost.
    pub fn smooth(&self, field: &mut [f64]) {
        let mut old = field.to_vec();
        for _ in 0..self.steps {
            for (&node, range) in self.nodes.iter().zip(self.starts.windows(2)) {
                let taken = &self.taken[range[0] as usize..range[1] as usize];
                let taken = taken
                    .iter()
                    .map(|(other, share)| share * old[*other as usize]);
                field[node as usize] = 0.5 * old[node as usize] + taken.sum::<f64>();
            }
            for &node in &self.nodes {
                old[node as usize] = field[node as usize];
            }
        }
    }
}

/// The nodes that have a flag.
pub(super) fn numbers(flags: &[bool]) -> Vec<u32> {
    (0..flags.len() as u32)
        .filter(|node| flags[*node as usize])
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A strip of triangles: what one node has spreads, and nothing is lost while it stays among the nodes.
    #[test]
    fn nothing_is_lost() {
        let triangles: Vec<[u32; 3]> = (0..20).map(|k| [k, k + 1, k + 2]).collect();
        let mut from = vec![false; 22];
        from[11] = true;
        let smoothing = Smoothing::new(&triangles, from, Smoothing::steps(1.5));
        let mut field = vec![0.0; 22];
        field[11] = 1.0;
        smoothing.smooth(&mut field);
        assert!((field.iter().sum::<f64>() - 1.0).abs() < 1e-15);
        // Two steps of up to two nodes each.
        assert!((7..=15).all(|node| field[node] > 0.0) && field[6] == 0.0 && field[16] == 0.0);
        assert_eq!(smoothing.nodes().count(), 17);
        // Neighbours of one kind have equal parts of it.
        assert!((field[9] / field[13] - 1.0).abs() < 1e-12);
    }
}
