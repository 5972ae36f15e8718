//! Openings in an impermeable wall, from wide ones down to a cell, whose markers stand inside their rims.
//!
//! A plate with a square hole of a third of the width (a ninth of the area open), or with a slot of a quarter of it, stands across a duct
//! that repeats along all axes: a grid of openings. A uniform force per mass drives the air along x: force times length is the pressure difference in the mean, whatever the
//! scheme does. The discharge coefficient C_d = v/√(2Δp/ρ) of the mean velocity v in the hole is compared with that of sharp-edged thin grids
//! (Idelchik, Handbook of Hydraulic Resistance, diagram 8-1: Δp = ½ρv² (0.707 √(1 − f) + 1 − f)² at high Reynolds numbers, f the open share).
//!
//! A marker closes the air within some two cells, so that a hole of four cells with markers up to its rim passes less than half of what it
//! should. With the inset of rims, which was calibrated with a disk's drag and not with holes, and the wider one of narrow openings
//! ([`markers::opening_inset_cells`]), holes of one to six cells pass the right amount. Wider ones pass more, as rounded holes do: the kernel
//! smooths the edge that the jet would leave, and narrows it less.
//!
//! A plate that cuts links has no insets. Holes below two cells and slots below three are also computed with the law of narrow ones ([`crate::cut_links::through`]), in a duct of eight cells or more.

use glam::DVec3;

use super::flows::{periodic, states};
use super::report::Gate;
use super::session::{Session, Stop};
use crate::cut_links::Passage;
use crate::immersed::markers;
use crate::lattice::Operator;
use crate::lattice::eddy_viscosity::EddyViscosity;
use crate::simulation::{AirEngine, CutSurface, MarkerEngine};

/// How a plate meets the air.
#[derive(Clone, Copy, PartialEq)]
enum Wall {
    /// By markers, which stand so far inside the rim [cells].
    Markers(f64),
    /// It cuts links.
    Cut,
    /// It cuts links, and its openings have the law of narrow ones.
    CutWithLaw,
}

/// A square hole or a slot in a plate.
#[derive(Clone, Copy)]
struct Opening {
    /// [cells]
    width: f64,
    is_slot: bool,
    wall: Wall,
    /// Where it begins, in cells of the duct, between two of the lattice.
    offset: f64,
}

/// Widths of the duct per width of a hole and of a slot; the duct is four of its own widths long. Twice that changes nothing by more than 1 %.
const DUCT_OF_HOLE: f64 = 3.0;
const DUCT_OF_SLOT: f64 = 4.0;

/// Widths of holes and of slots [cells].
const HOLES_CELLS: [f64; 5] = [1.0, 2.0, 3.0, 4.0, 6.0];
const SLOTS_CELLS: [f64; 4] = [1.0, 2.0, 3.0, 4.0];

/// Widths of holes and of slots that have the law of narrow openings [cells], those of the quick set first, and the least width of their duct [cells].
const NARROW_HOLES_CELLS: [f64; 4] = [0.5, 1.0, 0.25, 1.5];
const NARROW_SLOTS_CELLS: [f64; 7] = [0.5, 1.0, 0.25, 1.5, 2.0, 2.5, 2.75];
const DUCT_OF_NARROW_CELLS: f64 = 8.0;

/// Cells along a slot: the jet may sway in three dimensions.
const ALONG_SLOT: usize = 12;

/// The same where the cells do not see its jet.
const ALONG_NARROW_SLOT: usize = 4;

/// Widths from which on holes and slots in a plate that cuts links pass what they should, and within which band: no inset, nothing fitted. The jets of a slot of two
/// cells lean to one side or the other, for as long as the flow was followed: +4 to +29 % were measured.
const RESOLVED_BY_LINKS_CELLS: [f64; 2] = [2.0, 3.0];
const BAND_OF_LINKS: f64 = 0.15;

/// Those of the quick set.
const CUT_QUICK_CELLS: [f64; 2] = [2.0, 4.0];

/// Longest side of the rectangles that two triangles make, in a plate whose openings have a law [cells].
const EDGE_CELLS: f64 = 1.0;

/// Speed in the hole that the force is chosen for [cells per step].
const SPEED: f64 = 0.06;

/// Largest distance of markers [cells].
const SPACING: f64 = 0.6;

/// Where the plate is, in widths of the duct; and where openings begin.
const PLATE: f64 = 0.523;
const OFFSETS: [f64; 2] = [0.13, 0.6];

impl Opening {
    fn ours(width: f64, is_slot: bool, offset: f64) -> Self {
        Self {
            width,
            is_slot,
            wall: Wall::Markers(markers::opening_inset_cells(width)),
            offset,
        }
    }

    /// From one opening to the next [cells].
    fn pitch(self) -> f64 {
        let widths = if self.is_slot {
            DUCT_OF_SLOT
        } else {
            DUCT_OF_HOLE
        };
        let least = match self.wall {
            Wall::CutWithLaw => DUCT_OF_NARROW_CELLS,
            _ => 0.0,
        };
        (widths * self.width).max(least)
    }

    /// Openings in the duct along an axis, which is never narrower than a kernel.
    fn repeated(self) -> i32 {
        if self.pitch() < 6.0 { 2 } else { 1 }
    }

    /// Open share of the plate.
    fn open(self) -> f64 {
        let widths = self.pitch() / self.width;
        widths.powi(if self.is_slot { -1 } else { -2 })
    }

    fn reference(self) -> f64 {
        let open = self.open();
        1.0 / (0.707 * (1.0 - open).sqrt() + 1.0 - open)
    }

    /// Largest relative error. That of a single cell depends on where between cells the hole lies; jets of slots sway so slowly that
    /// coefficients of different averages differ by 15 %. A slot of one cell is shown, and passes too little.
    fn band(self) -> Option<f64> {
        match (self.is_slot, self.width > 1.0) {
            (true, false) => None,
            (false, true) => Some(0.15),
            _ => Some(0.2),
        }
    }

    fn name(self) -> String {
        format!(
            "{} of {} cells",
            if self.is_slot { "slot" } else { "hole" },
            self.width
        )
    }
}

pub(super) fn compute(session: &mut Session) -> Result<(), Stop> {
    let [holes, offsets] = session.size([4, 1], [HOLES_CELLS.len(), OFFSETS.len()]);
    let slots = session.size(&SLOTS_CELLS[1..2], &SLOTS_CELLS);
    let holes = HOLES_CELLS[..holes].iter().map(|&width| (width, false));
    let slots = slots.iter().map(|&width| (width, true));
    for (width, is_slot) in holes.chain(slots) {
        for offset in &OFFSETS[..offsets] {
            let opening = Opening::ours(width, is_slot, *offset);
            let (cells, coefficient) = discharge(session, opening)?;
            let name = opening.name();
            let row = session
                .row(
                    cells,
                    format!("{name} at {offset}: discharge coefficient"),
                    coefficient,
                )
                .reference(opening.reference(), "Idelchik, diagram 8-1");
            if let Some(band) = opening.band() {
                row.gate(Gate::Within(band));
            }
            if !session.order.full && !CUT_QUICK_CELLS.contains(&opening.width) {
                continue;
            }
            let cut = Opening {
                wall: Wall::Cut,
                ..opening
            };
            let (cells, coefficient) = discharge(session, cut)?;
            let row = session
                .row(
                    cells,
                    format!("{name} at {offset}, cut links: discharge coefficient"),
                    coefficient,
                )
                .reference(opening.reference(), "Idelchik, diagram 8-1");
            if opening.width >= RESOLVED_BY_LINKS_CELLS[usize::from(opening.is_slot)] {
                row.gate(Gate::Within(BAND_OF_LINKS));
            }
        }
    }
    let holes = session.size(&NARROW_HOLES_CELLS[..2], &NARROW_HOLES_CELLS);
    let slots = session.size(&NARROW_SLOTS_CELLS[..2], &NARROW_SLOTS_CELLS);
    let holes = holes.iter().map(|&width| (width, false));
    let slots = slots.iter().map(|&width| (width, true));
    for (width, is_slot) in holes.chain(slots) {
        for offset in &OFFSETS[..offsets] {
            let opening = Opening {
                wall: Wall::CutWithLaw,
                ..Opening::ours(width, is_slot, *offset)
            };
            let (cells, coefficient) = discharge(session, opening)?;
            let name = opening.name();
            session
                .row(
                    cells,
                    format!("{name} at {offset}, law of narrow openings: discharge coefficient"),
                    coefficient,
                )
                .reference(opening.reference(), "Idelchik, diagram 8-1")
                .gate(Gate::Within(BAND_OF_LINKS));
        }
    }
    let hole = Opening::ours(4.0, false, OFFSETS[0]);
    let mut shown = vec![(
        Opening {
            wall: Wall::Markers(0.0),
            ..hole
        },
        "markers up to the rim",
    )];
    if session.size(false, true) {
        shown.push((
            Opening {
                width: 12.0,
                ..hole
            },
            "resolved",
        ));
    }
    for (opening, what) in shown {
        let (cells, coefficient) = discharge(session, opening)?;
        let name = opening.name();
        session
            .row(
                cells,
                format!("{name}, {what}: discharge coefficient"),
                coefficient,
            )
            .reference(opening.reference(), "Idelchik, diagram 8-1");
    }
    Ok(())
}

/// Middles of equal parts of `from..to`, no longer than [`SPACING`], and their length.
fn parts(from: f64, to: f64) -> (Vec<f64>, f64) {
    let count = ((to - from) / SPACING).ceil();
    let length = (to - from) / count;
    let middles = (0..count as usize).map(|i| from + (i as f64 + 0.5) * length);
    (middles.collect(), length)
}

/// Cells, and v/√(2Δp/ρ) in the mean.
fn discharge(session: &mut Session, opening: Opening) -> Result<([usize; 3], f64), Stop> {
    let is_slot = opening.is_slot;
    let (open, wanted) = (opening.open(), opening.reference());
    let side = (opening.pitch() * f64::from(opening.repeated())).round() as usize;
    let depth = match (is_slot, opening.wall) {
        (false, _) => side,
        (true, Wall::CutWithLaw) => ALONG_NARROW_SLOT,
        (true, _) => ALONG_SLOT,
    };
    let cells = [4 * side, side, depth];
    let pressure = 0.5 * (SPEED / wanted).powi(2);
    let mut setup = periodic(cells, 0.5 + 3e-4, Operator::RecursiveRegularised);
    setup.eddy_viscosity = Some(EddyViscosity::smagorinsky(0.15));
    // Behind a plate that is hardly open sound would go to and fro for long: the pressure begins as it will be.
    let rises = match opening.wall {
        Wall::CutWithLaw => 3.0 * pressure / cells[0] as f64,
        _ => 0.0,
    };
    let length = cells[0] as f64;
    let excess = |x: f64| rises * ((x - PLATE * side as f64).rem_euclid(length) - 0.5 * length);
    let mut air = session.air(setup, &|[x, ..]| {
        (excess(x as f64), [SPEED * open, 0.0, 0.0])
    })?;
    let mut plate = match opening.wall {
        Wall::Markers(inset) => {
            Plate::Markers(Box::new(marked_plate(&air, opening, inset, [side, depth])?))
        }
        _ => Plate::Cut(Box::new(cut_plate(&air, opening, [side, depth]))),
    };
    let acceleration = Some([pressure / cells[0] as f64, 0.0, 0.0]);
    // The jet goes around so many times; the mean is taken over the second half. That of a slot sways slowly from one side to the other.
    let sways = is_slot && opening.wall != Wall::CutWithLaw;
    let passes = session.size(12.0, 30.0) * if sways { 4.0 } else { 1.0 };
    let steps = (passes * cells[0] as f64 / SPEED) as usize;
    let (mut sum, mut samples) = (0.0, 0.0);
    for step in 0..steps {
        plate.advance(&mut air, acceleration)?;
        if step.is_multiple_of(64) {
            session.check_interrupt()?;
            if 2 * step >= steps {
                let states = states(&air)?;
                let momentum: f64 = states.iter().map(|(excess, u)| (1.0 + excess) * u[0]).sum();
                sum += momentum / states.len() as f64;
                samples += 1.0;
            }
        }
    }
    session.progress_to(session.done + 1e-6 * (steps * cells.iter().product::<usize>()) as f64);
    // The bare velocity lacks half of a step's force. Markers act as the uniform force does, and take as much in the mean; walls that cut links do not.
    let half = match opening.wall {
        Wall::Markers(_) => 0.0,
        Wall::Cut | Wall::CutWithLaw => 0.5 * pressure / length,
    };
    let mean = sum / samples + half;
    Ok((cells, mean / open / (2.0 * pressure).sqrt()))
}

/// The plate, whichever way it meets the air.
enum Plate {
    Markers(Box<MarkedPlate>),
    Cut(Box<CutPlate>),
}

struct MarkedPlate {
    markers: MarkerEngine,
    positions: Vec<[f64; 3]>,
    at_rest: Vec<[f64; 3]>,
}

struct CutPlate {
    surface: CutSurface,
    positions: Vec<DVec3>,
    at_rest: Vec<DVec3>,
}

impl Plate {
    /// One step of the air.
    fn advance(&mut self, air: &mut AirEngine, acceleration: Option<[f64; 3]>) -> Result<(), Stop> {
        let left = || Stop::Refused("the plate left the duct".to_owned());
        match self {
            Self::Markers(plate) => {
                let (markers, positions) = (&mut plate.markers, &plate.positions);
                markers.send_markers(air, positions)?.map_err(|_| left())?;
                markers.interpolate(air, positions)?.map_err(|_| left())?;
                markers.fetch_air_velocities()?;
                markers.send_marker_forces(&plate.at_rest);
                markers.spread(&plate.at_rest);
                air.collide_stream(acceleration, Some(markers))?;
            }
            Self::Cut(plate) => {
                air.collide_stream(acceleration, None)?;
                let surface = &mut plate.surface;
                surface.find_links(&plate.positions).map_err(|_| left())?;
                surface.read_links(air)?;
                surface.fetch_links(air, &plate.at_rest)?;
                surface.bounce(air, &plate.at_rest)?;
            }
        }
        Ok(())
    }
}

/// A plate of markers, which stand `inset` inside the rim, in a duct of so many cells across and along a slot.
fn marked_plate(
    air: &AirEngine,
    opening: Opening,
    inset: f64,
    [side, depth]: [usize; 2],
) -> Result<MarkedPlate, Stop> {
    let Opening {
        width,
        is_slot,
        offset,
        ..
    } = opening;
    let (repeated, pitch) = (opening.repeated(), opening.pitch());
    let (mut positions, mut areas) = (Vec::new(), Vec::new());
    let gap = width + 2.0 * inset;
    let (solid, solid_length) = parts(gap, pitch);
    let (hole, hole_length) = parts(0.0, gap);
    let across = || {
        let solid = solid.iter().map(|&at| (at, solid_length, true));
        solid.chain(hole.iter().map(|&at| (at, hole_length, false)))
    };
    let along: Vec<(f64, f64, bool)> = if is_slot {
        let (middles, length) = parts(0.0, depth as f64);
        middles.into_iter().map(|at| (at, length, false)).collect()
    } else {
        across().collect()
    };
    let place = |at: f64, number: i32, cells: usize| {
        (at + offset + pitch * f64::from(number)) % cells as f64 - 0.5
    };
    for (k, l) in
        (0..repeated).flat_map(|k| (0..if is_slot { 1 } else { repeated }).map(move |l| (k, l)))
    {
        for &(z, height, beside) in &along {
            for (y, breadth, above) in across() {
                if beside || above {
                    positions.push([PLATE * side as f64, place(y, k, side), place(z, l, depth)]);
                    areas.push(breadth * height);
                }
            }
        }
    }
    Ok(MarkedPlate {
        markers: MarkerEngine::new(air, areas, 1.6)?,
        at_rest: vec![[0.0; 3]; positions.len()],
        positions,
    })
}

/// A plate of triangles in such a duct, no longer than [`EDGE_CELLS`] where openings have a law.
fn cut_plate(air: &AirEngine, opening: Opening, [side, depth]: [usize; 2]) -> CutPlate {
    let has_law = opening.wall == Wall::CutWithLaw;
    let edge = if has_law { EDGE_CELLS } else { f64::INFINITY };
    let across = lines(opening, side, edge);
    let along = if opening.is_slot {
        between(0.0, depth as f64, edge)
            .map(|from| (from, false))
            .chain([(depth as f64, false)])
            .collect()
    } else {
        across.clone()
    };
    let x = PLATE * side as f64;
    let place = |at: f64| at + opening.offset - 0.5;
    let positions: Vec<DVec3> = (along.iter())
        .flat_map(|(z, _)| (across.iter()).map(|(y, _)| DVec3::new(x, place(*y), place(*z))))
        .collect();
    let (mut triangles, mut passages) = (Vec::new(), Vec::new());
    let (columns, rows) = (across.len(), along.len());
    for row in 0..rows - 1 {
        for column in 0..columns - 1 {
            let is_open = across[column].1 && (opening.is_slot || along[row].1);
            if is_open && !has_law {
                continue;
            }
            let corner = |r: usize, c: usize| ((row + r) * columns + column + c) as u32;
            let (a, b, c, d) = (corner(0, 0), corner(0, 1), corner(1, 1), corner(1, 0));
            triangles.extend([[a, b, c], [a, c, d]]);
            let passage = if is_open {
                Passage::Opening
            } else {
                Passage::Shut
            };
            passages.extend([passage; 2]);
        }
    }
    let areas: Vec<f64> = (triangles.iter())
        .map(|nodes| {
            let [a, b, c] = nodes.map(|node: u32| positions[node as usize]);
            0.5 * (b - a).cross(c - a).length()
        })
        .collect();
    let surface = CutSurface::new(air, triangles, positions.len(), (0, Some(0)));
    CutPlate {
        at_rest: vec![DVec3::ZERO; positions.len()],
        surface: surface.permeable(&passages, &areas),
        positions,
    }
}

/// Where equal parts of `from..to`, no longer than `edge`, begin.
fn between(from: f64, to: f64, edge: f64) -> impl Iterator<Item = f64> {
    let count = ((to - from) / edge).ceil().max(1.0);
    (0..count as usize).map(move |k| from + (to - from) * k as f64 / count)
}

/// Lines of nodes across the plate, and whether an opening begins there; the last one ends the plate. An opening with a law lies in the middle of fabric.
fn lines(opening: Opening, side: usize, edge: f64) -> Vec<(f64, bool)> {
    let mut lines = Vec::new();
    let before = match opening.wall {
        Wall::CutWithLaw => (0.5 * (opening.pitch() - opening.width)).floor(),
        _ => 0.0,
    };
    let fabric = |from: f64, to: f64, lines: &mut Vec<(f64, bool)>| {
        if to > from {
            lines.extend(between(from, to, edge).map(|at| (at, false)));
        }
    };
    for number in 0..opening.repeated() {
        let from = opening.pitch() * f64::from(number);
        let rim = from + before;
        fabric(from, rim, &mut lines);
        lines.push((rim, true));
        fabric(rim + opening.width, from + opening.pitch(), &mut lines);
    }
    lines.push((side as f64, false));
    lines
}
