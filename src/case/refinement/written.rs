//! `[air.refinement]` as it is written: what can be told of it before it is known where the structure stands.

use glam::DVec3;

use crate::case::file::{self, Around};
use crate::case::problem::Problem;
use crate::lattice::Operator;
use crate::lattice::nest::EXCHANGED_CELLS;

/// Most boxes one in the other.
pub(super) const MOST_LEVELS: u32 = 4;

/// Cells of the outermost lattice to a length of what stands in the air, at least, where the number of boxes is left out.
const OUTER_CELLS: f64 = 6.0;

/// Boxes where neither their number nor a length is known.
const USUAL_LEVELS: u32 = 2;

/// Finest cells between what stands in the air and the faces of its box, at least: the kernel's reach, the shell, and the cells that are
/// restricted.
pub(super) const KEPT_CELLS: usize = EXCHANGED_CELLS + 2;

/// Smallest τ − ½ with which two relaxation times keep a wind in boxes of finer cells.
const LEAST_VISCOUS_TRT: f64 = 0.01;

pub(super) const KEY: &str = "air.refinement";

pub(super) fn key(name: &str) -> String {
    format!("{KEY}.{name}")
}

/// A box [m].
pub(super) type Corners = (DVec3, DVec3);

/// How often cells are halved at most, from the outermost lattice on; before it is known where the structure stands.
pub(in crate::case) fn most_levels(
    air: &file::Air,
    cell_size_m: f64,
    length_m: Option<f64>,
) -> Result<u32, Problem> {
    let Some(written) = &air.refinement else {
        return Ok(0);
    };
    if let Some(boxes) = &written.boxes {
        for (name, given) in [
            ("around", written.around.is_some()),
            ("levels", written.levels.is_some()),
            ("margin", written.margin.is_some()),
        ] {
            if given {
                return Err(Problem::new(
                    key(name),
                    format!("{} and {} are both given", key(name), key("boxes")),
                    "keep the boxes that are laid by hand, or let them be laid around the structure",
                ));
            }
        }
        let deepest = (tree(&by_hand(boxes)?).iter().map(Branch::depth).max()).unwrap_or(0);
        return match deepest {
            0 => Err(nothing_laid("boxes")),
            1..=MOST_LEVELS => Ok(deepest),
            _ => Err(Problem::new(
                key("boxes"),
                format!("{deepest} boxes lie one in the other"),
                format!("allowed are {MOST_LEVELS}"),
            )),
        };
    }
    match written.around {
        None => Err(nothing_laid("around")),
        Some(Around::Nothing) => {
            if written.levels.is_some() || written.margin.is_some() {
                return Err(Problem::new(
                    key("around"),
                    format!("[{KEY}] has keys of boxes, but lays none around \"nothing\""),
                    "remove them, or give around = \"structure\"",
                ));
            }
            Ok(0)
        }
        Some(Around::Structure) => match written.levels {
            Some(levels) if (1..=MOST_LEVELS).contains(&levels) => Ok(levels),
            Some(levels) => Err(Problem::new(
                key("levels"),
                format!("{} = {levels} is out of range", key("levels")),
                format!("allowed are 1 to {MOST_LEVELS} boxes one in the other"),
            )),
            None => Ok(length_m.map_or(USUAL_LEVELS, |length| {
                let halvings = (length / cell_size_m / OUTER_CELLS).log2().floor();
                halvings.clamp(0.0, f64::from(MOST_LEVELS)) as u32
            })),
        },
    }
}

fn nothing_laid(name: &str) -> Problem {
    Problem::new(
        key(name),
        format!("[{KEY}] lays no boxes"),
        "give around = \"structure\" or boxes, or remove the table",
    )
}

/// Refuses what boxes of finer cells cannot have.
pub(in crate::case) fn refuse_unfit(
    levels: u32,
    operator: Operator,
    viscous_part: f64,
) -> Result<(), Problem> {
    if levels == 0 {
        return Ok(());
    }
    let outermost = viscous_part / f64::from(1_u32 << levels);
    if !operator.is_recursive() && outermost < LEAST_VISCOUS_TRT {
        return Err(Problem::new(
            "resolution.operator",
            format!(
                "with tau - 1/2 = {outermost:.1e} in the outermost lattice this operator breaks down where boxes of finer cells end"
            ),
            "take resolution.operator = \"stabilised_regularised\"",
        ));
    }
    Ok(())
}

/// Boxes as they are written [m].
pub(super) fn by_hand(boxes: &[file::RefinementBox]) -> Result<Vec<Corners>, Problem> {
    let corners: Vec<Corners> = boxes
        .iter()
        .map(|one| {
            (
                DVec3::from_array(one.lower_m),
                DVec3::from_array(one.upper_m),
            )
        })
        .collect();
    for (i, (low, high)) in corners.iter().enumerate() {
        if !(low.is_finite() && high.is_finite() && low.cmplt(*high).all()) {
            return Err(Problem::new(
                key("boxes"),
                format!("box {} of {} has no volume", i + 1, key("boxes")),
                "upper_m lies above lower_m along every axis",
            ));
        }
        for (j, other) in corners[..i].iter().enumerate() {
            let apart = low.cmpge(other.1).any() || high.cmple(other.0).any();
            if !(apart || holds(other, &corners[i]) || holds(&corners[i], other)) {
                return Err(Problem::new(
                    key("boxes"),
                    format!("boxes {} and {} of {} overlap", j + 1, i + 1, key("boxes")),
                    "lay one inside the other, or apart",
                ));
            }
        }
    }
    Ok(corners)
}

fn holds(outer: &Corners, inner: &Corners) -> bool {
    outer.0.cmple(inner.0).all() && outer.1.cmpge(inner.1).all()
}

/// A box with those in it.
pub(super) struct Branch {
    /// Its corners [m].
    pub corners: Corners,
    /// The boxes in it.
    pub inner: Vec<Self>,
}

impl Branch {
    /// Boxes one in the other, itself included.
    pub fn depth(&self) -> u32 {
        1 + self.inner.iter().map(Self::depth).max().unwrap_or(0)
    }
}

/// Puts the chain first that holds a place, or the deepest.
pub(super) fn order(branches: &mut [Branch], place: Option<DVec3>) {
    branches.sort_by_key(|branch| {
        let (low, high) = branch.corners;
        let outside = place.is_some_and(|p| p.cmplt(low).any() || p.cmpgt(high).any());
        (outside, std::cmp::Reverse(branch.depth()))
    });
    for branch in branches {
        order(&mut branch.inner, place);
    }
}

/// Every box in the smallest that holds it.
pub(super) fn tree(corners: &[Corners]) -> Vec<Branch> {
    let volume = |(low, high): &Corners| (*high - *low).element_product();
    let mut sorted = corners.to_vec();
    sorted.sort_by(|a, b| volume(b).total_cmp(&volume(a)));
    let mut roots: Vec<Branch> = Vec::new();
    for corners in sorted {
        add(&mut roots, corners);
    }
    roots
}

fn add(branches: &mut Vec<Branch>, corners: Corners) {
    match branches.iter_mut().find(|b| holds(&b.corners, &corners)) {
        Some(branch) => add(&mut branch.inner, corners),
        None => branches.push(Branch {
            corners,
            inner: Vec::new(),
        }),
    }
}
