// Membrane that carries tension only; the formulas of src/fabric/membrane.rs.
// Strains are Green's in Voigt form (xx, yy, 2·xy); tensions are second Piola–Kirchhoff times thickness [N/m].
// Departure: the wrinkle direction is refined in the tangent of half the angle from the best of the spaced directions, so no
// sine or arc tangent of the device enters.

// Stiffness [N/m], symmetric.
override STIFFNESS_XX: f32 = 1.0;
override STIFFNESS_XY: f32 = 0.0;
override STIFFNESS_XS: f32 = 0.0;
override STIFFNESS_YY: f32 = 1.0;
override STIFFNESS_YS: f32 = 0.0;
override STIFFNESS_SS: f32 = 1.0;
// Share of the compressive stiffness that is kept.
override RESIDUAL: f32 = 0.0;
override ISOTROPIC: bool = false;

const TAUT: u32 = 0u;
const WRINKLED: u32 = 1u;
const SLACK: u32 = 2u;

struct Response {
    // Per rest area [J/m²].
    energy: f32,
    state: u32,
    tension: vec3<f32>,
    // n⊗n as a strain, n across the crests; zero unless wrinkled.
    across: vec3<f32>,
}

fn stiff(e: vec3<f32>) -> vec3<f32> {
    return vec3<f32>(
        STIFFNESS_XX * e.x + STIFFNESS_XY * e.y + STIFFNESS_XS * e.z,
        STIFFNESS_XY * e.x + STIFFNESS_YY * e.y + STIFFNESS_YS * e.z,
        STIFFNESS_XS * e.x + STIFFNESS_YS * e.y + STIFFNESS_SS * e.z,
    );
}

// Mean and radius of Mohr's circle of a symmetric tensor.
fn circle(xx: f32, yy: f32, xy: f32) -> vec2<f32> {
    let half_difference = 0.5 * (xx - yy);
    return vec2<f32>(0.5 * (xx + yy), sqrt(half_difference * half_difference + xy * xy));
}

// n⊗n as a strain; `doubled` is the unit vector at twice the angle of n.
fn dyad(doubled: vec2<f32>) -> vec3<f32> {
    return vec3<f32>(0.5 * (1.0 + doubled.x), 0.5 * (1.0 - doubled.x), doubled.y);
}

fn turned(v: vec2<f32>, by: vec2<f32>) -> vec2<f32> {
    return vec2<f32>(v.x * by.x - v.y * by.y, v.y * by.x + v.x * by.y);
}

// Energy given up by wrinkling across `doubled`, doubled.
fn gain(doubled: vec2<f32>, tension: vec3<f32>) -> f32 {
    let n = dyad(doubled);
    let across = min(dot(n, tension), 0.0);
    return across * across / dot(n, stiff(n));
}

// Refines the direction that gives up most energy: the best of twelve, then Newton's method inside its bracket.
fn wrinkle_direction(tension: vec3<f32>, guess: vec2<f32>) -> vec2<f32> {
    const STEP = vec2<f32>(0.8660254, 0.5);
    var best = guess;
    var best_gain = gain(guess, tension);
    var candidate = guess;
    for (var k = 1u; k < 12u; k++) {
        candidate = turned(candidate, STEP);
        let value = gain(candidate, tension);
        if value > best_gain {
            best_gain = value;
            best = candidate;
        }
    }
    best = normalize(best);
    var low = -0.26794919; // tan 15°
    var high = 0.26794919;
    var tangent = 0.0;
    var found = best;
    for (var k = 0u; k < 20u; k++) {
        let share = 1.0 / (1.0 + tangent * tangent);
        let doubled = turned(best, vec2<f32>((1.0 - tangent * tangent) * share, 2.0 * tangent * share));
        found = doubled;
        let n = dyad(doubled);
        let n1 = vec3<f32>(-0.5 * doubled.y, 0.5 * doubled.y, doubled.x);
        let n2 = vec3<f32>(-0.5 * doubled.x, 0.5 * doubled.x, -doubled.y);
        let cn = stiff(n);
        let t = dot(n, tension);
        let t1 = dot(n1, tension);
        let t2 = dot(n2, tension);
        let q = dot(n, cn);
        let q1 = 2.0 * dot(n1, cn);
        let q2 = 2.0 * (dot(n1, stiff(n1)) + dot(n2, cn));
        // For t < 0 the gain rises while this is negative.
        let slope = 2.0 * t1 * q - t * q1;
        let curvature = 2.0 * t2 * q + t1 * q1 - t * q2;
        if slope < 0.0 {
            low = tangent;
        } else {
            high = tangent;
        }
        let newton = tangent - slope / (curvature * 2.0 * share);
        let inside = newton > low && newton < high;
        let next = select(0.5 * (low + high), newton, inside);
        if abs(next - tangent) < 1e-8 {
            break;
        }
        tangent = next;
    }
    return found;
}

// Energy, tension and state at a strain.
fn respond(strain: vec3<f32>) -> Response {
    let tension = stiff(strain);
    let energy = 0.5 * dot(strain, tension);
    let stress = circle(tension.x, tension.y, tension.z);
    if stress.x - stress.y >= 0.0 {
        return Response(energy, TAUT, tension, vec3<f32>(0.0));
    }
    let stretch = circle(strain.x, strain.y, 0.5 * strain.z);
    if stretch.x + stretch.y <= 0.0 {
        return Response(RESIDUAL * energy, SLACK, RESIDUAL * tension, vec3<f32>(0.0));
    }
    var doubled = vec2<f32>(-1.0, 0.0);
    if stretch.y != 0.0 {
        doubled = -vec2<f32>(0.5 * (strain.x - strain.y), 0.5 * strain.z) / stretch.y;
    }
    if !ISOTROPIC {
        doubled = wrinkle_direction(tension, doubled);
    }
    let n = dyad(doubled);
    let excess = max(-dot(n, tension) / dot(n, stiff(n)), 0.0);
    let relaxed_strain = strain + excess * n;
    let relaxed = stiff(relaxed_strain);
    let relaxed_energy = 0.5 * dot(relaxed_strain, relaxed);
    return Response(
        (1.0 - RESIDUAL) * relaxed_energy + RESIDUAL * energy,
        WRINKLED,
        (1.0 - RESIDUAL) * relaxed + RESIDUAL * tension,
        n,
    );
}

// Positive semidefinite tangent stiffness [N/m], applied to a strain: the full stiffness where taut, the stiffness along the
// crests and against turning them where wrinkled, plus the residual (a thousandth at least).
struct Tangent {
    share: f32,
    stiffness_along: f32,
    turning: f32,
    along: vec3<f32>,
    turn: vec3<f32>,
}

fn tangent_of(strain: vec3<f32>, response: Response) -> Tangent {
    var t = Tangent(1.0, 0.0, 0.0, vec3<f32>(0.0), vec3<f32>(0.0));
    if response.state != TAUT {
        t.share = max(RESIDUAL, 1e-3);
    }
    if response.state == WRINKLED {
        let n = response.across;
        t.along = vec3<f32>(n.y, n.x, -0.5 * n.z);
        t.turn = vec3<f32>(-n.z, n.z, n.x - n.y);
        let across = vec3<f32>(n.x, n.y, 0.5 * n.z);
        let s = response.tension;
        let tension_along = max(s.x * n.y + s.y * n.x - s.z * n.z, 0.0);
        let strain_along = dot(t.along, strain);
        if strain_along > 0.0 {
            t.stiffness_along = tension_along / strain_along;
        }
        t.turning = 0.5 * tension_along / max(strain_along - dot(across, strain), 1e-12);
    }
    return t;
}

fn apply_tangent(t: Tangent, e: vec3<f32>) -> vec3<f32> {
    return t.share * stiff(e)
        + (t.stiffness_along * dot(t.along, e)) * t.along
        + (t.turning * dot(t.turn, e)) * t.turn;
}
