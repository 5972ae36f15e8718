//! When a run may stop because its mean drag is known.

use super::bodies::{BodyWindow, STEADY_WINDOW, Settling};
use super::canopy::{SHORTEST_WINDOW, mean, window};
use crate::measure::record::Record;
use crate::measure::shared::{DRAG_COEFFICIENT, TIME};
use crate::measure::statistics::Mean;
use crate::output::ReadOut;

/// Ratio of successive window lengths at which a run may end. A test at every sample would stop at the first lucky interval and
/// so understate the error; with few looks the interval keeps most of its meaning.
const LOOK_RATIO: f64 = 1.25;

/// Whose drag decides.
#[derive(Debug, Clone)]
enum Subject {
    /// A canopy's; its D₀/U [s].
    Canopy(f64),
    /// That of every rigid body.
    Bodies(Vec<Watched>),
}

/// A rigid body whose drag decides when a run may stop.
#[derive(Debug, Clone, PartialEq)]
pub struct Watched {
    /// Its name.
    pub name: String,
    /// Its columns of the record: drag, and the forces across the stream.
    pub columns: [ReadOut; 3],
    /// What its settling depends on.
    pub settling: Settling,
}

/// What is known of a mean drag.
struct Known {
    /// Length of the settled window, in units of the subject.
    length: f64,
    drag: Mean,
    /// A body's name, where there are several.
    of: String,
    /// Unit of time.
    unit: &'static str,
    how: &'static str,
}

/// Decides at a few window lengths whether a run may stop.
#[derive(Debug, Clone)]
pub struct Detector {
    subject: Subject,
    drag_confidence: f64,
    /// Window length of the next look [D₀/U, of bodies L/U].
    next_look: f64,
}

impl Detector {
    /// Detector for a canopy whose D₀/U is `unit_s`, stopping at a relative half width `drag_confidence` of the mean drag.
    #[must_use]
    pub const fn new(unit_s: f64, drag_confidence: f64) -> Self {
        Self {
            subject: Subject::Canopy(unit_s),
            drag_confidence,
            next_look: SHORTEST_WINDOW,
        }
    }

    /// The same for rigid bodies, each of whose drags must be known so well.
    #[must_use]
    pub const fn of_bodies(watched: Vec<Watched>, drag_confidence: f64) -> Self {
        Self {
            subject: Subject::Bodies(watched),
            drag_confidence,
            next_look: STEADY_WINDOW,
        }
    }

    /// Passes over the looks that a record from a checkpoint has had already.
    pub fn skip_looks(&mut self, record: &Record) {
        if let Some(length) = self.settled_length(record) {
            self.look_after(length);
        }
    }

    fn look_after(&mut self, length: f64) {
        while length >= self.next_look - 1e-6 {
            self.next_look *= LOOK_RATIO;
        }
    }

    /// Length of the settled window, of several bodies the shortest; `None` before all have settled.
    fn settled_length(&self, record: &Record) -> Option<f64> {
        match &self.subject {
            Subject::Canopy(unit_s) => {
                let window = window(record, *unit_s).filter(|w| w.settled)?;
                Some(window.length)
            }
            Subject::Bodies(watched) => watched
                .iter()
                .map(|body| body.window(record).map(|(window, _)| window.length))
                .try_fold(f64::INFINITY, |least, length| Some(least.min(length?))),
        }
    }

    /// The mean drag of the canopy, or of the body whose is known least.
    fn known(&self, record: &Record, length: f64) -> Option<Known> {
        match &self.subject {
            Subject::Canopy(unit_s) => Some(Known {
                length,
                drag: mean(record, &DRAG_COEFFICIENT, &window(record, *unit_s)?),
                of: String::new(),
                unit: "D_0/U",
                how: "batch means, 95 %",
            }),
            Subject::Bodies(watched) => {
                let mut least: Option<Known> = None;
                for body in watched {
                    let (window, column) = body.window(record)?;
                    let known = Known {
                        length: window.length,
                        drag: window.mean(&column),
                        of: match watched.len() {
                            1 => String::new(),
                            _ => format!(" of `{}`, known least,", body.name),
                        },
                        unit: "L/U",
                        how: window.how(),
                    };
                    let width = known.relative_width()?;
                    if least
                        .as_ref()
                        .and_then(Known::relative_width)
                        .is_none_or(|most| width > most)
                    {
                        least = Some(known);
                    }
                }
                least
            }
        }
    }

    /// A sentence saying why the run may stop now, or `None` to go on.
    pub fn reason_to_stop(&mut self, record: &Record) -> Option<String> {
        let length = self.settled_length(record)?;
        // As close as times of samples come.
        if length < self.next_look - 1e-6 {
            return None;
        }
        self.look_after(length);
        let known = self.known(record, length)?;
        let width = known.relative_width()?;
        (width <= self.drag_confidence).then(|| {
            format!(
                "steady: the mean drag coefficient{} {:.3} is known to ±{:.1} % ({}; asked for {:.1} %) over {:.1} {}",
                known.of,
                known.drag.value,
                100.0 * width,
                known.how,
                100.0 * self.drag_confidence,
                known.length,
                known.unit,
            )
        })
    }
}

impl Known {
    fn relative_width(&self) -> Option<f64> {
        Some(self.drag.confidence? / self.drag.value.abs())
    }
}

impl Watched {
    /// Its settled window, and the column of its drag; `None` before it has settled, or while it keeps a symmetry that its wake would lose.
    fn window(&self, record: &Record) -> Option<(BodyWindow, Vec<f64>)> {
        let [drag, lift, side] = self.columns.each_ref().map(|own| record.column(own));
        let window = BodyWindow::new(&record.column(&TIME), &drag, &self.settling)?;
        let counts = window.settled && !window.is_symmetric(&drag, [&lift, &side]);
        counts.then_some((window, drag))
    }
}
