//! A run stored and taken up again by a fresh simulation, as between two calls of the program.

use ripstop::checkpoint;
use ripstop::simulation::Simulation;

/// `fresh` with the state of `run`, by way of a checkpoint on disk.
pub fn taken_up(run: &mut Simulation, mut fresh: Simulation) -> Simulation {
    let folder = tempfile::tempdir().unwrap();
    checkpoint::write(folder.path(), "test", |out| run.save(out)).unwrap();
    let stored = checkpoint::open(folder.path(), "test").unwrap().reader;
    fresh.restore(&stored).unwrap();
    fresh
}

/// Bits of all places and velocities of the nodes.
pub fn bits_of_nodes(simulation: &Simulation) -> Vec<u64> {
    let cloth = simulation.cloth().unwrap();
    let both = cloth.positions_m.iter().chain(&cloth.velocities_m_s);
    both.flat_map(|v| v.to_array()).map(f64::to_bits).collect()
}
