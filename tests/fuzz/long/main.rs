//! One reader under libFuzzer: `RIPSTOP_FUZZ_READER` names it, `tests/fuzz/run` starts it.

#![no_main]
#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    reason = "nobody but a developer runs it"
)]

#[path = "../mutation.rs"]
mod mutation;
#[path = "../targets.rs"]
mod targets;

use std::cell::RefCell;
use std::path::{Path, PathBuf};
use std::sync::LazyLock;

use libfuzzer_sys::{fuzz_mutator, fuzz_target, fuzzer_mutate};
use targets::{Reader, Target};

fn cases() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../cases")
}

fn reader() -> Reader {
    let name = std::env::var("RIPSTOP_FUZZ_READER").unwrap_or_default();
    Reader::named(&name).expect("RIPSTOP_FUZZ_READER names a reader")
}

/// What foreign parts are taken from.
static SEEDS: LazyLock<Vec<Vec<u8>>> = LazyLock::new(|| {
    let seeds = targets::seeds(reader(), &cases());
    // Where the script wants the seeds as files, for libFuzzer to begin with.
    if let Some(folder) = std::env::var_os("RIPSTOP_FUZZ_SEEDS") {
        for (number, seed) in seeds.iter().enumerate() {
            std::fs::write(Path::new(&folder).join(format!("seed-{number:03}")), seed).unwrap();
        }
    }
    seeds
});

/// What reader, fuzzer and its corpus may take beyond what the process has at the start [bytes].
const MEMORY: u64 = 4 << 30;

thread_local! {
    static TARGET: RefCell<Target> = RefCell::new(Target::new(reader(), &cases()));
}

fuzz_target!(init: {
    LazyLock::force(&SEEDS);
    targets::limit_memory(MEMORY);
}, |input: &[u8]| {
    TARGET.with_borrow_mut(|target| target.read(input));
});

fuzz_mutator!(|data: &mut [u8], size: usize, longest: usize, seed: u32| {
    let mut random = fastrand::Rng::with_seed(u64::from(seed));
    // Half of the changes are libFuzzer's own, which know what the reader compares its input with.
    if random.bool() {
        return fuzzer_mutate(data, size, longest);
    }
    let mut input = data[..size].to_vec();
    let other = &SEEDS[random.usize(..SEEDS.len())];
    mutation::mutate(&mut input, other, &mut random);
    let length = input.len().min(longest);
    data[..length].copy_from_slice(&input[..length]);
    length
});
