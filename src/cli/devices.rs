//! `ripstop devices`

use std::fmt::Write;

use super::failure::Failure;
use super::log::emit;
use crate::gpu::AdapterChoice;
use crate::gpu::adapters::{adapters, chosen};

fn megabytes(bytes: u64) -> String {
    format!("{} MB", bytes / 1_000_000)
}

pub(super) fn devices() -> Result<u8, Failure> {
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
            None if automatic == Some(info) => "taken by --engine auto".to_owned(),
            None => "usable by --adapter or --engine gpu".to_owned(),
        };
        let _ = writeln!(text, "  verdict  {verdict}\n");
    }
    if found.is_empty() {
        text.push_str(
            "no adapter found (on Linux: a Vulkan driver and libvulkan1; mesa-vulkan-drivers has a software one)\n\n",
        );
    }
    text.push_str(&match automatic {
        Some(info) => format!(
            "--engine auto computes the air on {}: the first usable of discrete, integrated, virtual GPUs\n",
            info.name
        ),
        None => "--engine auto computes on CPU threads: there is no GPU, and a software adapter, slower than the native CPU engine, is \
                 taken only on request (--engine gpu or --adapter NAME)\n"
            .to_owned(),
    });
    emit(&text)?;
    Ok(0)
}
