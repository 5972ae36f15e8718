// Where the minimiser of a time step stands, between one trial and the next.

// Mirrors gpu::cloth::parameters::Minimiser.
struct Minimiser {
    // Share of `scale` that the energy norm may have; displacement that counts as nothing [m].
    tolerance: f32,
    displacement_floor: f32,
    // Pairs kept; evaluations allowed.
    history: u32,
    evaluation_limit: u32,
    // STARTS, RUNS, or why it ended; so far.
    status: u32,
    iterations: u32,
    evaluations: u32,
    // Trials along the present direction that were not taken; iterations without progress; pairs kept now; rows of products asked for.
    refused: u32,
    stagnant: u32,
    pairs: u32,
    rows: u32,
    // Slots of the present point, its gradient, and H₀ times that.
    point: u32,
    gradient: u32,
    preconditioned: u32,
    // Of the present point: objective and its round-off without what never changes [J], energy norm, longest displacement of H₀ g [m].
    objective: f32,
    round_off: f32,
    norm: f32,
    longest: f32,
    // What the tolerance is relative to; lowest norm so far; slope of the objective along the direction.
    scale: f32,
    lowest_norm: f32,
    slope: f32,
    // γ
    direction_scale: f32,
}

// Mirrors gpu::cloth::decisions::STOPS.
const STARTS: u32 = 0u;
const RUNS: u32 = 1u;
const CONVERGED: u32 = 2u;
const ROUND_OFF_REACHED: u32 = 3u;
const STALLED: u32 = 4u;
const LIMIT_REACHED: u32 = 5u;
const NOT_FINITE: u32 = 6u;
const INDEFINITE: u32 = 7u;
