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
// Nonlinear shear, 2ε₁₂ = c T + a T³ (src/fabric/shear.rs): c [m/N] and a [m³/N³].
override NONLINEAR_SHEAR: bool = false;
override SHEAR_COMPLIANCE: f32 = 1.0;
override SHEAR_CUBIC: f32 = 0.0;
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
    // How much strain the wrinkles take up across their crests; zero unless wrinkled.
    wrinkle_strain: f32,
}

// Tension of a linear sheet of the given shear stiffness.
fn stiff_with(shear: f32, e: vec3<f32>) -> vec3<f32> {
    return vec3<f32>(
        STIFFNESS_XX * e.x + STIFFNESS_XY * e.y + STIFFNESS_XS * e.z,
        STIFFNESS_XY * e.x + STIFFNESS_YY * e.y + STIFFNESS_YS * e.z,
        STIFFNESS_XS * e.x + STIFFNESS_YS * e.y + shear * e.z,
    );
}

// Root of a T³ + c T = γ: Newton's method from above falls towards it without overshooting.
fn shear_tension(strain: f32) -> f32 {
    let size = abs(strain);
    var tension = size / SHEAR_COMPLIANCE;
    if size > 0.0 && SHEAR_CUBIC * tension * tension * tension > size {
        tension = pow(size / SHEAR_CUBIC, 1.0 / 3.0);
    }
    for (var k = 0u; k < 6u; k++) {
        let square = SHEAR_CUBIC * tension * tension;
        tension -= (tension * (SHEAR_COMPLIANCE + square) - size) / (SHEAR_COMPLIANCE + 3.0 * square);
    }
    return select(tension, -tension, strain < 0.0);
}

// T/γ, at γ → 0 as well.
fn shear_secant(strain: f32) -> f32 {
    let tension = shear_tension(strain);
    return 1.0 / (SHEAR_COMPLIANCE + SHEAR_CUBIC * tension * tension);
}

// dT/dγ.
fn shear_tangent(strain: f32) -> f32 {
    let tension = shear_tension(strain);
    return 1.0 / (SHEAR_COMPLIANCE + 3.0 * SHEAR_CUBIC * tension * tension);
}

// Tension of the sheet as it is, without wrinkles.
fn stiff(e: vec3<f32>) -> vec3<f32> {
    var tension = stiff_with(STIFFNESS_SS, e);
    if NONLINEAR_SHEAR {
        tension.z = shear_tension(e.z);
    }
    return tension;
}

// Energy per rest area of that sheet.
fn energy_of(e: vec3<f32>, tension: vec3<f32>) -> f32 {
    if NONLINEAR_SHEAR {
        let square = tension.z * tension.z;
        return 0.5 * dot(e.xy, tension.xy) + square * (0.5 * SHEAR_COMPLIANCE + 0.75 * SHEAR_CUBIC * square);
    }
    return 0.5 * dot(e, tension);
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
fn gain(shear: f32, doubled: vec2<f32>, tension: vec3<f32>) -> f32 {
    let n = dyad(doubled);
    let across = min(dot(n, tension), 0.0);
    return across * across / dot(n, stiff_with(shear, n));
}

// Unit vector at twice the angle of the smaller principal direction of a symmetric tensor.
fn smaller_direction(xx: f32, yy: f32, xy: f32) -> vec2<f32> {
    let radius = circle(xx, yy, xy).y;
    if radius == 0.0 {
        return vec2<f32>(-1.0, 0.0);
    }
    return -vec2<f32>(0.5 * (xx - yy), xy) / radius;
}

// Direction that gives up most energy: that next to the best of the most negative tension's, of twelve from the guess on and of both bias
// directions; of a sheet that is soft in shear the better of those next to the best on either side of the warp.
fn wrinkle_direction(shear: f32, tension: vec3<f32>, guess: vec2<f32>) -> vec2<f32> {
    const STEP = vec2<f32>(0.8660254, 0.5);
    const NARROW = 0.05;
    var above = vec2<f32>(0.0, 1.0);
    var below = vec2<f32>(0.0, -1.0);
    var gain_above = gain(shear, above, tension);
    var gain_below = gain(shear, below, tension);
    var turning = guess;
    for (var k = 0u; k < 13u; k++) {
        var candidate = turning;
        if k == 12u {
            candidate = smaller_direction(tension.x, tension.y, tension.z);
        }
        let value = gain(shear, candidate, tension);
        if candidate.y < 0.0 {
            if value > gain_below {
                gain_below = value;
                below = candidate;
            }
        } else if value > gain_above {
            gain_above = value;
            above = candidate;
        }
        turning = turned(turning, STEP);
    }
    let is_below = gain_below > gain_above;
    let found = refined_direction(shear, tension, select(above, below, is_below));
    if shear < NARROW * min(STIFFNESS_XX, STIFFNESS_YY) && min(gain_above, gain_below) > 0.0 {
        let second = refined_direction(shear, tension, select(below, above, is_below));
        if gain(shear, second, tension) > gain(shear, found, tension) {
            return second;
        }
    }
    return found;
}

// The maximum next to a direction that gives up energy, by Newton's method inside a bracket.
fn refined_direction(shear: f32, tension: vec3<f32>, start: vec2<f32>) -> vec2<f32> {
    let best = normalize(start);
    // Rounding of tensions in a direction.
    let rounding = 2.4e-7 * (abs(tension.x) + abs(tension.y) + abs(tension.z));
    var low = -0.26794919; // tan 15°
    var high = 0.26794919;
    var tangent = 0.0;
    var found = best;
    for (var k = 0u; k < 30u; k++) {
        let share = 1.0 / (1.0 + tangent * tangent);
        let doubled = turned(best, vec2<f32>((1.0 - tangent * tangent) * share, 2.0 * tangent * share));
        found = doubled;
        let n = dyad(doubled);
        let n1 = vec3<f32>(-0.5 * doubled.y, 0.5 * doubled.y, doubled.x);
        let n2 = vec3<f32>(-0.5 * doubled.x, 0.5 * doubled.x, -doubled.y);
        let cn = stiff_with(shear, n);
        let t = dot(n, tension);
        let t1 = dot(n1, tension);
        let t2 = dot(n2, tension);
        let q = dot(n, cn);
        let q1 = 2.0 * dot(n1, cn);
        let q2 = 2.0 * (dot(n1, stiff_with(shear, n1)) + dot(n2, cn));
        // For t < 0 the gain rises while this is negative; where nothing pushes, the maximum lies towards the centre.
        let slope = 2.0 * t1 * q - t * q1;
        let curvature = 2.0 * t2 * q + t1 * q1 - t * q2;
        if abs(slope) <= rounding * (2.0 * q + abs(q1)) {
            break;
        }
        let pushes = t < 0.0;
        if select(tangent < 0.0, slope < 0.0, pushes) {
            low = tangent;
        } else {
            high = tangent;
        }
        let newton = tangent - slope / (curvature * 2.0 * share);
        let inside = pushes && newton > low && newton < high;
        let next = select(0.5 * (low + high), newton, inside);
        if abs(next - tangent) < 1e-8 {
            break;
        }
        tangent = next;
    }
    return found;
}

// A strain without its wrinkles.
struct Relaxed {
    strain: vec3<f32>,
    state: u32,
    // See Response.
    across: vec3<f32>,
}

// For a linear sheet of the given shear stiffness.
fn relax_linear(shear: f32, strain: vec3<f32>) -> Relaxed {
    let tension = stiff_with(shear, strain);
    let stress = circle(tension.x, tension.y, tension.z);
    if stress.x - stress.y >= 0.0 {
        return Relaxed(strain, TAUT, vec3<f32>(0.0));
    }
    let stretch = circle(strain.x, strain.y, 0.5 * strain.z);
    if stretch.x + stretch.y <= 0.0 {
        return Relaxed(vec3<f32>(0.0), SLACK, vec3<f32>(0.0));
    }
    var doubled = smaller_direction(strain.x, strain.y, 0.5 * strain.z);
    if !ISOTROPIC {
        doubled = wrinkle_direction(shear, tension, doubled);
    }
    let n = dyad(doubled);
    let excess = max(-dot(n, tension) / dot(n, stiff_with(shear, n)), 0.0);
    return Relaxed(strain + excess * n, WRINKLED, n);
}

// With nonlinear shear the sheet is that of the secant at the relaxed strain, whose logarithm is found by the secant method.
fn relax(strain: vec3<f32>) -> Relaxed {
    if !NONLINEAR_SHEAR {
        return relax_linear(STIFFNESS_SS, strain);
    }
    var shear = shear_secant(strain.z);
    var relaxed = relax_linear(shear, strain);
    var change = log(shear_secant(relaxed.strain.z) / shear);
    var slope = -1.0;
    for (var k = 0u; k < 60u; k++) {
        if relaxed.state == SLACK || abs(change) <= 3e-7 {
            break;
        }
        let stride = -change / slope;
        shear *= exp(stride);
        relaxed = relax_linear(shear, strain);
        let next = log(shear_secant(relaxed.strain.z) / shear);
        slope = clamp((next - change) / stride, -1.6666667, -0.33333334);
        change = next;
    }
    return relaxed;
}

// Energy, tension and state at a strain.
fn respond(strain: vec3<f32>) -> Response {
    let relaxed = relax(strain);
    let tension = stiff(strain);
    let energy = energy_of(strain, tension);
    if relaxed.state == TAUT {
        return Response(energy, TAUT, tension, relaxed.across, 0.0);
    }
    let kept = stiff(relaxed.strain);
    var wrinkle_strain = 0.0;
    if relaxed.state == WRINKLED {
        wrinkle_strain = dot(relaxed.across, relaxed.strain - strain) / dot(relaxed.across, relaxed.across);
    }
    return Response(
        (1.0 - RESIDUAL) * energy_of(relaxed.strain, kept) + RESIDUAL * energy,
        relaxed.state,
        (1.0 - RESIDUAL) * kept + RESIDUAL * tension,
        relaxed.across,
        wrinkle_strain,
    );
}

// Tangent stiffness [N/m], the second derivative of the energy (see the host's law for the derivation): C where taut; where wrinkled
// C - [C n, C n'] M^-1 [C n, C n']^T, n the wrinkles' n⊗n and n' its change as they turn; plus the residual (a thousandth at least).
struct Tangent {
    // Of the sheet as it is.
    kept: f32,
    shear: f32,
    // Of the sheet without its wrinkles.
    relaxed: f32,
    relaxed_shear: f32,
    // M, scaled such that its second diagonal entry is 1: the first, the mixed one, and the determinant.
    first: f32,
    mixed: f32,
    determinant: f32,
    pull: vec3<f32>,
    turning: vec3<f32>,
}

fn tangent_of(strain: vec3<f32>, response: Response) -> Tangent {
    var t = Tangent(1.0, STIFFNESS_SS, 0.0, STIFFNESS_SS, 1.0, 0.0, 1.0, vec3<f32>(0.0), vec3<f32>(0.0));
    if NONLINEAR_SHEAR {
        t.shear = shear_tangent(strain.z);
    }
    if response.state != TAUT {
        t.kept = max(RESIDUAL, 1e-3);
    }
    if response.state == WRINKLED {
        let n = response.across;
        let size = response.wrinkle_strain;
        let relaxed = strain + size * n;
        if NONLINEAR_SHEAR {
            t.relaxed_shear = shear_tangent(relaxed.z);
        }
        let tension = stiff(relaxed);
        let turned = vec3<f32>(-n.z, n.z, 2.0 * (n.x - n.y));
        let along = max(tension.x * n.y + tension.y * n.x - tension.z * n.z, 0.0);
        t.pull = stiff_with(t.relaxed_shear, n);
        let turning = stiff_with(t.relaxed_shear, turned);
        let resists = size * dot(turned, turning) + 2.0 * along;
        if resists > 0.0 {
            t.turning = sqrt(max(size / resists, 0.0)) * turning;
        }
        t.first = dot(n, t.pull);
        t.mixed = dot(n, t.turning);
        t.determinant = t.first - t.mixed * t.mixed;
        if t.determinant > 0.0 {
            t.relaxed = 1.0 - t.kept;
        }
    }
    return t;
}

fn apply_tangent(t: Tangent, e: vec3<f32>) -> vec3<f32> {
    let kept = t.kept * stiff_with(t.shear, e);
    if t.relaxed == 0.0 {
        return kept;
    }
    let along_pull = dot(t.pull, e);
    let along_turning = dot(t.turning, e);
    let lost = (along_pull - t.mixed * along_turning) * t.pull
        + (t.first * along_turning - t.mixed * along_pull) * t.turning;
    return kept + t.relaxed * (stiff_with(t.relaxed_shear, e) - lost / t.determinant);
}
