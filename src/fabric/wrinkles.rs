//! Direction of wrinkles in orthotropic fabric.

use std::f64::consts::PI;

use super::plane::{Matrix3, dot, smaller_direction, times};

/// Iterations for the direction of wrinkles; five are usual, and halving alone takes forty.
const DIRECTION_LIMIT: usize = 50;

/// Rounding of tensions in a direction, over the tensions.
const ROUNDING: f64 = 4.0 * f64::EPSILON;

/// Shear stiffness over the smaller of warp and weft below which both sides of the warp are searched.
const NARROW: f64 = 0.05;

/// n⊗n of the direction n that maximises the energy given up by wrinkling, ½ t²/q with t = n·σn < 0 and q = nn:C:nn.
///
/// In the doubled angle φ, n⊗n = ½ (1 + cos φ, 1 − cos φ), 2 n_x n_y = sin φ, so both t and q are short trigonometric polynomials.
/// Newton's method on 2 t′q − t q′ = 0, kept inside a bracket, starts from the best of: directions of 30° in φ from `guess` on; that of the
/// most negative tension, without which a small compression may lie between all of them; and both bias directions, around which a sheet that is soft
/// in shear has narrow maxima. Such a sheet is searched from the best on either side of the warp, since a narrow maximum is higher than what is seen
/// beside it.
pub(super) fn wrinkle_direction(
    stiffness: &Matrix3,
    tension: &[f64; 3],
    guess: &[f64; 3],
) -> [f64; 3] {
    // cos and sin of 30° steps.
    const SQRT_3_2: f64 = 0.866_025_403_784_438_6;
    const STEPS: [[f64; 2]; 12] = [
        [1.0, 0.0],
        [SQRT_3_2, 0.5],
        [0.5, SQRT_3_2],
        [0.0, 1.0],
        [-0.5, SQRT_3_2],
        [-SQRT_3_2, 0.5],
        [-1.0, 0.0],
        [-SQRT_3_2, -0.5],
        [-0.5, -SQRT_3_2],
        [0.0, -1.0],
        [0.5, -SQRT_3_2],
        [SQRT_3_2, -0.5],
    ];
    const BIAS: [[f64; 2]; 2] = [[0.0, 1.0], [0.0, -1.0]];
    let gain = |c: f64, s: f64| {
        let n = dyad_of(c, s);
        let across = dot(&n, tension).min(0.0);
        across * across / dot(&n, &times(stiffness, &n))
    };
    let (start_c, start_s) = (guess[0] - guess[1], guess[2]);
    // The guess turned by multiples of 30°.
    let turned = STEPS.map(|[c, s]| [start_c * c - start_s * s, start_s * c + start_c * s]);
    let pushed = smaller_direction(tension[0], tension[1], tension[2]);
    let candidates = [[pushed[0] - pushed[1], pushed[2]]];
    let candidates = candidates.into_iter().chain(turned).chain(BIAS);
    // The best on either side of the warp.
    let mut best = [([0.0; 2], 0.0); 2];
    for candidate in candidates {
        let value = gain(candidate[0], candidate[1]);
        let side = &mut best[usize::from(candidate[1] < 0.0)];
        if value > side.1 {
            *side = (candidate, value);
        }
    }
    let [better, other] = if best[1].1 > best[0].1 {
        [best[1], best[0]]
    } else {
        best
    };
    let found = refined_direction(stiffness, tension, better.0);
    let is_soft = stiffness[2][2] < NARROW * stiffness[0][0].min(stiffness[1][1]);
    if is_soft && other.1 > 0.0 {
        let second = refined_direction(stiffness, tension, other.0);
        if gain(second[0], second[1]) > gain(found[0], found[1]) {
            return dyad_of(second[0], second[1]);
        }
    }
    dyad_of(found[0], found[1])
}

/// n⊗n, as a strain, of a unit vector at twice the angle of n.
const fn dyad_of(c: f64, s: f64) -> [f64; 3] {
    [0.5 * (1.0 + c), 0.5 * (1.0 - c), s]
}

/// The direction, as a unit vector at twice its angle, of the maximum next to one that gives up energy.
fn refined_direction(stiffness: &Matrix3, tension: &[f64; 3], start: [f64; 2]) -> [f64; 2] {
    let centre = start[1].atan2(start[0]);
    let rounding = ROUNDING * (tension[0].abs() + tension[1].abs() + tension[2].abs());
    let (mut low, mut high) = (centre - PI / 6.0, centre + PI / 6.0);
    let mut angle = centre;
    for _ in 0..DIRECTION_LIMIT {
        let (s, c) = angle.sin_cos();
        let (n, n1, n2) = (
            dyad_of(c, s),
            [-0.5 * s, 0.5 * s, c],
            [-0.5 * c, 0.5 * c, -s],
        );
        let (cn, cn1) = (times(stiffness, &n), times(stiffness, &n1));
        let (t, t1, t2) = (dot(&n, tension), dot(&n1, tension), dot(&n2, tension));
        let (q, q1) = (dot(&n, &cn), 2.0 * dot(&n1, &cn));
        let q2 = 2.0 * (dot(&n1, &cn1) + dot(&n2, &cn));
        // For t < 0 the gain rises while this is negative; where nothing pushes, the maximum lies towards the centre.
        let slope = 2.0 * t1 * q - t * q1;
        let curvature = 2.0 * t2 * q + t1 * q1 - t * q2;
        let is_before = if t < 0.0 { slope < 0.0 } else { angle < centre };
        if is_before {
            low = angle
        } else {
            high = angle
        }
        let newton = angle - slope / curvature;
        let next = if t < 0.0 && newton > low && newton < high {
            newton
        } else {
            0.5 * (low + high)
        };
        let moved = (next - angle).abs();
        if slope.abs() <= rounding * (2.0 * q + q1.abs()) {
            break;
        }
        angle = next;
        if moved < 1e-12 {
            break;
        }
    }
    [angle.cos(), angle.sin()]
}
