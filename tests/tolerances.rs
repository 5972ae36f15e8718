//! Every tolerance with its reason, in one place.

use crate::engines::Engine;

/// Decay rate of Taylor–Green vortices at 32 cells: second-order error at this resolution (gate F1: 0.5 %).
pub const DECAY_RATE: f64 = 5e-3;

/// Convergence order of the air under diffusive scaling: second order, a little less where round-off or start-up enters.
pub const CONVERGENCE_ORDER: f64 = 1.9;

/// Dissipation of a shear wave by Smagorinsky's viscosity: the wave loses its sine shape a little while it is measured.
pub const EDDY_VISCOSITY: f64 = 0.03;

/// Root mean square over the largest value, in a box against finest cells throughout: 0.013 on all engines, from the shell's parabolas. With gradients
/// across frictionless walls at two faces of the box it is 1.8.
pub const EDDY_VISCOSITY_IN_A_BOX: f64 = 0.02;

/// The same of the coarse cells at the faces of a box: 0.011 on all engines, from differences over twice the distance. With a band one
/// cell deep it is 0.089.
pub const EDDY_VISCOSITY_AT_A_BOX: f64 = 0.02;

/// Eddy viscosity from the velocity gradient, over the constant times a rate of 0.004 per step: round-off of velocities near 0.05, and for
/// 16-bit storage 2⁻¹² of populations near 0.01.
pub const fn velocity_gradient(engine: Engine) -> f64 {
    match engine {
        Engine::CpuF64 => 1e-12,
        Engine::CpuF32 | Engine::Gpu => 1e-4,
        Engine::CpuF16 | Engine::GpuF16 => 2e-2,
    }
}

/// Mass and momentum kept over some hundred steps, per cell: round-off.
pub const fn conservation(engine: Engine) -> f64 {
    match engine {
        Engine::CpuF64 => 1e-13,
        // 2⁻²⁴ ≈ 6e-8 per operation on populations shifted by their weights (values near 1e-2).
        Engine::CpuF32 | Engine::Gpu => 1e-7,
        // 2⁻¹² of the same values, at random: 1e-6 was measured.
        Engine::CpuF16 | Engine::GpuF16 => 5e-6,
    }
}

/// Two descriptions of the same flow (mirrored or periodic): they differ only in the order of sums.
pub const fn same_flow(engine: Engine) -> f64 {
    match engine {
        Engine::CpuF64 => 1e-13,
        Engine::CpuF32 | Engine::Gpu | Engine::CpuF16 | Engine::GpuF16 => 2e-6,
    }
}

/// Flows between no-slip walls that half-way bounce-back keeps exactly, over their largest speed: round-off of some thousand steps.
pub const fn exact_wall(engine: Engine) -> f64 {
    match engine {
        Engine::CpuF64 => 1e-12,
        // Measured: 6e-7; the force of a step is a thousandth of the populations that it is added to.
        Engine::CpuF32 | Engine::Gpu | Engine::CpuF16 | Engine::GpuF16 => 2e-5,
    }
}

/// The same with viscosity from the third-order moments that the recursion does not predict: next to a wall there are such. Measured: 2e-10.
pub const WALL_WITH_RESIDUAL: f64 = 1e-8;

/// Share of a packet of sound that comes back from the inlet or an absorbing side. Measured: 0.04 to 0.05; a wall sends back all of it, an inlet
/// that does not let the air move along it 0.056 at 30°.
pub const FACE_REFLECTION: f64 = 0.053;

/// A flow that was moved by whole cells where everything repeats: forces over the largest, densities and velocities [cells per step]. Weights of cuts are rounded
/// elsewhere. Measured: 7e-9 in f32 on the CPU, 6e-16 on the others.
pub const MOVED_PERIOD: f64 = 1e-6;

/// Flow through absorbing sides under a steady pressure of δρ = ± 3.6e-4 [cells per step]. Measured: 2e-9; without running means 1.9e-4.
pub const THROUGH_SIDES: f64 = 1e-6;

/// Share of a sound pulse that comes back from the outlet (gate F7).
pub const OUTLET_REFLECTION: f64 = 0.05;

/// Markers against momentum box: exact but for round-off accumulated over the window.
pub const fn momentum_closure(engine: Engine) -> f64 {
    match engine {
        Engine::CpuF64 => 1e-9,
        Engine::CpuF32 | Engine::Gpu | Engine::CpuF16 | Engine::GpuF16 => 1e-3,
    }
}

/// Mass balance of the momentum box, over its mass: round-off of populations that sum to a density near 1.
pub const fn mass_closure(engine: Engine) -> f64 {
    match engine {
        Engine::CpuF64 => 1e-12,
        Engine::CpuF32 | Engine::Gpu | Engine::CpuF16 | Engine::GpuF16 => 1e-6,
    }
}

/// Mean density excess of an empty tunnel after the wind has risen: every cell, ghosts included, was accelerated alike. What is
/// left, up to 8e-6 (a thousandth of the dynamic pressure), comes from the density of the second cell that the inlet takes over; the
/// outlet lets it settle within half a passage of the wind. A lag of one step leaves 7e-4.
pub const TUNNEL_START: f64 = 1e-5;

/// Velocity over the wind's speed (0.7 % was seen), and density excess (5.7e-4, a seventeenth of the dynamic pressure), of wind that differs from layer
/// to layer. Without the stress of its shear the inlet turns it by 6 %.
pub const SHEARED_WIND: f64 = 1e-2;
pub const SHEARED_WIND_EXCESS: f64 = 8e-4;

/// Velocity of still air seen from a box that falls slower and slower, between inlet and outlet [cells per step]: what the inlet takes over
/// from the second cell, as in [`TUNNEL_START`].
pub const FALLING_BOX: f64 = 2e-5;

/// Terminal speed of a disk of four cells against that of its drag area and weight: what is left of its deceleration.
pub const TERMINAL_SPEEDS: f64 = 5e-3;

/// Kinetic energy of that wind: the density's excess, and twice as much from the speed that goes with it (2.4e-5).
pub const TUNNEL_START_ENERGY: f64 = 5e-5;

/// Catenary of 100 segments (gate C2).
pub const CATENARY: f64 = 1e-3;

/// Analytic gradients against central differences of the energy, over the largest gradient: truncation, and kinks where fabric
/// changes between taut, wrinkled and slack within the difference.
pub const GRADIENT: f64 = 1e-4;

/// Affine boundary displacements must give affine interiors (gate C1, membrane).
pub const PATCH: f64 = 1e-6;

/// What is left of the balance of a node under pressure that follows, over the largest nodal load: solved to 1e-5 in energy norm, in which
/// forces of soft directions weigh more.
pub const FOLLOWING_PRESSURE: f64 = 1e-3;

/// Spread force balance of the three routes (the gate is 2 %).
pub const FORCE_IMBALANCE: f64 = 0.02;

/// Drag of a sphere at Re 100, 12 cells per diameter, 4.9 % blockage, six diameters of travel, over the published value: walls and
/// the start raise it.
pub const SPHERE_DRAG: [f64; 2] = [1.0, 1.2];

/// Forces and moments that symmetry forbids, over the drag: round-off, which in f32 drifts a little.
pub const fn symmetry(engine: Engine) -> f64 {
    match engine {
        Engine::CpuF64 => 1e-9,
        Engine::CpuF32 | Engine::Gpu | Engine::CpuF16 | Engine::GpuF16 => 1e-3,
    }
}

/// A plate moved through still air against a plate held in wind: markers that cross cells, ends of the tunnel at other distances, and
/// the lattice's own dependence on the frame, of order Ma².
pub const GALILEI: f64 = 0.03;

/// Impulse of a sphere of 12 cells set in motion quickly, in masses of displaced air: 0.5 exactly without viscosity; 1.14 measured, since
/// the kernel drags a layer of some cells along and the air inside, taken for rigid, lags (`docs/rigid-bodies.md`). A wrong sign of
/// the air inside would be off by 2, leaving it out by 1.
pub const ADDED_MASS: [f64; 2] = [0.5, 1.3];

/// Air on a device against the CPU in f32 after some ten steps: both round to 2⁻²⁴ of values near 0.1, in another order.
pub const DEVICE_AIR: f64 = 1e-6;

/// Sums over a box of some thousand cells and 150 steps on a device, which adds 64 numbers in f32 before the host goes on in f64.
pub const DEVICE_BALANCE: f64 = 2e-3;

/// Kernel weights and spread areas in f32: a few roundings, amplified by the square root of the kernel near its rim.
pub const DEVICE_WEIGHTS: f64 = 1e-5;

/// Positions of the canopy after fifty coupled steps, in cells: both engines carry the air in f32, and the folded sheet's solver stops
/// at a tolerance of 1e-2, which lets different roundings stop at different iterations (0.022 on an NVIDIA H100).
pub const fn device_canopy_cells(kind: ripstop::gpu::AdapterKind) -> f64 {
    match kind {
        ripstop::gpu::AdapterKind::Software => 0.02,
        _ => 0.05,
    }
}

/// Impulse on the canopy over those steps: as above.
pub const DEVICE_CANOPY_IMPULSE: f64 = 5e-3;

/// Impulse on a folded canopy over its first five steps at cut links: single and double precision on the CPU lie 0.5 % apart there.
pub const DEVICE_LINKS_IMPULSE: f64 = 0.02;

/// Force along a plate across the stream over its drag, at cut links on 8 cells. It was 0.047 while its two edges cut different links, and is 5e-9.
pub const ALONG_A_PLATE: f64 = 1e-3;

/// Routes of the force in the first sixty steps of a folded canopy with a kernel, over the impulse: the solver's tolerance of 1e-4, and single precision.
pub const MEETING: f64 = 1e-3;

/// Impulses (of the markers), and mean distances of nodes over the diameter, after two steps that a device makes by itself, against two with the host: velocities and fractions of
/// cells in single precision, and where that ends a solve of tolerance 1e-3.
pub const OWN_STEP: [f64; 2] = [1e-5, 1e-6];
/// The same after 42 of them: in folds little holds the fabric, and differences grow (up to 7e-5 and 1.4e-5).
pub const OWN_STEPS: [f64; 2] = [5e-4, 1e-3];

/// Impulses on walls along whose links a device answers by itself, against those of the CPU in single precision after 40 steps: round-off.
pub const STANDING_WALLS: f64 = 1e-5;
/// The difference of the defects of mass in the momentum box, over its mass.
pub const STANDING_WALLS_MASS: f64 = 1e-8;
/// Both of populations in 16 bits: presumably engines round what lies midway between two numbers to one or the other, a part in 2000 of a population.
pub const WALLS_IN_16_BITS: [f64; 2] = [5e-3, 1e-5];

/// Diameter and impulse of a canopy after its opening (550 steps): differences of 1e-6 grow in the wake. The gate.
pub const DEVICE_OPENING: f64 = 0.03;
/// Diameter and impulse of a canopy after 0.01 s in a box of finer cells against finest cells throughout, in the same tunnel (2e-3): what 6 cells
/// to a diameter change of the flow that closes around it.
pub const OPENING_IN_BOXES: f64 = 5e-3;

/// Momentum box against markers in a box of finer cells, over the impulse (3e-5): as on one lattice, since all of the momentum box lies inside.
pub const MOMENTUM_BOX_IN_BOXES: f64 = 3e-4;

/// Drag of a sphere with a box of finer cells in the stream beside it (3e-5): sound and the wake's edge pass through that box.
pub const BOX_ELSEWHERE: f64 = 3e-4;

/// Cloth on a device (`f32` with split positions) against the CPU in `f64`; what was measured on a software device in brackets.
pub mod device_cloth {
    /// Gradient, over its largest node: some ten roundings of 6e-8 per element, and sums of a dozen elements (2.6e-7).
    pub const GRADIENT: f64 = 1e-6;
    /// H₀ times the gradient, and dot products: blocks that are a thousand times softer across the sheet lose digits when they are
    /// inverted (1.8e-5 for fabric, 4e-7 otherwise).
    pub const INITIAL_HESSIAN: f64 = 1e-4;
    /// One multigrid cycle on the same matrix, over its largest result: sums in another order, on several levels (9e-7 on a software adapter, which
    /// rounds as the host does; 2.8e-5 on an NVIDIA H100, which fuses products and sums).
    pub const fn cycle(kind: ripstop::gpu::AdapterKind) -> f64 {
        match kind {
            ripstop::gpu::AdapterKind::Software => 1e-5,
            _ => 1e-4,
        }
    }
    /// H₀ times the gradient and dot products with multigrid: both engines store the matrix in `f32`, the device assembles it so too
    /// (3.9e-5 for fabric, 2e-5 for springs that nothing holds).
    pub const MULTIGRID: f64 = 2e-4;
    /// Equilibria solved to 1e-3 of the loads' energy norm, over the way that the sheet moved (3e-4: each stops a little elsewhere).
    pub const EQUILIBRIUM: f64 = 1e-3;
    /// Gradient of wrinkled fabric: the tension left is a small difference where the fabric is folded far (6.1e-6).
    pub const WRINKLED: f64 = 3e-5;
    /// H₀ of fabric without any stiffness across its wrinkles (6.2e-5).
    pub const WRINKLED_HESSIAN: f64 = 3e-4;
    /// Positions after a trial [m]: a direction of 5 cm in `f32` (1.2e-9).
    pub const POSITION_M: f64 = 3e-9;
    /// Gradient at strains of 1e-6 of edges of 5 cm: positions to 5e-13 m (4.3e-5). Plain `f32` strains would be wrong by 6e-2,
    /// plain `f32` positions altogether.
    pub const SMALL_STRAIN: f64 = 2e-4;
    /// Noise of nodal forces, over the load of 50 Pa on a mesh of 10 mm, 10 m from the origin: the gate (2.3e-4;
    /// positions in single precision would give 17 to 20 times the load).
    pub const FORCE_NOISE: f64 = 1e-2;
    /// One step solved to 1e-5, over the way that the sheet moved (1.6e-7: both engines take the same iterations).
    pub const ONE_STEP: f64 = 1e-5;
    /// Two steps solved to 1e-5 by two minimisers, over the way that the nodes moved (after three steps 1.2e-5 on an NVIDIA H100: each stops a
    /// little elsewhere).
    pub const EVERY_KIND: f64 = 1e-4;
    /// One step of triangles that cut links, solved to 1e-4, over the way that the sheet moved (2e-7, and with multigrid 2e-5: each engine stops a little elsewhere).
    pub const CUT_STEP: f64 = 1e-4;
    /// Two steps with multigrid, so long that waves cross the sheet, solved to 1e-5 each (1.9e-5: each engine stops a little elsewhere).
    pub const LONG_STEPS: f64 = 1e-4;
    /// Fifty steps solved to 1e-4 each (2.3e-5).
    pub const MOTION: f64 = 2e-4;
    /// Twenty steps of free fall solved to 1e-7 each [m]: velocities keep what is left of every step (4e-9).
    pub const FREE_FALL_M: f64 = 1e-7;
}

/// Contact of fabric with itself, in double precision on the host.
pub mod contact {
    /// Gradient of a pair against differences over 2e-6 of distances near 1: their own error.
    pub const GRADIENT: f64 = 1e-5;
    /// Sum of a pair's forces and of their moments about the origin, over the largest force: round-off; nearly parallel edges lose
    /// digits in products of their lengths.
    pub const BALANCE: f64 = 1e-12;
    /// Weight carried by supports: solved to 1e-4 in the energy norm of the loads, which binds single forces less.
    pub const WEIGHT: f64 = 1e-2;
    /// Energy gained in a step, over that at the start: the solver's displacement floor. Backward Euler loses energy in every step of an
    /// impact.
    pub const ENERGY: f64 = 1e-6;
    /// Momentum lost in an impact of forty steps: what the solver leaves of the gradient.
    pub const MOMENTUM: f64 = 1e-4;
}

/// A canopy some fifty steps after its run went on on another engine, with steps of the fabric solved to 1e-5.
pub const OTHER_ENGINE: f64 = 1e-4;

/// Drag after a change to the same lattice: moments of the populations beyond the stress are lost, which moves it by up to 2 %.
pub const DRAG_AFTER_NO_CHANGE: f64 = 0.04;

/// Drag after a time step 10 % longer: residual slip grows as much, and the air accelerates through the fabric first.
pub const DRAG_AFTER_CHANGE_OF_STEP: f64 = 0.12;

/// Drop of a clamped plate of 20 cells against the elastica: 0.2 % was measured, second order.
pub const CLAMP: f64 = 5e-3;

/// Drop of a strip 20 times as long as wide against a beam: the clamp keeps it from bending across there, about a tenth of a width long,
/// which takes 1 %. As stiff as a wide plate it would drop by 15 % less.
pub const STRIP: f64 = 0.03;

/// Tip of a plate that hangs from a pinned edge, over its length: the solver's tolerance.
pub const PINNED: f64 = 1e-3;

/// Reaction of a plate's edge against its markers' force, means over half a run: what the solver leaves (1e-4 of the loads in the energy norm),
/// and the step by which the forces that the air gets lag behind the fabric's.
pub const REACTION: f64 = 1e-2;

/// Drag in the next 36 steps on cells of two thirds the size, in the midst of the opening: a canopy of 10 cells, whose mouth is three cells wide, has
/// 38 % more drag than one of 15.
pub const DRAG_ON_FINER_CELLS: f64 = 0.5;

/// Impulses at the same instant before and after a change of the lattice: the same numbers in other units.
pub const IMPULSE_CARRIED: f64 = 1e-6;

/// Impulses by the three routes since release, over a change: markers and momentum box agree to 1e-5, the lines to 0.2 % (the solver's tolerance).
pub const ROUTES_OVER_A_CHANGE: f64 = 0.01;

/// Rigged canopies.
pub mod meshes {
    /// Tension of a sheet of which a seam was joined, over that of a whole one: the same nodes, but rounded where they were joined.
    pub const TENSION: f64 = 1e-9;

    /// Difference of a canopy joined of gores after 12 steps under pressure [m]: where each step's minimiser stops.
    pub const ALIKE_M: f64 = 1e-4;

    /// Bulge and tension under pressure of a canopy whose gores have 8 and 12 rings, over those of one with 12 everywhere.
    pub const SEWN: f64 = 0.01;
}

pub mod canopies {
    /// Difference of gores after 12 steps under pressure, which move them by some millimetres [m]: where each step's minimiser stops.
    pub const ALIKE_M: f64 = 1e-4;

    /// Steps of 0.5 ms under pressure, in which the lines are pulled tight.
    pub const RISER_STEPS: usize = 60;

    /// Force at a junction of lines and riser, and of all risers less the support's, over that of all risers: what the lines' inertia takes, and the
    /// solver leaves.
    pub const RISER_BALANCE: f64 = 0.05;

    /// Area of markers against that of a smaller circle: the mesh is a polygon, and smallest parts of triangles carry no marker.
    pub const MARKED_AREA: f64 = 5e-3;
}

/// Trim of wings.
pub mod trim {
    /// A bend of some decimetres on a mesh of half as many edges: chords of arcs of 0.2 m by slopes of 0.03 [m].
    pub const CARRIED_OVER_M: f64 = 5e-3;

    /// Forces of a shape in balance, over the weight: the same sums in another order.
    pub const BALANCE: f64 = 1e-9;

    /// Their moment about the hang points, over weight times height: the search ends at 1e-7 rad.
    pub const MOMENT: f64 = 1e-6;

    /// Change of the drag coefficient of a section without an intake where other sections lose theirs: the wing flies at another angle, by some tenths of a degree.
    pub const CLOSED_TIP: f64 = 1e-3;

    /// Drag coefficient that an intake adds to its section, at least: 0.07 of its height, 0.035 of the chord, less what the angle changes.
    pub const INTAKE: f64 = 2e-3;

    /// Volume inside panels against that between the ribs: both are polyhedra through points of the profile, over different places.
    pub const VOLUME: f64 = 0.02;

    /// What the guide carries once the wing stands still [N]: 500 N/m at 6 m make 0.1 degrees, where the trim ends, of 5 N.
    pub const GUIDE_N: f64 = 10.0;

    /// What the risers carry against what acts, over it: `equilibrium.trim.tolerance.balance` of the case.
    pub const RISERS: f64 = 1e-2;
}

/// Load tests and panels of wings.
pub mod wing_design {
    /// Share of a row in the load, from that of the shipped mesh under prescribed pressure: the tolerance of each solve, 3e-2 of the loads; 1.7 % was measured.
    pub const LOAD_SHARE: f64 = 0.03;

    /// Forces of the risers over those of the air times the load factor and the projected area: what the guide carries, and how pressure turns with a wing whose
    /// lines stretch; 0.2 % was measured at 6.
    pub const RAISED: f64 = 0.02;

    /// Heights of a profile read from 121 points against the formula: the spline between them, and six digits.
    pub const PROFILE: f64 = 5e-4;

    /// Strain of ballooned panels laid flat: of the order of the ballooning, 6 %.
    pub const LAID_FLAT: f64 = 0.06;

    /// Mass of rods over that of their profile's length: a polygon is shorter than its arc, by a 24th of the square of an edge's turn;
    /// 1.4e-4 was measured.
    pub const ROD_LENGTH: f64 = 1e-3;

    /// What bent rods store over ½ E I ∫ κ² ds of the profile: half an edge at each end bends nothing, and the nose is a polygon; 3.3e-3 was measured.
    pub const ROD_ENERGY: f64 = 0.01;

    /// Force that holds a hanging wing over its weight: the energy norm of 1e-2 to which it is solved, and what that leaves in stiff lines.
    pub const HANGS: f64 = 0.05;
}

/// Bodies that pass through faces.
pub mod through_faces {
    use super::{DEVICE_WEIGHTS, Engine};

    /// What markers at a face exchange in two passes against what they and their images exchange, over the largest: sums in another order, of air in the
    /// engine's precision; on a device kernel weights in `f32`, too. Slips after two passes are some tenths of the velocities they are the rest of.
    pub const fn exchange(engine: Engine) -> f64 {
        match engine {
            Engine::CpuF64 => 1e-11,
            Engine::CpuF32 => 1e-5,
            Engine::Gpu | Engine::CpuF16 | Engine::GpuF16 => 10.0 * DEVICE_WEIGHTS,
        }
    }

    /// Drag of half a sphere whose markers are the images of the other half's, over that of the whole: 2e-16 was measured in double precision; round-off,
    /// as of forces that symmetry forbids.
    pub const fn half_model(engine: Engine) -> f64 {
        match engine {
            Engine::CpuF64 => 1e-9,
            Engine::CpuF32 | Engine::Gpu | Engine::CpuF16 | Engine::GpuF16 => 1e-3,
        }
    }

    /// The same where triangles lie across the face and are cut in two, so that some markers stand elsewhere: 5e-5 was measured at 8 cells per diameter.
    pub const CUT_TRIANGLES: f64 = 5e-4;

    /// Slip over the wind of bodies of six cells at faces: as of other coarse bodies.
    pub const SLIP: f64 = 0.1;

    /// Section of a cylinder of six cells against a circle: it is a prism of eighteen sides, 2 % smaller.
    pub const PRISM: f64 = 0.04;
}

/// Supports that are moved.
pub mod supports {
    /// Force of a bar that was pulled, in double precision: solved to displacements of 1e-9 elements, a millionth of the stretch.
    pub const FORCE: f64 = 1e-5;
    /// The same on a device: round-off of forces in `f32` over strains of a hundredth.
    pub const DEVICE_FORCE: f64 = 1e-3;
    /// Place of a shaken mass, over the amplitude of the support: implicit Euler with 5000 steps in a period of the mass damps by ω² dt/2, 1.2 % in the
    /// 0.3 s.
    pub const SHAKEN: f64 = 0.03;
}

/// Steps that choose their own length.
pub mod adaptive {
    /// Ratio of a pendulum's errors where the tolerance is a quarter: 2, as steps are halved throughout.
    pub const HALVED: [f64; 2] = [1.6, 2.5];

    /// The same by BDF2: 4^(2/3) = 2.5 in the mean; parts come in halves, so that single steps of the ladder take 1 to 8.
    pub const LESS_BY_BDF2: [f64; 2] = [1.3, 9.0];
}

/// Deflection of Hencky's disc of 20 rings and height of the airbag of 16 cells, membranes: second order in the size of the triangles.
pub const BENCH_MEMBRANE: f64 = 0.01;

/// The same of springs: those along the edges of a disc's triangles stand for equilateral ones, those of the airbag for C₁₂ = G.
pub const BENCH_NETWORK: f64 = 0.05;

/// Wings in the wind.
/// Impulses of tethers over those that the motion of their masses asks for: the tolerance of a step, 1e-3, over some hundred steps.
pub const TETHERS: f64 = 1e-2;

/// Speed of a wind that rises with a boundary layer against that of the inlet, over the wind: cells of the outermost lattice are a twelfth of the layer,
/// and the canopy stands downstream.
pub const RISING_WIND: f64 = 0.02;

pub mod ram_air {
    /// Volume of cells with flat panels over section times width: round-off.
    pub const VOLUME: f64 = 1e-9;
    /// Points in the middle of a cell against the middle of its section [m]: the section between nodes is straight.
    pub const MIDDLE: f64 = 5e-3;
    /// How much farther down brakes on one side pull their trailing edge than the other side's [m].
    pub const BRAKED_M: f64 = 0.02;
    /// Markers against momentum box, in f32 over some hundred steps.
    pub const IMBALANCE: f64 = 2e-3;
    /// Forces that symmetry forbids over those it allows: both sides of a section are divided at other places, since lines are sewn on below.
    pub const SYMMETRY: f64 = 0.1;
    /// Lift coefficient of a thick wing of aspect ratio 1.2 at 10°: Helmbold's formula gives 0.30 in free air; walls raise it, twelve cells per chord are
    /// coarse.
    pub const LIFT_AT_10_DEG: [f64; 2] = [0.15, 0.8];
    /// Drag along the wind with friction over that without, at least: 1.21 was seen.
    pub const HELD_DRAG: f64 = 1.1;
    /// Lift at 10° with friction, which makes the flow leave the upper side, over that without, at most: 0.70 was seen.
    pub const HELD_LIFT: f64 = 0.85;
    /// Volume of panels laid together over its share of the design: sections between nodes are straight.
    pub const LAID_TOGETHER: f64 = 0.02;
    /// A step solved to 1e-9 of its loads [m/s].
    pub const ACROSS_M_S: f64 = 1e-6;
    /// Drag of lines in a wind that changes with the height, each line's taken where its middle is, in a cell of 8 cm: 0.004 measured.
    pub const LINE_DRAG: f64 = 0.01;
    /// The same in an even wind: round-off.
    pub const LINE_DRAG_IN_EVEN_WIND: f64 = 1e-9;
}

/// Speed and way of what falls, period of what swings, over the steps of 1e-2 to 1e-6 s (1e-7 s on the host): asked for. Measured: 1e-6 on the
/// host; on a device round-off of positions, 2e-13 m a step at random, is 2 % of a step of 1e-6 s and the less the longer it falls.
pub const SPEED_OF_A_FALL: f64 = 1e-3;

/// Period of a swinging sheet of 4 by 4 cells against a chain of its rows, whose nodes move alike: 1.8e-3 measured.
pub const SHEET_FOR_A_CHAIN: f64 = 3e-3;

/// Elongation of a mass on a spring, over its amplitude: the tolerance of a solve, 1e-2, of a thousandth of the forces at its start.
pub const FREE_OSCILLATION: f64 = 1e-3;

/// Share of the energy that a free oscillation loses in ten periods of 100 steps, by BDF2: asked for. 1 − exp(−10 π (2π/100)³) = 0.0078 is its theory.
pub const ENERGY_OF_TEN_PERIODS: f64 = 0.01;

/// The same by backward Euler against 1 − exp(−10 (2π)²/100): the theory leaves out higher powers of the step, and the swing's own amplitude; 0.0006 measured.
pub const ENERGY_BY_BACKWARD_EULER: f64 = 0.01;

/// Elongation that a mass of a thousandth of the step's period keeps from the second step on, of 0.1 at first: 7e-9 measured.
pub const STIFF_REST: f64 = 1e-7;

/// Order of the error of a swing in time, against 1 or 2, over halved steps of 5 to 1.25 ms.
pub const ORDER_IN_TIME: f64 = 0.15;

/// Order in which the rest of a shaken rope's energy balance falls, against 3 by BDF2 and 1 by backward Euler: 2.9, 3.0, 0.7 and 0.8 measured, the last two
/// on their way to 1.
pub const ORDER_OF_THE_REST: f64 = 0.4;

/// Rest of a shaken rope's energy balance over what support and damping did, in steps of 0.125 ms; difference of the share that the integration takes of an opening
/// on a device.
pub const ENERGY_REST: f64 = 0.02;

/// Forecast over measured error of set-ups that it was not taken from: asked for; 0.91 to 1.73 measured.
pub const FORECAST: f64 = 2.0;

/// Linear flow between planes that cut links, over the speed: the surface is moved by 2.7e-5 cells, over a gap of ten.
pub const CUT_PLACE: f64 = 5e-6;

/// Shear stress on a plane that cuts links, in linear flow, wherever it lies. Measured: 2e-16, 6e-8, 1.5e-6 (double, single, device).
pub const CUT_SHEAR: f64 = 1e-5;

/// Friction of a plate of 16 cells with modelled boundary layers against Prandtl and Schlichting's law: the band of `ripstop validate wall-friction`, in which 16 cells at Re = 10⁶ are 4 % too
/// low along the lattice, 11 and 7 % too high at 15 and 30°.
pub const FRICTION_OF_A_PLATE: f64 = 0.2;

/// Momentum box against cut links, over a hundred steps: round-off, and both routes share nothing. Measured: 3e-14, 6e-5, 7e-5.
pub const fn cut_momentum_box(engine: Engine) -> f64 {
    match engine {
        Engine::CpuF64 => 1e-11,
        Engine::CpuF32 | Engine::Gpu | Engine::CpuF16 | Engine::GpuF16 => 5e-4,
    }
}

/// Lines against cut links while the canopy gathers way: what the solver's tolerance of 1e-2 leaves. Measured: 0.0041 with it, 0.0005 with 3e-3, 0.0003 with 1e-3.
pub const CUT_LINES: f64 = 0.01;

/// Defect of the air's mass with fabric whose pleats lie in single links, over the momentum box's. Measured: 2e-17, 6e-12, 5e-10; with each layer's own
/// velocity in place of the mean of both 1e-3.
pub const fn cut_mass(engine: Engine) -> f64 {
    match engine {
        Engine::CpuF64 => 1e-14,
        Engine::CpuF32 | Engine::Gpu | Engine::CpuF16 | Engine::GpuF16 => 1e-8,
    }
}

/// Density excess that air shut in a cell keeps: what is beyond it falls by a half in a step, measured by populations that move.
pub const SHUT_IN: f64 = 2e-3;

/// D_p/D_0 after 10 ms against double precision: which link a pleat shares first hangs on round-off. Measured: 0.015.
pub const OPENING_BY_LINKS: f64 = 0.05;

/// What single nodes have beside.
pub mod nodes {
    /// Force left at a node in equilibrium, of 50 N: the solver's tolerance of 1e-6.
    pub const BALANCE_N: f64 = 1e-3;

    /// Height over that of a weight alone, half period over that of a pendulum, loss over the energy at the start: a rope of 20 g swings beside a weight of 500 g.
    pub const BESIDE_A_ROPE: [f64; 3] = [0.07, 0.03, 0.03];

    /// Place of the middle of a thrown rope [m]: round-off over 300 steps. Angle that it has turned by, of 3 rad: it stretches as it spins, and its
    /// middle lags; 0.009 measured.
    pub const BATON: [f64; 2] = [1e-6, 0.02];

    /// Tension of a cable against that asked for: round-off.
    pub const PRETENSION: f64 = 1e-9;

    /// Period of a string of 20 pieces against that of a smooth one; its mean place, over two periods and a half.
    pub const STRING: [f64; 2] = [0.01, 0.1];

    /// Tension and thinning in the middle of a strip 20 times as long as wide: what its held sides do there.
    pub const STRIP: [f64; 2] = [0.01, 1e-3];

    /// Ratio of two sags, which go with the cube root of the stiffness while they are small: 8e-6 measured.
    pub const SAGS: f64 = 1e-3;
}
