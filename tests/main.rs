//! All tests that run the program or whole engines, as trials made at run time: one per engine, so that a device that is
//! missing shows as a skip, and as a failure where `RIPSTOP_REQUIRE_GPU=1`.

#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    clippy::print_stdout,
    clippy::print_stderr,
    reason = "tests fail by panicking, and print for those who watch"
)]

mod adaptive;
mod air;
mod architecture;
mod bad_cases;
mod bodies;
mod body_charts;
mod body_settling;
mod cadence;
mod canopies;
mod canopy;
mod capabilities;
mod case_schema;
mod cases;
mod change_of_lattice;
mod checkpoint;
mod cloth;
mod collide_ahead;
mod command_line;
mod contact;
mod contact_sheets;
mod contract;
mod coupling;
mod cut_canopies;
mod cut_links;
mod descent;
mod design;
mod device;
mod device_cloth;
mod device_cloth_steps;
mod device_kernels;
mod device_multigrid;
mod device_work;
mod eddy_viscosity;
mod energy;
mod engines;
mod extension;
mod faults;
mod folders;
mod front_door;
mod fuzz;
mod import;
mod import_lines;
mod interrupts;
mod judged_bodies;
mod keeping;
mod lep_sim;
mod levels;
mod long_histories;
mod meeting;
mod mesh_files;
mod mesh_findings;
mod mesh_seams;
mod meshes;
mod module_graph;
mod motion;
mod moving_walls;
mod nodes;
mod out_of_memory;
mod own_steps;
mod permeability;
mod phases;
mod plates;
mod polar;
mod python;
mod ram_air;
mod read_outs;
mod reserve;
mod resolved;
mod resumed;
mod resumption;
mod room_on_disk;
mod sail_support;
mod sheets;
mod solver_account;
mod sound;
mod standard_error;
mod standing_walls;
mod supply_chain;
mod supports;
mod sweep;
mod through_faces;
mod time_steps;
mod timing;
mod tolerances;
mod trim;
mod validate;
mod validity;
mod vh_ribs;
mod wall_friction;
mod walls;
mod wing;
mod wing_design;
mod wing_loads;
mod wing_patterns;

use libtest_mimic::{Arguments, Trial};

fn main() -> std::process::ExitCode {
    // A trial that reads inputs in a process of its own starts this program again.
    if let Some(code) = fuzz::child() {
        return code;
    }
    let arguments = Arguments::from_args();
    let trials: Vec<Trial> = [
        architecture::trials(),
        air::trials(),
        eddy_viscosity::trials(),
        cloth::trials(),
        contact::trials(),
        contact_sheets::trials(),
        contract::trials(),
        wall_friction::trials(),
        walls::trials(),
        wing::trials(),
        wing_loads::trials(),
        vh_ribs::trials(),
        wing_design::trials(),
        wing_patterns::trials(),
        lep_sim::trials(),
        levels::trials(),
        long_histories::trials(),
        meeting::trials(),
        own_steps::trials(),
        mesh_files::trials(),
        mesh_findings::trials(),
        mesh_seams::trials(),
        motion::trials(),
        moving_walls::trials(),
        nodes::trials(),
        energy::trials(),
        out_of_memory::trials(),
        ram_air::trials(),
        read_outs::trials(),
        sail_support::trials(),
        trim::trials(),
        coupling::trials(),
        collide_ahead::trials(),
        cut_canopies::trials(),
        cut_links::trials(),
        device::trials(),
        device_cloth::trials(),
        device_cloth_steps::trials(),
        device_kernels::trials(),
        device_multigrid::trials(),
        device_work::trials(),
        canopy::trials(),
        canopies::trials(),
        bodies::trials(),
        body_charts::trials(),
        body_settling::trials(),
        through_faces::trials(),
        cadence::trials(),
        adaptive::trials(),
        supply_chain::trials(),
        supports::trials(),
        permeability::trials(),
        phases::trials(),
        plates::trials(),
        descent::trials(),
        design::trials(),
        change_of_lattice::trials(),
        capabilities::trials(),
        case_schema::trials(),
        cases::trials(),
        bad_cases::trials(),
        command_line::trials(),
        interrupts::trials(),
        judged_bodies::trials(),
        keeping::trials(),
        checkpoint::trials(),
        folders::trials(),
        front_door::trials(),
        polar::trials(),
        python::trials(),
        import::trials(),
        import_lines::trials(),
        fuzz::trials(),
        resumption::trials(),
        room_on_disk::trials(),
        resolved::trials(),
        reserve::trials(),
        extension::trials(),
        faults::trials(),
        sweep::trials(),
        time_steps::trials(),
        solver_account::trials(),
        sound::trials(),
        standard_error::trials(),
        standing_walls::trials(),
        validity::trials(),
        validate::trials(),
    ]
    .into_iter()
    .flatten()
    .collect();
    let conclusion = libtest_mimic::run(&arguments, trials);
    timing::tell();
    conclusion.exit_code()
}
