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
}
