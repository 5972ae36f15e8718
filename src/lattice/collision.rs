//! Which collision operators there are, in one table.
//!
//! Another one needs its formula in [`super::operators`], its line here, its formula and case in `shaders/operators.wgsl` (a test compares
//! numbers and cases), and what `ripstop bench stability` measures of it in `stability.csv` and
//! `stability_at_bodies.csv`.

use super::Number;
use super::operators::{self, Local, Populations};

/// An operator as a type, with (`EDDY`) or without Smagorinsky's eddy viscosity, for work that is compiled once for each.
pub trait Collision {
    /// Post-collision populations of a cell, under a body force where `FORCED`.
    fn collide<N: Number, const FORCED: bool>(
        f: &Populations<N>,
        local: &Local<N>,
    ) -> Populations<N>;
}

/// Work that is compiled once for each operator.
pub trait PerOperator {
    /// Does it with one of them.
    fn run<C: Collision>(self);
}

/// Declares the operators. This is their only list: number in `shaders/operators.wgsl`, name in case files and reports, short name, formula.
macro_rules! declare {
    ($( $(#[$meaning:meta])* $operator:ident = $number:literal, $name:literal, $short:literal, $formula:ident; )+) => {
        /// Collision operator of the air.
        #[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize, serde::Deserialize, schemars::JsonSchema)]
        pub enum Operator {
            $( $(#[$meaning])* #[serde(rename = $name)] $operator = $number, )+
        }

        impl Operator {
            /// All of them.
            pub const ALL: [Self; [$($number),+].len()] = [$(Self::$operator),+];

            /// Name in case files and reports.
            #[must_use]
            pub const fn name(self) -> &'static str {
                match self { $(Self::$operator => $name),+ }
            }

            /// Name in rows of a validation.
            #[must_use]
            pub const fn short_name(self) -> &'static str {
                match self { $(Self::$operator => $short),+ }
            }

            /// Number in `shaders/operators.wgsl`.
            #[must_use]
            pub const fn number(self) -> u32 {
                self as u32
            }

            /// Does work with the operator, with or without Smagorinsky's eddy viscosity.
            pub fn with(self, eddy: bool, work: impl PerOperator) {
                match (self, eddy) {
                    $(
                        (Self::$operator, false) => work.run::<$operator<false>>(),
                        (Self::$operator, true) => work.run::<$operator<true>>(),
                    )+
                }
            }
        }

        $(
            struct $operator<const EDDY: bool>;

            impl<const EDDY: bool> Collision for $operator<EDDY> {
                #[inline(always)]
                fn collide<N: Number, const FORCED: bool>(
                    f: &Populations<N>,
                    local: &Local<N>,
                ) -> Populations<N> {
                    operators::$formula::<N, FORCED, EDDY>(f, local)
                }
            }
        )+
    };
}

declare! {
    /// BGK: for comparison only.
    SingleRelaxationTime = 0, "single_relaxation_time", "BGK", single_relaxation_time;
    /// For verification and low Reynolds numbers.
    TwoRelaxationTimes = 1, "two_relaxation_times", "TRT", two_relaxation_times;
    /// For any Reynolds number, with an eddy viscosity; without one flow around bluff bodies breaks down at 10⁴ and above.
    RecursiveRegularised = 2, "recursive_regularised", "regularised", recursive_regularised;
    /// For any Reynolds number, bodies included, without an eddy viscosity: adds viscosity only where the lattice resolves nothing.
    StabilisedRegularised = 3, "stabilised_regularised", "stabilised", stabilised_regularised;
}

impl Operator {
    /// True if moments of third order add to the relaxation time.
    pub(crate) const fn reads_residual(self) -> bool {
        matches!(self, Self::StabilisedRegularised)
    }

    /// True if it rebuilds populations recursively, from the stress beyond equilibrium without its trace.
    pub(crate) const fn is_recursive(self) -> bool {
        matches!(
            self,
            Self::RecursiveRegularised | Self::StabilisedRegularised
        )
    }

    /// True if flow around bluff bodies stands at any Reynolds number without an eddy viscosity (docs/stability.md).
    #[must_use]
    pub const fn stands_bluff_bodies(self) -> bool {
        matches!(self, Self::StabilisedRegularised)
    }

    /// Those that runs are meant to take, and not for comparison only.
    pub fn in_use() -> impl Iterator<Item = Self> {
        Self::ALL
            .into_iter()
            .filter(|operator| *operator != Self::SingleRelaxationTime)
    }
}
