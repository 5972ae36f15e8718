//! The input file of LEparagliding (`leparagliding.txt`, versions 2.x and 3.x): numbered sections of plain lines. Lengths in it are centimetres of the
//! drawing, which the wing scale multiplies.

use super::rods::{self, RodGroup};
use super::sections::{ReadFault, Section, Sections, numbers, unquoted};
use super::skin_tension::SkinTension;
use super::speed::SpeedStudy;

/// m of a centimetre.
pub(super) const CENTIMETRE_M: f64 = 0.01;

/// A rib, from the middle outwards.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Rib {
    /// Place along the flat span [cm].
    pub span: f64,
    /// Leading and trailing edge [cm].
    pub edges: [f64; 2],
    /// Lean to the vertical [°].
    pub lean_deg: f64,
    /// Washin as written [°].
    pub washin_deg: f64,
    /// File of its profile.
    pub profile: String,
    /// Intake, per cent of the chord.
    pub intake: [f64; 2],
    /// Whether the cell on its inner side is open.
    pub is_open: bool,
    /// Length of a mini-rib on its inner side, per cent of the chord; 0 or 1: none.
    pub mini_rib: f64,
    /// Share of the load over that of its chord.
    pub weight: f64,
    /// Places of the rows A, B, C, …, per cent of the chord; lines lead to the first `anchor_count`, V- and H-ribs to any that is not 0.
    pub anchors: Vec<f64>,
    pub anchor_count: usize,
}

/// A way from the riser up to an anchor.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Path {
    /// Order of the line in every level above the riser, or the brakes' main line, from below.
    pub lines: Vec<usize>,
    /// Row: 1 is A; 6 is the brakes.
    pub row: usize,
    /// Number of the rib in the file, from 1; of brakes it may lie between two.
    pub rib: f64,
}

/// Lengths of upper lines, for three and for four levels: from the sail to the nodes, the lowest first [cm].
pub(super) type Branches = [Vec<f64>; 2];

/// What a file says.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Drawing {
    pub name: String,
    /// Cells, as they are told.
    pub cells: usize,
    /// Of all lengths but risers and karabiners.
    pub scale: f64,
    /// Washin at the tip and in the middle [°], and how it follows: 0 as written, 1 and 2 by the chord.
    pub washin_deg: [f64; 2],
    pub washin_rule: i64,
    pub ribs: Vec<Rib>,
    /// Place of the hang point, per cent of the middle chord.
    pub calage: f64,
    /// Lengths of risers, of lines with the drawing's scale, distance of the karabiners [cm].
    pub riser: f64,
    pub lines: f64,
    pub karabiners: f64,
    /// What lines point to: means of attachments (0; 1 and 2 come to the same in the program), or of their loads (3).
    pub aim: i64,
    /// Shares of the load that the rows of a rib with 2, 3, … of them take [%]; empty where they cannot be read.
    pub row_shares: Vec<Vec<f64>>,
    /// Paths of every riser, from the nose.
    pub plans: Vec<Vec<Path>>,
    /// Length of the brakes' main line [cm], and their paths.
    pub brake_main: f64,
    pub brakes: Vec<Path>,
    /// Brakes are longer at some places along the span than at others.
    pub brakes_are_spread: bool,
    /// Of lines, and of brakes.
    pub branches: [Branches; 2],
    /// Groups of rods, or why they cannot be read.
    pub rods: Result<Vec<RodGroup>, ReadFault>,
    /// How much wider panels are than the distance of their ribs, or why that cannot be read.
    pub skin_tension: Result<SkinTension, ReadFault>,
    /// Study of the speed system; `None`: there is none.
    pub speed_study: Option<SpeedStudy>,
}

/// Levels of lines that the format has, with the riser.
const MOST_LEVELS: usize = 4;

/// Paths, each with its number of levels, pairs of level and order, row and rib.
fn paths(section: &mut Section, count: usize) -> Result<Vec<Path>, ReadFault> {
    (0..count)
        .map(|_| {
            let row = section.numbers(7)?;
            let levels = row[0] as usize;
            if !(1..=MOST_LEVELS).contains(&levels) {
                return Err(ReadFault::Levels(levels));
            }
            let ends = [row[row.len() - 2], row[row.len() - 1]];
            let orders = row[1..row.len() - 2].chunks_exact(2).take(levels);
            // The first level is the riser, or the main line of the brakes.
            let lines: Vec<usize> = orders.skip(1).map(|pair| pair[1] as usize).collect();
            Ok(Path {
                lines,
                row: ends[0] as usize,
                rib: ends[1],
            })
        })
        .collect()
}

/// Of lines of three and four levels.
fn branches(section: &mut Section) -> Result<Branches, ReadFault> {
    // Each begins with the number of levels, and has a length for every node.
    let mut one = |nodes: usize| Ok(section.numbers(1 + nodes)?[1..=nodes].to_vec());
    Ok([one(1)?, one(2)?])
}

/// Shares of the load by the number of rows, from 2 on, in section 18.
fn row_shares(sections: &Sections) -> Result<Vec<Vec<f64>>, ReadFault> {
    let mut section = sections.get(18, "elastic lines")?;
    section.number()?;
    let shares = |rows: usize| section.numbers(rows).unwrap_or_default();
    Ok((2..=5).map(shares).collect())
}

/// Chord over that of the next rib towards the middle above which one of both is a slip of the pen.
const MOST_GROWTH: f64 = 2.0;

/// Kind of a wing: `ds` of two skins, `ss` of one, `pc` of a parachute. Files of the latter hold other things in the sections that follow.
pub(super) fn kind(text: &str) -> Result<String, ReadFault> {
    let sections = Sections::new(text);
    let mut geometry = sections.get(1, "geometry")?;
    for _ in 0..7 {
        geometry.line()?;
    }
    Ok(unquoted(geometry.line()?))
}

impl Drawing {
    /// True where the first rib stands in the middle: the number of cells is even, whatever the file counts.
    pub(super) fn has_middle_rib(&self) -> bool {
        self.ribs[0].span.abs() < 1e-6
    }

    /// Intake of the open cells, over the chord; `None`: no cell is open.
    pub(super) fn intake(&self) -> Option<[f64; 2]> {
        let mut ribs = self.ribs.iter();
        let open = ribs.find(|rib| rib.is_open && rib.intake[1] > rib.intake[0])?;
        let [from, to] = open.intake.map(|place| 0.01 * place);
        Some([from.max(0.002), to])
    }

    pub(super) fn read(text: &str) -> Result<Self, ReadFault> {
        let sections = Sections::new(text);
        let mut geometry = sections.get(1, "geometry")?;
        geometry.line()?;
        let name = unquoted(geometry.line()?);
        geometry.number()?;
        let scale = geometry.number()?;
        let cells = geometry.number()? as usize;
        let rib_count = geometry.number()?;
        let washin = geometry.numbers(2)?;
        geometry.line()?;
        // Rib, x, leading and trailing edge, x in space, z, lean, axis of the washin, washin.
        let placed = geometry.rows(8);
        if scale <= 0.0 {
            return Err(ReadFault::Length("the wing scale, section 1,"));
        }
        let mut airfoils = sections.get(2, "airfoils")?;
        let anchors = sections.get(3, "anchor points")?.rows(3);
        let mut ribs: Vec<Rib> = Vec::new();
        for (row, anchors) in placed.iter().zip(&anchors) {
            if row[0] != (ribs.len() + 1) as f64 {
                return Err(ReadFault::Rib(ribs.len() + 1));
            }
            let line = airfoils.line()?;
            // Ribs are numbered alike in all three sections.
            if numbers(line).first() != row.first() || anchors.first() != row.first() {
                return Err(airfoils.fault(line));
            }
            if row[3] <= row[2] {
                return Err(ReadFault::Length("the chord of a rib, section 1,"));
            }
            let mut words = line.split_whitespace().skip(1);
            let profile = words.next().unwrap_or_default().to_owned();
            let rest: Vec<f64> = words.map_while(|word| word.parse().ok()).collect();
            if rest.len() < 3 {
                return Err(airfoils.fault(line));
            }
            if let Some(inner) = ribs.last()
                && row[1] <= inner.span
            {
                return Err(ReadFault::Order(ribs.len() + 1));
            }
            let chord = row[3] - row[2];
            if let Some(inner) = ribs.last()
                && chord > MOST_GROWTH * (inner.edges[1] - inner.edges[0])
            {
                return Err(ReadFault::Chord(ribs.len() + 1));
            }
            ribs.push(Rib {
                span: row[1],
                edges: [row[2], row[3]],
                lean_deg: row[6],
                washin_deg: row.get(8).copied().unwrap_or(0.0),
                profile,
                intake: [rest[0], rest[1]],
                is_open: rest[2] != 0.0,
                mini_rib: rest.get(5).copied().unwrap_or(0.0),
                weight: rest.get(4).copied().unwrap_or(1.0),
                anchors: anchors[2..].to_vec(),
                anchor_count: anchors[1] as usize,
            });
        }
        if ribs.len() < 3 || ribs.len() < placed.len() {
            let (number, name) = (3, "anchor points");
            return Err(ReadFault::Section { number, name });
        }
        // Both halves; one in the middle is counted once, or twice by some.
        let counts = [2 * ribs.len(), 2 * ribs.len() - 1];
        if !counts.contains(&(rib_count as usize)) {
            return Err(ReadFault::RibCount {
                told: rib_count as usize,
                found: ribs.len(),
            });
        }
        let mut estimate = sections.get(8, "angle of attack")?;
        let [_, _, calage, riser, lines, karabiners] = [
            estimate.number()?,
            estimate.number()?,
            estimate.number()?,
            estimate.number()?,
            estimate.number()?,
            estimate.number()?,
        ];
        if lines <= 0.0 || riser <= 0.0 || karabiners <= 0.0 {
            return Err(ReadFault::Length("a length of section 8"));
        }
        let mut suspension = sections.get(9, "suspension lines")?;
        let aim = suspension.number()? as i64;
        let plans = (0..suspension.count()?)
            .map(|_| {
                let count = suspension.count()?;
                paths(&mut suspension, count)
            })
            .collect::<Result<_, _>>()?;
        let mut braking = sections.get(10, "brakes")?;
        let brake_main = braking.number()?;
        let count = braking.count()?;
        let brakes = paths(&mut braking, count)?;
        if brake_main <= 0.0 && !brakes.is_empty() {
            return Err(ReadFault::Length(
                "the main line of the brakes, section 10,",
            ));
        }
        // Places along the span, and by how much brakes are longer there.
        let _places = braking.numbers(1);
        let spread = braking.numbers(1).unwrap_or_default();
        let mut lengths = sections.get(11, "ramification lengths")?;
        let branches = [branches(&mut lengths)?, branches(&mut lengths)?];
        Ok(Self {
            name,
            cells,
            scale,
            washin_deg: [washin[0], washin.get(2).copied().unwrap_or(0.0)],
            washin_rule: washin[1] as i64,
            ribs,
            calage,
            riser,
            lines,
            karabiners,
            aim,
            row_shares: row_shares(&sections).unwrap_or_default(),
            plans,
            brake_main,
            brakes_are_spread: spread.iter().any(|more| *more != 0.0),
            brakes,
            branches,
            rods: rods::read(&sections),
            skin_tension: SkinTension::read(&sections),
            speed_study: SpeedStudy::read(&sections),
        })
    }
}
