// What every stage of the cloth shares: parameters, points, and how elements read them.
//
// A point holds, for each coordinate, a whole number of 2⁻¹⁶ m and a remainder: 5e-13 m anywhere within ±32 km. Differences of
// the whole numbers are exact, so edges and displacements keep the precision of the remainders. The predicted point of
// a step is kept apart (`predicted_whole`, `predicted_remainder`); displacements count from it.

// Mirrors gpu::cloth::parameters::ClothStage.
struct ClothStage {
    // Slots: the point to evaluate or to write; the point a step starts from; vectors.
    point: u32,
    start: u32,
    direction: u32,
    gradient: u32,
    preconditioned: u32,
    // Linear combinations in the program.
    operations: u32,
    // Multiples of the direction; largest displacement of a node [m].
    length: f32,
    step_limit: f32,
    // Inertia per mass [1/s²], 1/time step [1/s] and time step [s]; zero in the static limit.
    inertia: f32,
    rate: f32,
    time_step: f32,
    // Stiffness below which a node is held by nothing [N/m].
    stiffness_floor: f32,
}

override NODES: u32 = 1u;

const UNIT: f32 = 0.0000152587890625; // 2⁻¹⁶ m
const UNIT_SQUARE: f32 = 2.3283064365386963e-10; // 2⁻³² m²

struct Place {
    whole: vec3<i32>,
    remainder: vec3<f32>,
}

// b − a.
fn between(a: Place, b: Place) -> Place {
    return Place(b.whole - a.whole, b.remainder - a.remainder);
}

fn metres(p: Place) -> vec3<f32> {
    return vec3<f32>(p.whole) * UNIT + p.remainder;
}
