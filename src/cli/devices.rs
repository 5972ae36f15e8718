//! `ripstop devices`

use std::fmt::Write;

use clap::Args;

use super::failure::Failure;
use super::log::emit;
use super::threads;
use crate::bench::pace;
use crate::gpu::adapters::{adapters, chosen};
use crate::gpu::{AdapterChoice, AdapterKind, Device};

#[derive(Debug, Args)]
pub(super) struct DevicesArguments {
    /// Measure how many cells of bare air each adapter and the CPU threads update per second, some seconds each.
    #[arg(long)]
    measure: bool,
    /// CPU threads to measure; 0 takes all cores.
    #[arg(long, default_value_t = 0, requires = "measure", value_parser = clap::value_parser!(u16).range(0..=256))]
    threads: u16,
}

fn megabytes(bytes: u64) -> String {
    format!("{} MB", bytes / 1_000_000)
}

/// Updates per second in millions, as a line.
fn pace_line(updates_per_s: f64) -> String {
    format!(
        "  measured {:.0} million updates of bare air per second, f32\n",
        1e-6 * updates_per_s
    )
}

pub(super) fn devices(arguments: &DevicesArguments) -> Result<u8, Failure> {
    if arguments.measure {
        threads::start(arguments.threads.into())?;
    }
    let found = adapters();
    let automatic = chosen(&found, &AdapterChoice::Hardware);
    let mut text = String::new();
    // Writing to a String cannot fail.
    for info in &found {
        let _ = writeln!(
            text,
            "{}\n  kind     {}, through {} ({})\n  limits   buffer {}, binding {}, {} storage buffers per shader",
            info.name,
            info.kind.name(),
            info.backend,
            info.driver,
            megabytes(info.buffer_limit_bytes),
            megabytes(info.binding_limit_bytes),
            info.storage_buffer_limit
        );
        let verdict = match info.shortcoming() {
            Some(why) => format!("not usable: it {why}"),
            None if automatic == Some(info) && info.kind == AdapterKind::Integrated => {
                "taken by --engine auto where it updates air a tenth faster than the CPU, which is measured when a run begins".to_owned()
            }
            None if automatic == Some(info) => "taken by --engine auto".to_owned(),
            None => "usable by --adapter or --engine gpu".to_owned(),
        };
        if arguments.measure && info.shortcoming().is_none() {
            let choice = AdapterChoice::Exactly(Box::new(info.clone()));
            match Device::open(&choice).and_then(|device| pace::of_device(&device)) {
                Ok(pace) => text.push_str(&pace_line(pace)),
                Err(error) => {
                    let _ = writeln!(text, "  measured nothing: {error}");
                }
            }
        }
        let _ = writeln!(text, "  verdict  {verdict}\n");
    }
    if arguments.measure {
        let _ = writeln!(text, "CPU, {} threads", rayon::current_num_threads());
        text.push_str(&pace_line(pace::of_cpu()));
        text.push('\n');
    }
    if found.is_empty() {
        text.push_str(
            "no adapter found (on Linux: a Vulkan driver and libvulkan1; mesa-vulkan-drivers has a software one)\n\n",
        );
    }
    text.push_str(&match automatic {
        Some(info) => format!(
            "--engine auto computes the air on {}: the first usable of discrete, integrated, virtual GPUs{}\n",
            info.name,
            if info.kind == AdapterKind::Integrated {
                ", if it updates air a tenth faster than the CPU"
            } else {
                ""
            }
        ),
        None => "--engine auto computes on CPU threads: there is no GPU, and a software adapter, slower than the native CPU engine, is \
                 taken only on request (--engine gpu or --adapter NAME)\n"
            .to_owned(),
    });
    emit(&text)?;
    Ok(0)
}
