//! Material law of suspension lines, belts and other cables.
//!
//! A cable carries tension only: T = f(ε) for a strain ε = l/L − 1 > 0, and c dε/dt more while it is taut. f is EA·ε, or a table as
//! measured in a tensile test.

pub mod drag;
pub mod named;

/// Halvings until a strain is found.
const HALVINGS: usize = 60;

/// Elastic constants of a cable.
#[derive(Debug, Clone, PartialEq)]
pub struct Cable {
    /// Cross-section [m²].
    pub area_m2: f64,
    /// Density [kg/m³].
    pub density_kg_m3: f64,
    /// What it carries at which strain.
    pub law: CableLaw,
    /// Axial damping c of T = f(ε) + c dε/dt [N s].
    pub damping_n_s: f64,
    /// Load at which it breaks \[N\]; `None`: not told here.
    pub breaking_load_n: Option<f64>,
}

impl Cable {
    /// A cable of a linear material without damping.
    #[must_use]
    pub const fn linear(area_m2: f64, density_kg_m3: f64, youngs_modulus_pa: f64) -> Self {
        Self {
            area_m2,
            density_kg_m3,
            law: CableLaw::Linear {
                axial_stiffness_n: area_m2 * youngs_modulus_pa,
            },
            damping_n_s: 0.0,
            breaking_load_n: None,
        }
    }

    /// Mass per length [kg/m].
    #[must_use]
    pub const fn mass_per_length_kg_m(&self) -> f64 {
        self.area_m2 * self.density_kg_m3
    }
}

/// Tension over strain.
#[derive(Debug, Clone, PartialEq)]
pub enum CableLaw {
    /// EA·ε.
    Linear {
        /// EA [N].
        axial_stiffness_n: f64,
    },
    /// Straight between points, from (0, 0) on; beyond the last it goes on as between the last two.
    Table(ForceStrainTable),
}

/// Points (strain, force \[N\]) of a tensile test, (0, 0) not among them.
#[derive(Debug, Clone, PartialEq)]
pub struct ForceStrainTable {
    points: Vec<[f64; 2]>,
    /// ∫f dε up to each point [N].
    energies_n: Vec<f64>,
}

/// Why points do not make a table.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub enum TableError {
    /// No points.
    #[error("it has no points")]
    Empty,
    /// Number of the first wrong point, from 1.
    #[error(
        "point {0} does not lie beyond the one before (from 0, 0 on): strain and force must grow"
    )]
    NotGrowing(usize),
}

impl ForceStrainTable {
    /// A table through (0, 0) and `points`, whose strains grow and whose forces grow too: else the cable would have more than one shape.
    pub fn new(points: Vec<[f64; 2]>) -> Result<Self, TableError> {
        if points.is_empty() {
            return Err(TableError::Empty);
        }
        let mut energies_n = Vec::new();
        let (mut last, mut energy) = ([0.0; 2], 0.0);
        for (index, &[strain, force]) in points.iter().enumerate() {
            let grows = strain > last[0] && force > last[1];
            if !grows || !strain.is_finite() || !force.is_finite() {
                return Err(TableError::NotGrowing(index + 1));
            }
            energy += 0.5 * (strain - last[0]) * (force + last[1]);
            energies_n.push(energy);
            last = [strain, force];
        }
        Ok(Self { points, energies_n })
    }

    /// The table of so many cables side by side.
    #[must_use]
    pub fn times(&self, count: f64) -> Self {
        Self {
            points: self.points.iter().map(|[s, f]| [*s, f * count]).collect(),
            energies_n: self.energies_n.iter().map(|e| e * count).collect(),
        }
    }

    /// Points (strain, force \[N\]).
    #[must_use]
    pub fn points(&self) -> &[[f64; 2]] {
        &self.points
    }

    /// Force \[N\], slope \[N\] and energy per rest length \[N\] at a positive strain.
    fn at(&self, strain: f64) -> CableState {
        let beyond = self.points.partition_point(|point| point[0] < strain);
        let end = beyond.min(self.points.len() - 1);
        let ([s0, f0], energy) = match end.checked_sub(1) {
            Some(i) => (self.points[i], self.energies_n[i]),
            None => ([0.0; 2], 0.0),
        };
        let [s1, f1] = self.points[end];
        let slope = (f1 - f0) / (s1 - s0);
        let force = f0 + slope * (strain - s0);
        CableState {
            tension_n: force,
            tangent_n: slope,
            energy_n: energy + 0.5 * (strain - s0) * (f0 + force),
        }
    }
}

/// A cable at some strain.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CableState {
    /// Tension [N].
    pub tension_n: f64,
    /// dT/dε [N].
    pub tangent_n: f64,
    /// Energy per rest length [N].
    pub energy_n: f64,
}

impl CableLaw {
    /// State at a strain; nothing where it is not positive.
    #[must_use]
    pub fn at(&self, strain: f64) -> CableState {
        if strain <= 0.0 {
            return CableState {
                tension_n: 0.0,
                tangent_n: 0.0,
                energy_n: 0.0,
            };
        }
        match self {
            Self::Linear { axial_stiffness_n } => CableState {
                tension_n: axial_stiffness_n * strain,
                tangent_n: *axial_stiffness_n,
                energy_n: 0.5 * axial_stiffness_n * strain * strain,
            },
            Self::Table(table) => table.at(strain),
        }
    }

    /// Strain at which it carries a tension \[N\], by halving.
    #[must_use]
    pub fn strain_at(&self, tension_n: f64) -> f64 {
        let [mut low, mut high] = [0.0, tension_n / self.initial_stiffness_n()];
        while self.at(high).tension_n < tension_n && high < 1e3 {
            high *= 2.0;
        }
        // As far as numbers tell places apart.
        for _ in 0..HALVINGS {
            let middle = 0.5 * (low + high);
            if self.at(middle).tension_n < tension_n {
                low = middle;
            } else {
                high = middle;
            }
        }
        0.5 * (low + high)
    }

    /// dT/dε of the first stretch [N].
    #[must_use]
    pub fn initial_stiffness_n(&self) -> f64 {
        match self {
            Self::Linear { axial_stiffness_n } => *axial_stiffness_n,
            Self::Table(table) => table.points[0][1] / table.points[0][0],
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_table_is_straight_between_its_points() {
        let table = ForceStrainTable::new(vec![[0.01, 100.0], [0.03, 500.0]]).unwrap();
        let law = CableLaw::Table(table);
        for (strain, force) in [
            (-0.1, 0.0),
            (0.0, 0.0),
            (0.005, 50.0),
            (0.02, 300.0),
            (0.04, 700.0),
        ] {
            assert!((law.at(strain).tension_n - force).abs() < 1e-9, "{strain}");
            let step = 1e-7;
            let slope =
                (law.at(strain + step).energy_n - law.at(strain - step).energy_n) / (2.0 * step);
            assert!((slope - force).abs() < 1e-3, "{strain}");
        }
        assert!((law.initial_stiffness_n() - 1e4).abs() < 1e-9);
    }

    #[test]
    fn tables_that_fall_are_refused() {
        assert_eq!(ForceStrainTable::new(vec![]), Err(TableError::Empty));
        for points in [vec![[0.0, 1.0]], vec![[0.01, 0.0]], vec![[f64::NAN, 1.0]]] {
            assert_eq!(
                ForceStrainTable::new(points),
                Err(TableError::NotGrowing(1))
            );
        }
        let falls = vec![[0.01, 100.0], [0.02, 90.0]];
        assert_eq!(ForceStrainTable::new(falls), Err(TableError::NotGrowing(2)));
    }
}
