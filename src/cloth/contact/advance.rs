//! How far a pair may go along a step before its sides touch: additive continuous collision detection (Li, Kaufman & Jiang 2021,
//! algorithm 1).
//!
//! What both sides move in common cannot bring them together and is taken out. The rest shortens the distance by at most the fastest
//! node of either side, so the pair is safe for as long as that takes; there the distance is measured again, until it has fallen to a
//! share of what it was, or the step is over. No roots are sought, and no rounding can let a pair through.

use glam::DVec3;

use super::pairs::Pair;

/// Share of the distance that is left at least.
const REST: f64 = 0.1;

/// Times that a distance is measured; stopping early is safe.
const LIMIT: usize = 32;

/// Share of `step` [m], a displacement of all nodes, that the pair may go: at most `limit`, and all of it where the sides do not meet.
/// The distance along the way is at least a tenth of the present one.
#[must_use]
pub fn free_share(
    pair: &Pair,
    positions: &[DVec3],
    step: impl Fn(usize) -> DVec3,
    limit: f64,
) -> f64 {
    let places = pair.places(positions);
    let mut moves = pair.nodes.map(|node| step(node as usize));
    let common = 0.25 * (moves[0] + moves[1] + moves[2] + moves[3]);
    for m in &mut moves {
        *m -= common;
    }
    let squares = moves.map(DVec3::length_squared);
    let [first, second] = pair.sides();
    let fastest =
        |side: std::ops::Range<usize>| squares[side].iter().copied().fold(0.0, f64::max).sqrt();
    let speed = fastest(first) + fastest(second);
    let mut gap = pair.gap_m(&places);
    let least = REST * gap;
    if gap - least >= limit * speed {
        return limit;
    }
    let mut share = 0.0;
    for _ in 0..LIMIT {
        let next = share + (gap - least) / speed;
        if next >= limit {
            return limit;
        }
        let there: [DVec3; 4] = std::array::from_fn(|i| places[i] + moves[i] * next);
        gap = pair.gap_m(&there);
        share = next;
        // Half the rest again, so that what rounding adds to the way there is no concern.
        if gap <= 1.5 * least {
            break;
        }
    }
    share
}
