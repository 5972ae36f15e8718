//! All tests that run the program or whole engines, as trials made at run time: one per engine, so that a device that is
//! missing shows as a skip, and as a failure where `RIPSTOP_REQUIRE_GPU=1`.

#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    reason = "tests fail by panicking"
)]

mod air;
mod architecture;
mod bad_cases;
mod canopy;
mod cases;
mod cloth;
mod command_line;
mod coupling;
mod device;
mod device_cloth;
mod engines;
mod tolerances;

use std::sync::atomic::{AtomicUsize, Ordering};

use libtest_mimic::{Arguments, Trial};

/// Counts what wgpu, and the validation layers through it, have to complain about.
struct Complaints;

static COMPLAINTS: AtomicUsize = AtomicUsize::new(0);

impl log::Log for Complaints {
    fn enabled(&self, metadata: &log::Metadata<'_>) -> bool {
        metadata.level() <= log::Level::Warn
    }

    fn log(&self, record: &log::Record<'_>) {
        if self.enabled(record.metadata()) && !expected(&record.args().to_string()) {
            COMPLAINTS.fetch_add(1, Ordering::Relaxed);
            eprintln!("{} {}: {}", record.level(), record.target(), record.args());
        }
    }

    fn flush(&self) {}
}

/// Messages that say nothing about this program.
fn expected(message: &str) -> bool {
    EXPECTED.iter().any(|part| message.contains(part))
}

/// Drivers without a window system or a conformance statement say so; one test destroys its device on purpose.
const EXPECTED: [&str; 3] = ["not conformant", "Parent device is lost", "Device lost"];

fn main() -> std::process::ExitCode {
    if log::set_logger(&Complaints).is_ok() {
        log::set_max_level(log::LevelFilter::Warn);
    }
    let arguments = Arguments::from_args();
    let trials: Vec<Trial> = [
        architecture::trials(),
        air::trials(),
        cloth::trials(),
        coupling::trials(),
        device::trials(),
        device_cloth::trials(),
        canopy::trials(),
        cases::trials(),
        bad_cases::trials(),
        command_line::trials(),
    ]
    .into_iter()
    .flatten()
    .collect();
    let conclusion = libtest_mimic::run(&arguments, trials);
    let complaints = COMPLAINTS.load(Ordering::Relaxed);
    if complaints > 0 {
        eprintln!("{complaints} messages of the graphics interface, above: none is allowed");
        return std::process::ExitCode::FAILURE;
    }
    conclusion.exit_code()
}
