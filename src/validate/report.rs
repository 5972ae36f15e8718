//! The rows of a validation, as a table and as JSON.

use std::io;
use std::path::Path;

use serde::Serialize;

use crate::gpu::Device;
use crate::output::{OutputError, write_atomically};
use crate::plan::{AirPlacement, Placement, Precision};

/// Version of the layout of the JSON file.
const SCHEMA_VERSION: u32 = 1;

/// What a quantity must keep to.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Gate {
    /// The value itself is an error: at most so large.
    AtMost(f64),
    /// The value is at least so large.
    AtLeast(f64),
    /// The value lies within this relative distance of the reference.
    Within(f64),
}

/// One quantity.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Row {
    /// Name of the problem.
    pub problem: &'static str,
    /// The quantity, a plain number.
    pub quantity: String,
    /// Its value; not finite where the flow broke down (`null` in the file).
    pub value: f64,
    /// What it should be.
    pub reference: Option<f64>,
    /// Where the reference comes from.
    pub source: Option<&'static str>,
    /// (value − reference)/|reference|; `None` without a reference or for one of zero.
    pub error: Option<f64>,
    /// What it must keep to; `None` for a number that is only stated.
    pub gate: Option<Gate>,
    /// Whether it does; `None` without a gate.
    pub holds: Option<bool>,
    /// Time since the row before [s].
    pub seconds: f64,
    /// Cells along x, y, z; zero where there is no air.
    pub cells: [usize; 3],
    /// Nodes of the structure, where there is one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub nodes: Option<usize>,
    /// Panels or rings of vortices, where a row is about these.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub panels: Option<usize>,
    /// What computed this row, where it is not the engine of the report.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub engine: Option<&'static str>,
    /// Whether gates apply: they are meant for populations in 32 and 64 bits.
    #[serde(skip)]
    pub(super) is_judged: bool,
}

impl Row {
    pub(super) fn new(
        problem: &'static str,
        quantity: String,
        value: f64,
        cells: [usize; 3],
        seconds: f64,
    ) -> Self {
        Self {
            problem,
            quantity,
            value,
            reference: None,
            source: None,
            error: None,
            gate: None,
            holds: None,
            seconds,
            cells,
            nodes: None,
            panels: None,
            engine: None,
            is_judged: true,
        }
    }

    /// Adds what the value should be, and who says so.
    pub(super) fn reference(&mut self, reference: f64, source: &'static str) -> &mut Self {
        self.reference = Some(reference);
        self.source = Some(source);
        self.error = (reference != 0.0).then(|| (self.value - reference) / reference.abs());
        self
    }

    /// Adds what the value must keep to. A value that is not a number keeps to nothing. No effect on rows that are not judged.
    pub(super) fn gate(&mut self, gate: Gate) -> &mut Self {
        if !self.is_judged {
            return self;
        }
        self.gate = Some(gate);
        self.holds = Some(match gate {
            Gate::AtMost(limit) => self.value.abs() <= limit,
            Gate::AtLeast(limit) => self.value >= limit,
            Gate::Within(limit) => self.error.is_some_and(|error| error.abs() <= limit),
        });
        self
    }
}

/// The machine that computed.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct Machine {
    /// Operating system and architecture.
    pub system: String,
    /// Processor, as it names itself, if it does.
    pub processor: Option<String>,
    /// Threads used.
    pub threads: usize,
    /// Device, if one computed.
    pub device: Option<String>,
}

/// All rows, and what computed them.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Report {
    /// Version of the layout; raised when a field changes its meaning or goes away.
    pub schema_version: u32,
    /// Version of Ripstop.
    pub ripstop_version: &'static str,
    /// Commit, where the build was told (`RIPSTOP_COMMIT`).
    pub commit: Option<&'static str>,
    /// The machine.
    pub machine: Machine,
    /// `cpu` or `gpu`.
    pub engine: &'static str,
    /// Floating-point type of the air.
    pub precision: &'static str,
    /// `quick` or `full`.
    pub set: &'static str,
    /// True if it was interrupted: problems are missing.
    pub interrupted: bool,
    /// The rows.
    pub rows: Vec<Row>,
}

impl Report {
    /// A report without rows, as of a validation that has not got anywhere yet.
    #[must_use]
    pub fn new(full: bool, air: AirPlacement, device: Option<&Device>) -> Self {
        let placement = Placement {
            air,
            ..Placement::from(Precision::F32)
        };
        let processor = sysinfo::System::new().ok().and_then(|mut system| {
            system.refresh_cpu_all();
            let brand = system.cpus().first()?.brand().trim().to_owned();
            (!brand.is_empty()).then_some(brand)
        });
        Self {
            schema_version: SCHEMA_VERSION,
            ripstop_version: env!("CARGO_PKG_VERSION"),
            commit: option_env!("RIPSTOP_COMMIT"),
            machine: Machine {
                system: format!("{} {}", std::env::consts::OS, std::env::consts::ARCH),
                processor,
                threads: rayon::current_num_threads(),
                device: device.map(|d| d.info().name.clone()),
            },
            engine: placement.engine(),
            precision: placement.precision_name(),
            set: if full { "full" } else { "quick" },
            interrupted: true,
            rows: Vec::new(),
        }
    }

    pub(super) fn add(&mut self, row: Row) -> &mut Row {
        self.rows.push(row);
        let last = self.rows.len() - 1;
        &mut self.rows[last]
    }

    /// True if no gate fails.
    #[must_use]
    pub fn holds(&self) -> bool {
        self.rows.iter().all(|row| row.holds != Some(false))
    }

    /// The rows as an aligned table, one line each, and a line that sums up.
    #[must_use]
    pub fn table(&self) -> String {
        let head = [
            "problem",
            "quantity",
            "value",
            "reference",
            "error",
            "gate",
            "verdict",
            "s",
            "size",
            "engine",
        ];
        let engine = format!("{} {}", self.engine, self.precision);
        let mut lines = vec![head.map(str::to_owned)];
        lines.extend(self.rows.iter().map(|row| {
            [
                row.problem.to_owned(),
                row.quantity.clone(),
                number(row.value),
                row.reference.map_or_else(dash, number),
                row.error
                    .map_or_else(dash, |e| format!("{:+.2} %", 100.0 * e)),
                row.gate.map_or_else(dash, |gate| match gate {
                    Gate::AtMost(limit) => format!("<= {}", number(limit)),
                    Gate::AtLeast(limit) => format!(">= {}", number(limit)),
                    Gate::Within(limit) => format!("+-{} %", number(100.0 * limit)),
                }),
                match row.holds {
                    Some(true) => "holds".to_owned(),
                    Some(false) => "FAILS".to_owned(),
                    None => dash(),
                },
                format!("{:.1}", row.seconds),
                match (row.nodes, row.panels) {
                    (Some(nodes), _) => format!("{nodes} nodes"),
                    (None, Some(panels)) => format!("{panels} panels"),
                    (None, None) if row.cells == [0; 3] => dash(),
                    (None, None) => format!("{}x{}x{}", row.cells[0], row.cells[1], row.cells[2]),
                },
                row.engine.map_or_else(|| engine.clone(), str::to_owned),
            ]
        }));
        let widths: [usize; 10] = std::array::from_fn(|column| {
            let lengths = lines.iter().map(|line| line[column].chars().count());
            lengths.max().unwrap_or(0)
        });
        let mut text = String::new();
        for line in &lines {
            let padded: Vec<String> = line
                .iter()
                .zip(widths)
                .enumerate()
                .map(|(column, (entry, width))| match column {
                    2..=5 | 7 => format!("{entry:>width$}"),
                    _ => format!("{entry:<width$}"),
                })
                .collect();
            text.push_str(padded.join("  ").trim_end());
            text.push('\n');
        }
        if self.rows.iter().any(|row| !row.is_judged) {
            text.push_str(
                "gates are meant for 32 and 64 bits: values of populations kept in 16 bits are stated without\n",
            );
        }
        let gated = self.rows.iter().filter(|row| row.holds.is_some()).count();
        let failing = self.rows.iter().filter(|row| row.holds == Some(false));
        text.push_str(&format!(
            "{gated} gates, {} fail; {} set, {:.0} s{}\n",
            failing.count(),
            self.set,
            self.rows.iter().map(|row| row.seconds).sum::<f64>(),
            if self.interrupted {
                "; interrupted, problems are missing"
            } else {
                ""
            }
        ));
        text
    }

    /// Writes the report as JSON.
    pub fn write(&self, path: &Path) -> Result<(), OutputError> {
        write_atomically(path, |out| {
            serde_json::to_writer_pretty(&mut *out, self).map_err(io::Error::other)?;
            out.write_all(b"\n")
        })
    }
}

fn dash() -> String {
    "-".to_owned()
}

/// Four digits, with an exponent where they would be lost in zeros.
fn number(value: f64) -> String {
    let size = value.abs();
    if value == 0.0 {
        "0".to_owned()
    } else if !value.is_finite() {
        "not finite".to_owned()
    } else if (1e-3..1e4).contains(&size) {
        let digits = 3 - size.log10().floor() as i32;
        let text = format!("{value:.*}", digits.max(0) as usize);
        if text.contains('.') {
            text.trim_end_matches('0').trim_end_matches('.').to_owned()
        } else {
            text
        }
    } else {
        format!("{value:.2e}")
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plan::Storage;

    fn row(value: f64) -> Row {
        Row::new("couette", "error".to_owned(), value, [4; 3], 0.0)
    }

    #[test]
    fn gates_judge() {
        let mut exact = row(1.04);
        exact.reference(1.0, "theory");
        assert_eq!(exact.gate(Gate::Within(0.05)).holds, Some(true));
        assert_eq!(exact.gate(Gate::Within(0.03)).holds, Some(false));
        assert_eq!(row(1.95).gate(Gate::AtLeast(1.9)).holds, Some(true));
        assert_eq!(row(1.85).gate(Gate::AtLeast(1.9)).holds, Some(false));
        assert_eq!(row(-2e-6).gate(Gate::AtMost(1e-6)).holds, Some(false));
        for gate in [Gate::Within(1.0), Gate::AtLeast(0.0), Gate::AtMost(1.0)] {
            let mut broken = row(f64::NAN);
            broken.reference(1.0, "theory");
            assert_eq!(broken.gate(gate).holds, Some(false), "{gate:?}");
        }
    }

    /// Populations in 16 bits miss gates of order and conservation by far; the table says that none apply.
    #[test]
    fn what_is_not_judged_has_no_gate() {
        let mut report = Report::new(false, AirPlacement::Gpu(Storage::F16), None);
        let mut stated = row(7.0);
        stated.is_judged = false;
        stated.gate(Gate::AtMost(1.0));
        assert_eq!((stated.gate, stated.holds), (None, None));
        report.add(stated);
        let table = report.table();
        assert!(report.holds() && table.contains("0 gates"), "{table}");
        assert!(table.contains("stated without"), "{table}");
    }

    #[test]
    fn one_failing_gate_fails_the_report() {
        let mut report = Report::new(false, AirPlacement::Gpu(Storage::F32), None);
        report.add(row(0.1)).gate(Gate::AtMost(1.0));
        report.add(row(7.0));
        assert!(report.holds());
        report.add(row(0.1)).gate(Gate::AtMost(0.01));
        assert!(!report.holds());
        let table = report.table();
        assert!(table.contains("2 gates, 1 fail"), "{table}");
        assert_eq!(table.matches("FAILS").count(), 1, "{table}");
    }

    #[test]
    fn numbers_keep_four_digits() {
        for (value, text) in [
            (0.0, "0"),
            (1.9, "1.9"),
            (2.0, "2"),
            (0.118_435_75, "0.1184"),
            (1234.56, "1235"),
            (100.0, "100"),
            (3.2e-7, "3.20e-7"),
            (f64::NAN, "not finite"),
        ] {
            assert_eq!(number(value), text);
        }
    }
}
