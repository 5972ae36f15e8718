//! Long runs: what they keep in memory and in checkpoints does not grow with the samples.

use std::path::Path;

use libtest_mimic::Trial;
use ripstop::case::{self, Choices};
use ripstop::checkpoint;
use ripstop::measure::{Record, SAMPLES_FILE};
use ripstop::plan::{Plan, Precision};
use ripstop::simulation::Simulation;

use crate::engines::plain;

pub fn trials() -> Vec<Trial> {
    plain(
        "long_histories::checkpoints_do_not_grow_with_samples",
        checkpoints,
    )
}

/// A chain that is sampled in every step, and goes on from a checkpoint: its file of samples grows, its checkpoint does not, and the
/// columns are those of a record that kept everything in memory.
fn checkpoints() {
    let source = include_str!("../cases/cloth/hanging-chain.toml");
    let case = case::parse("chain", source, Path::new("."), &Choices::default()).unwrap();
    let scene = &case.scene;
    let new = || Simulation::new(scene.clone(), Plan::new(scene, Precision::F64), None).unwrap();
    let folder = tempfile::tempdir().unwrap();
    let mut simulation = new();
    let (mut in_file, mut in_memory) = (Record::new(&simulation), Record::new(&simulation));
    in_file.keep_in(folder.path()).unwrap();
    let mut samples = |count: usize, in_file: &mut Record| {
        for _ in 0..count {
            in_file.add(&mut simulation).unwrap();
            in_memory.add(&mut simulation).unwrap();
        }
        checkpoint::write(folder.path(), "test", |out| {
            simulation.save(out)?;
            in_file.save(out)
        })
        .unwrap();
        let bytes = |name| std::fs::metadata(folder.path().join(name)).unwrap().len();
        (bytes(checkpoint::FILE_NAME), bytes(SAMPLES_FILE))
    };
    let few = samples(300, &mut in_file);
    let many = samples(7_000, &mut in_file);
    // A block of 256 samples is in the checkpoint at most.
    let row_bytes = 8 * in_file.columns().len() as u64;
    assert!(many.0 < few.0 + 256 * row_bytes, "{few:?} {many:?}");
    assert!(many.1 >= few.1 + 6_500 * row_bytes, "{few:?} {many:?}");
    // What was written after the checkpoint is forgotten.
    for _ in 0..600 {
        in_file.add(&mut simulation).unwrap();
    }
    drop(in_file);
    let stored = checkpoint::open(folder.path(), "test").unwrap().reader;
    let mut resumed = Record::new(&new());
    resumed.restore(&stored, folder.path()).unwrap();
    assert_eq!(resumed.sample_count(), 7_300);
    let bits = |values: Vec<f64>| values.into_iter().map(f64::to_bits).collect::<Vec<_>>();
    for column in in_memory.columns() {
        assert_eq!(
            bits(resumed.column(column)),
            bits(in_memory.column(column)),
            "{}",
            column.name
        );
    }
    // A file that is not what the checkpoint says is not gone on from.
    let path = folder.path().join(SAMPLES_FILE);
    let mut bytes = std::fs::read(&path).unwrap();
    bytes[1000] ^= 4;
    std::fs::write(&path, bytes).unwrap();
    let refused = Record::new(&new()).restore(&stored, folder.path());
    assert!(refused.unwrap_err().to_string().contains(SAMPLES_FILE));
}
