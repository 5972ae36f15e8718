//! Energies of fabric and lines, and where they came from.

use super::read_out::Reduction::Last;
use super::read_out::{When, columns};
use super::record::Record;
use crate::case::Scene;
use crate::output::{Quantity, Results};
use crate::simulation::Energies;

static MOVES: When<Scene> = When {
    words: "",
    holds: moves,
};

static FALLS: When<Scene> = When {
    words: "with `[gravity]`, or with loads of single nodes",
    holds: |scene| {
        let loaded = |body: &crate::case::scene::Body| !body.structure.loads_n.is_empty();
        moves(scene) && (scene.gravity_m_s2.is_some() || scene.body.as_ref().is_some_and(loaded))
    },
};

static IN_AIR: When<Scene> = When {
    words: "in air",
    holds: |scene| moves(scene) && scene.air.is_some(),
};

static IS_MOVED: When<Scene> = When {
    words: "where supports are moved, or risers hauled in",
    holds: |scene| {
        let pulled = scene.wing().is_some_and(|wing| !wing.pulls.is_empty());
        moves(scene) && (pulled || !scene.supports.is_empty())
    },
};

static IN_A_BOX_THAT_FALLS: When<Scene> = When {
    words: "with `[air.descent]`",
    holds: |scene| moves(scene) && scene.descent.is_some(),
};

static IS_DAMPED: When<Scene> = When {
    words: "with `solver.damping_1_s`, or lines with damping",
    holds: |scene| {
        let damped = |body: &crate::case::scene::Body| {
            let mut cables = body.structure.cables.iter();
            cables.any(|cable| cable.damping_n_s > 0.0)
        };
        moves(scene) && (scene.solver.damping_1_s > 0.0 || scene.body.as_ref().is_some_and(damped))
    },
};

fn moves(scene: &Scene) -> bool {
    scene.fabric_is_solved() && scene.time.is_some()
}

columns! {
    /// Beside the kinetic energy.
    COLUMNS of Energies, in Scene: "Fabric that moves: its energies, and the work since release";
    ELASTIC: "elastic_energy_j", "J", "elastic energy of fabric and lines, and of contact" => |now| now.elastic_j, when MOVES;
    POTENTIAL: "potential_energy_j", "J", "potential energy against where the structure was built, in a box that falls against the box"
        => |now| now.potential_j, when FALLS;
    WORK_OF_AIR: "work_of_air_j", "J", "work of the air on fabric, lines and payload" => |now| now.work.of_air_j, when IN_AIR;
    WORK_OF_SUPPORTS: "work_of_supports_j", "J", "work of supports that are moved and of risers that are hauled in"
        => |now| now.work.of_supports_j, when IS_MOVED;
    WORK_OF_FRAME: "work_of_frame_j", "J", "work of the box's acceleration on what falls" => |now| now.work.of_frame_j, when IN_A_BOX_THAT_FALLS;
    LOST_TO_DAMPING: "lost_to_damping_j", "J", "what damping has taken" => |now| now.work.lost_to_damping_j, when IS_DAMPED;
    NUMERICAL_LOSS: "numerical_loss_j", "J",
        "what the integration in time and the solver's tolerance have taken: all work less damping and what the energies have gained"
        => |now| now.numerical_loss_j, reduced Last, when MOVES;
}

/// The last sample.
pub(super) fn results(results: &mut Results, record: &Record, scene: &Scene) {
    for column in COLUMNS.reduced(scene, Last) {
        if let Some(last) = record.column(column).last() {
            results.insert(column, Quantity::new(*last).with_note("at the end"));
        }
    }
}
