//! Numbers and places of a mesh in words.

use glam::DVec3;

use super::examination::Subject;

/// Numbers and places in words.
pub(super) struct Words<'a> {
    pub subject: &'a Subject<'a>,
    decimals: Option<usize>,
}

impl<'a> Words<'a> {
    pub fn new(subject: &'a Subject<'a>, size_m: DVec3) -> Self {
        let size = size_m.max_element();
        let usual = (1e-3..=1e4).contains(&size);
        Self {
            subject,
            decimals: usual.then(|| (4.0 - size.log10().floor()).clamp(0.0, 7.0) as usize),
        }
    }

    pub fn place(&self, place: DVec3) -> String {
        let [x, y, z] = place.to_array().map(|c| match self.decimals {
            // What rounds to a negative zero is written as zero.
            Some(decimals) if c.abs() < 0.5 * 0.1f64.powi(decimals as i32) => {
                format!("{:.decimals$}", 0.0)
            }
            Some(decimals) => format!("{c:.decimals$}"),
            None => format!("{c:.4e}"),
        });
        format!("({x}, {y}, {z}) m")
    }

    fn at(&self, node: u32) -> DVec3 {
        self.subject.surface.positions_m[node as usize]
    }

    pub fn middle(&self, triangle: u32) -> DVec3 {
        let nodes = self.subject.surface.triangles[triangle as usize];
        nodes.map(|node| self.at(node)).iter().sum::<DVec3>() / 3.0
    }

    /// "vertices 3 and 7 at (0, 0, 0) m", or without numbers where the file has none.
    pub fn nodes(&self, nodes: &[u32]) -> String {
        let place = nodes.first().map_or_else(String::new, |node| {
            format!("at {}", self.place(self.at(*node)))
        });
        match self.subject.numbers {
            None => place,
            Some((numbers, _)) => {
                let known: Vec<String> = nodes
                    .iter()
                    .map(|node| (numbers[*node as usize] + 1).to_string())
                    .collect();
                let what = if nodes.len() == 1 {
                    "vertex"
                } else {
                    "vertices"
                };
                format!("{what} {} {place}", known.join(" and "))
            }
        }
    }

    /// "between vertices 3 and 7", or where the middle of the edge is.
    pub fn between(&self, edge: [u32; 2]) -> String {
        match self.subject.numbers {
            None => {
                let [a, b] = edge.map(|node| self.at(node));
                format!("beside {}", self.place(0.5 * (a + b)))
            }
            Some((numbers, _)) => {
                let [a, b] = edge.map(|node| numbers[node as usize] + 1);
                format!("between vertices {a} and {b}")
            }
        }
    }

    pub fn triangle(&self, triangle: u32) -> String {
        let place = self.place(self.middle(triangle));
        match self.subject.numbers {
            None => format!("at {place}"),
            Some((_, numbers)) => {
                format!("triangle {} at {place}", numbers[triangle as usize] + 1)
            }
        }
    }
}

/// "1 edge", "2 edges".
pub(super) fn counted(count: usize, one: &str, many: &str) -> String {
    format!("{count} {}", if count == 1 { one } else { many })
}
