//! Parameters of the cloth's shaders.

use crate::gpu::shaders::parameters;

parameters! {
    /// What changes between dispatches (`shaders/cloth.wgsl`).
    ClothStage {
        /// Slot of the point to evaluate, or to write.
        point: u32,
        /// Slot of the point that a step starts from.
        start: u32,
        /// Slot of the direction.
        direction: u32,
        /// Slot of the gradient.
        gradient: u32,
        /// Slot of H₀ times the gradient.
        preconditioned: u32,
        /// Linear combinations in the program.
        operations: u32,
        /// Multiples of the direction.
        length: f32,
        /// No node moves farther than this [m].
        step_limit: f32,
        /// Inertia per mass [1/s²]; zero in the static limit.
        inertia: f32,
        /// One over the time step [1/s]; zero in the static limit.
        rate: f32,
        /// Time step [s]; zero in the static limit.
        time_step: f32,
        /// Stiffness below which a node is held by nothing [N/m].
        stiffness_floor: f32,
    }

    /// How fabric goes from step to step where the device makes them by itself (`shaders/fabric_motion.wgsl`).
    FabricMotion {
        /// Of x̂ beyond xⁿ: 1/3 of the last way in steps of BDF2, none in those of backward Euler.
        share: f32,
        /// 1/h [1/s].
        rate: f32,
        /// Mass-proportional damping [1/s].
        damping: f32,
        /// H₀ g of a solve that converged counts where no node moves farther by it [m].
        longest_remainder: f32,
    }

    /// Where the minimiser on the device stands (`shaders/minimiser_state.wgsl`).
    Minimiser {
        /// Share of `scale` that the energy norm may have.
        tolerance: f32,
        /// Displacement that counts as nothing [m].
        displacement_floor: f32,
        /// Pairs kept.
        history: u32,
        /// Evaluations allowed.
        evaluation_limit: u32,
        /// Whether it starts or runs, or why it ended.
        status: u32,
        /// Steps taken.
        iterations: u32,
        /// Evaluations of the objective.
        evaluations: u32,
        /// Trials along the present direction that were not taken.
        refused: u32,
        /// Iterations without progress.
        stagnant: u32,
        /// Pairs kept now.
        pairs: u32,
        /// Rows of products asked for.
        rows: u32,
        /// Slot of the present point.
        point: u32,
        /// Slot of its gradient.
        gradient: u32,
        /// Slot of H₀ times the gradient.
        preconditioned: u32,
        /// Objective of the point without what never changes [J].
        objective: f32,
        /// Round-off of that [J].
        round_off: f32,
        /// Energy norm.
        norm: f32,
        /// Longest displacement of a node in H₀ g [m].
        longest: f32,
        /// What the tolerance is relative to.
        scale: f32,
        /// Lowest norm so far.
        lowest_norm: f32,
        /// Slope of the objective along the direction.
        slope: f32,
        /// γ of the direction.
        direction_scale: f32,
    }
    /// The lattice of the air in space.
    CellsInSpace {
        /// Centre of its first cell: whole numbers of 2⁻¹⁶ m.
        origin_whole: [i32; 4],
        /// What is left of them [m].
        origin_remainder: [f32; 4],
        /// Size of a cell alike.
        cell_whole: i32,
        /// What is left of it [m].
        cell_remainder: f32,
        /// Cells in a metre.
        cells_per_m: f32,
        /// Unused.
        padding: u32,
    }
    /// A triangle that shares what the air does to another.
    PatchMember {
        /// The triangle.
        triangle: u32,
        /// Area as it was cut [cells²].
        area: f32,
        /// Which of the members the way to it passes last.
        via: u32,
        /// Where the other one stands among its own members.
        back: u32,
    }
}
