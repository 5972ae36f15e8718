//! What the shaders that decide know of the host's minimiser.

use crate::solve::lbfgs::{
    ARMIJO, LEAST_CURVATURE, LINE_SEARCH_LIMIT, OUT_OF_BALANCE, PROGRESS, RETREAT, ROUND_OFF_LIMIT,
    SHORTER, STAGNATION_LIMIT, WOLFE,
};

use super::slots::{FIRST_FREE, ROUND_OFF};

/// Names in `shaders/minimiser.wgsl`, and values.
pub(super) fn constants_of_the_host() -> [(&'static str, f64); 13] {
    [
        ("FIRST_FREE", f64::from(FIRST_FREE)),
        ("ROUND_OFF", ROUND_OFF),
        ("OUT_OF_BALANCE", OUT_OF_BALANCE),
        ("ARMIJO", ARMIJO),
        ("WOLFE", WOLFE),
        ("RETREAT", RETREAT),
        ("SHORTEST", SHORTER[0]),
        ("SHORTENED", SHORTER[1]),
        ("LEAST_CURVATURE", LEAST_CURVATURE),
        ("PROGRESS", PROGRESS),
        ("LINE_SEARCH_LIMIT", LINE_SEARCH_LIMIT as f64),
        ("STAGNATION_LIMIT", STAGNATION_LIMIT as f64),
        ("ROUND_OFF_LIMIT", ROUND_OFF_LIMIT as f64),
    ]
}
