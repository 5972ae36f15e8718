//! # Ripstop: fluid–structure simulation of parachutes and paragliders
//!
//! This page is the map of the house. A user needs only the program (`ripstop run CASE.toml`); everything the program does
//! is open to library users through the modules below.
//!
//! ## Flow of data
//!
//! ```text
//! TOML (→ case/design: what follows from a canopy's design) → case::file (mirror) → case::Scene (checked, SI, absent = None) → plan::Plan (phases, stages, sizes, skips)
//!      → simulation::Simulation, statics::Statics → frame::Frame (host snapshot, SI) → measure, output, render
//! ```
//!
//! [`plan::phases::phases`] is the only place that orders a run; `run/phases/` executes it, a file each. A phase without time keeps its state in
//! [`statics`], and every phase can be interrupted and gone on with:
//!
//! | phase | turns | into | state |
//! |---|---|---|---|
//! | `open_canopy` | folded canopy | canopy opened by loading pressure | [`simulation::Opening`] |
//! | `raise_wind` | air at rest | wind; the structure is held | [`simulation`] |
//! | `march` | air and structure | the same, steps later, with history and frames | [`simulation`], [`measure::Record`] |
//! | `change_lattice` | air on a coarse grid | the same on a finer one | [`simulation`] |
//! | `equilibrium` | structure, loads | structure at rest | [`simulation`] |
//! | `trim` | wing, pilot | steady glide | [`statics::Trim`] |
//! | `panel_shaping` | flown wing | panels cut anew, and its glide | [`statics::PanelShaping`] |
//! | `load_test` | wing in equilibrium | its state under several times the loads | [`statics::LoadTest`] |
//!
//! [`plan::stages::stages`] is the only place that orders a step; [`simulation::Simulation::advance`] executes it:
//!
//! | stage | turns | into | file |
//! |---|---|---|---|
//! | `eddy_viscosity` | populations (WALE, Vreman) | eddy part of the relaxation times | `fluid/eddy_viscosity.rs` |
//! | `collide_stream` | populations, body force | populations | `fluid/collide_stream.rs` |
//! | `coarser_levels` | populations around boxes of finer cells, and of both where boxes end | populations | `fluid/transfer/`, `simulation/levels.rs` |
//! | `find_links` | node positions | links of the lattice that surfaces cut | `cut_links/search.rs` |
//! | `read_links` | populations, cut links | what left along them | `fluid/cut_links.rs` |
//! | *`send_markers`* | marker positions | places on the device | `immersed/interpolate.rs`, `immersed/sort_markers.rs` |
//! | `interpolate` | populations, marker positions | air velocity u* at markers, strengths a_k | `immersed/interpolate.rs` |
//! | `collide_ahead` | populations away from the structure | those of the next step, while the host goes on | `fluid/collide_ahead.rs` |
//! | *`fetch_links`* | what left along them | host, and what comes back where the air slides | `fluid/cut_links.rs` |
//! | *`fetch_air_velocities`* | u*, a_k | host | `immersed/interpolate.rs` |
//! | `solve_cloth` | u*, loads | node positions and velocities | `cloth/solve_cloth.rs` |
//! | `bounce` | node velocities, what left | populations that come back | `fluid/cut_links.rs` |
//! | *`fetch_wall_forces`* | forces on walls that are not solved for | host | `fluid/force_sums.rs` |
//! | *`send_marker_forces`* | marker forces | device | `immersed/spread.rs` |
//! | `spread` | marker velocities, u* | body force near the sheet | `immersed/spread.rs` |
//! | `repeat_forcing`, *`fetch_marker_forces`* | slip left at rigid bodies | more body force | `immersed/repeat_forcing.rs` |
//! | `measure`, `output` | impulses, frames | history, results, files | `measure/`, `run/` |
//!
//! Air and fabric are placed separately ([`plan::Placement`]), each in `cpu/` or in `gpu/`, where the files carry the same names;
//! `shaders/` holds the device's kernels under those names too. Stages in italics are transfers, in the plan only where a device
//! has the air (`send_nodes` and `fetch_nodes` around `solve_cloth` where it has the fabric). `collide_ahead`, too, is in the plan only there; the next `collide_stream` has the cells that are left.
//! Along cut links of most bodies a device answers by itself: then nothing is fetched but the forces on them (`gpu/fluid/standing_walls.rs`, `gpu/fluid/moving_walls.rs`).
//! Where one device has both and plain markers, it forms their reactions and forces itself (`gpu/cloth/marker_reactions.rs`, `simulation/meeting.rs`). `spread` comes before `fetch_nodes` then,
//! which brings what the host's accounts need, and nothing else is fetched or sent at markers. Where nothing but the structure changes from step to step, it makes series
//! of steps by itself (`simulation/device_alone.rs`), at cut links, too (`simulation/cut_fabric.rs`), and the host makes up the accounts afterwards.
//!
//! Boxes of cells half as large ([`simulation::Levels`], `docs/refinement.md`) exchange what they know with the lattice around them after two of
//! their steps (`fluid/transfer/`, `fluid/transfer.rs`).
//!
//! ## Rooms
//!
//! | module | holds | may use |
//! |---|---|---|
//! | [`lattice`] | D3Q19, collision operators, eddy viscosity, grid, links, boxes: what all engines share | – |
//! | [`immersed`] | kernel, markers, touched cells | – |
//! | [`sets`] | numbers that belong together, told pair by pair | – |
//! | [`cut_links`] | which links a surface cuts, and what comes back | lattice, immersed (law of permeable markers), sets |
//! | [`fabric`], [`lines`] | material laws | – |
//! | [`cloth`] | what a structure is made of; geometry of its contact with itself; which triangles share what the air does | laws, extents of triangles |
//! | [`rigid`] | surfaces and prescribed motions of rigid bodies | extents of triangles, sets |
//! | [`geometry`] | canopies, wings, sheets, cables, bodies, mesh files | cloth, rigid, sets |
//! | [`aero`] | steady potential flow on wings, viscous sections, drag of lines; SI | profiles of geometry |
//! | [`trim`] | the glide in which forces of the air, weight and lines of a wing are in balance, for a given shape | aero, cloth, geometry |
//! | [`solve`] | L-BFGS, Newton's method, stiffening by levels, multigrid, factorisation; knows no cloth | – |
//! | [`cpu`] | the native engine, one file per stage | all of the above |
//! | [`gpu`] | the device engine, the same files; alone sees wgpu | all of the above |
//! | [`units`] | SI ↔ lattice, only here | – |
//! | [`case`] | case files and their errors | geometry, laws |
//! | [`plan`] | what a run will do, as data | case, geometry, counts of markers |
//! | [`simulation`] | runs the plan | plan, cpu, gpu |
//! | [`statics`] | equilibrium, trim, panel shaping and load test, part by part | simulation, trim, geometry |
//! | [`frame`] | host snapshot in SI units | – |
//! | [`measure`] | time series, statistics, results, when to stop ([`measure::steady`]) | simulation, statics |
//! | [`validity`] | whether a set-up supports its results, and the error to expect | case, geometry, plan, measure, frame, output |
//! | [`output`], [`render`] | files, pictures | frame |
//! | [`checkpoint`] | the file that a run resumes from | output |
//! | [`ledger`] | what a folder holds and who works in it: `run.json` and the lock | output |
//! | [`polar`] | forces of a wing by itself over the angle of attack | aero, case |
//! | [`report`] | one page of a finished run, of a sweep, of a polar, or of several runs side by side, from their folders | ledger, measure, output, sweep |
//! | [`run`] | a whole run into one folder, its log and its faults | all |
//! | [`sweep`] | which runs a sweep has, its tables and charts, what its lattices tell | measure, output |
//! | [`bluff_body`] | drag of a sphere or a disk in a stream, for the next two | case, lattice, simulation, plan, measure, output, gpu |
//! | [`validate`] | problems with known answers, through the public interface | bluff_body, case, cut_links, immersed, lattice, simulation, plan, polar, gpu, output, run |
//! | [`bench`] | error against seconds, the map of stability, schemes of coupling, what a device does | bluff_body, case, cpu, geometry, immersed, lattice, simulation, measure, plan, gpu, output, run |
//! | [`cli`] | the commands and exit codes | all |
//!
//! A test (`tests/architecture.rs`) holds these arrows, and that the files of a room make no circle either. Types stand below, then the stages that
//! act on them, then the head that runs them. A struct whose `impl` blocks lie in several files has its definition below all of these.
//!
//! ## The coupling in one paragraph
//!
//! Over the new node positions the fabric minimises inertia + elastic energy − loads + ½ dt Σ_k K_k |v_k − u*_k|². Here v_k
//! is a marker's velocity, u*_k the bare air velocity at it and K_k = 2 a_k ρ A_k·cell/dt. The air then receives exactly
//! K_k (v_k − u*_k). Velocities and accelerations count from the last two steps (BDF2) or the last one ([`cpu::cloth::integration`]): the objective is the same with other
//! constants, on the host as on a device. The reaction is convex and the exchange of momentum exact (the fabric's own balance holds to the solver's
//! tolerance). So the ratio of sheet mass to air mass does not matter for stability. With k > 1 the fabric feels the mean ū
//! over the last k steps and the air K_k (v_k − u*_k) of each. The strength a_k is lowered where folds put several layers under one kernel
//! ([`cpu::immersed`]). Markers of rigid bodies have prescribed velocities and stand a little inside the surface
//! (`docs/rigid-bodies.md`). Where air passes a surface, a marker aims at v_k + v n in place of v_k. The velocity v through it follows from its
//! own normal force by Ergun's law, within the same step ([`immersed::permeable`]). Surfaces of a wing in the wind along which the air slides
//! act across themselves alone. Both the fabric and the air get K_k n n·(v_k − u*_k), n being the surface's normal (`docs/ram-air.md`). In a box that
//! falls (`[air.descent]`) every mass, the air's too, feels one more uniform acceleration ([`simulation::Descent`]).
//!
//! With `coupling.scheme = "links"` there are no markers. What leaves a cell along a link that the surface cuts comes back to it. The fabric feels at every cut a force that is
//! affine in its velocity, inside the same step ([`cut_links`], `docs/cut-links.md`). Triangles smaller than cells share it ([`cloth::patches`]). Where the air slides along a surface, what left the cells about the mirror image comes back
//! instead. A model of the boundary layer may give the stress on it ([`cut_links::boundary_layer`]).
//!
//! After release a run may go on on other cells or with another time step (`steady.grid_sequence`, falls that slow down). The state is carried
//! over in SI units and the stages stay the same ([`simulation::Simulation::change_lattice`], `docs/steady-runs.md`).
//!
//! Where a case asks for it ([`cloth::contact`], `docs/contact.md`), fabric that comes close to fabric adds a barrier to that energy. No
//! trial goes farther than it can without passing through.
//!
//! ## Departures from the published schemes
//!
//! Each file names its sources and departures in its header; `docs/papers.md` collects those from the five papers.
//! [`measure`] reads the simulation itself, not frames alone, because impulses and slip are not part of a snapshot.

pub mod aero;
pub mod bench;
pub mod bluff_body;
pub mod case;
pub mod checkpoint;
pub mod cli;
pub mod cloth;
pub mod cpu;
pub mod cut_links;
pub mod fabric;
pub mod frame;
pub mod geometry;
pub mod gpu;
pub mod immersed;
pub mod lattice;
pub mod ledger;
pub mod lines;
pub mod measure;
pub mod output;
pub mod plan;
pub mod polar;
pub mod render;
pub mod report;
pub mod rigid;
pub mod run;
pub mod sets;
pub mod simulation;
pub mod solve;
pub mod statics;
pub mod sweep;
pub mod trim;
pub mod units;
pub mod validate;
pub mod validity;
