//! The results that a reader looks for first.

use crate::output::ReadOut;

/// Names of results, as they are declared, in the order in which a run prints them; those that it has, [`LENGTH`] at most.
pub static HEADLINE: [&str; 43] = [
    // Falls, descents, glides.
    "descent_rate_m_s",
    "terminal_speed_m_s",
    "drag_coefficient_terminal",
    "riser_force_terminal_n",
    "peak_load_factor_g",
    "speed_m_s",
    "sink_m_s",
    "glide_ratio",
    "angle_of_attack_deg",
    // What moves in the wind, or stands in it.
    "lift_coefficient",
    "{body}lift_coefficient",
    "{body}drag_coefficient",
    "drag_n",
    "force_x_n",
    "force_z_n",
    "{body}drag_coefficient_blockage_corrected",
    "lift_to_drag_ratio",
    "{body}strouhal_number",
    "projected_diameter_ratio",
    "opening_force_factor",
    "fill_time_s",
    "tip_peak_to_peak_m",
    "internal_pressure_coefficient_mean",
    "volume_ratio_min",
    "row_{row}_load_share",
    "row_{row}_load_n",
    "line_load_over_breaking_load_max",
    "velocity_decay_rate_1_s",
    // Fabric and cables.
    "sag_m",
    "horizontal_tension_n",
    "end_tension_n",
    "half_height_m",
    "highest_point_m",
    "lowest_point_m",
    "pull_n",
    "gauge_strain",
    "modulus_pa",
    "line_tension_max_n",
    "stress_max_pa",
    "tension_max_n_m",
    "wrinkled_area_share",
    "held_force_n",
    "volume_m3",
];

/// The same of a glide, before all others.
static OF_A_GLIDE: [&str; 7] = [
    "speed_m_s",
    "sink_m_s",
    "glide_ratio",
    "line_load_over_breaking_load_max",
    "load_test_first_failure_load_factor",
    "stress_max_pa",
    "row_{row}_load_n",
];

/// The same of an opening behind a payload.
static OF_A_FALL: [&str; 9] = [
    "terminal_speed_m_s",
    "drag_coefficient_terminal",
    "riser_force_terminal_n",
    "peak_load_factor_g",
    "line_tension_max_n",
    "line_load_over_breaking_load_max",
    "stress_max_pa",
    "fill_time_s",
    "largest_projected_diameter_ratio",
];

/// Results of a headline, but for those that complete a family such as the loads of all rows.
pub const LENGTH: usize = 8;

/// The most with them.
const MOST: usize = 12;

/// Those of a run's results that belong to its headline, in its order.
#[must_use]
pub fn headline<'a>(results: impl Iterator<Item = &'a str> + Clone) -> Vec<&'a str> {
    let mut found = Vec::new();
    // How many were found with every declared name.
    let mut ends = Vec::new();
    let has = |wanted: &str| results.clone().any(|name| name == wanted);
    let first = if has("glide_ratio") {
        &OF_A_GLIDE[..]
    } else if has("peak_load_factor_g") {
        &OF_A_FALL[..]
    } else {
        &[]
    };
    for name in first.iter().chain(&HEADLINE) {
        let declared = ReadOut::new(name, "", "");
        for name in results.clone() {
            if declared.covers(name) && !found.contains(&name) {
                found.push(name);
            }
        }
        ends.push(found.len());
    }
    let family_ends = ends.into_iter().find(|end| *end >= LENGTH);
    found.truncate(family_ends.unwrap_or(LENGTH).min(MOST));
    found
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::measure::declared_results;

    #[test]
    fn every_name_is_that_of_a_result() {
        let declared = declared_results();
        for name in HEADLINE.into_iter().chain(OF_A_GLIDE).chain(OF_A_FALL) {
            assert!(declared.iter().any(|one| one.name == name), "{name}");
        }
    }

    #[test]
    fn a_headline_is_in_order_and_short() {
        let all = [
            "stress_max_pa",
            "row_b_load_n",
            "drag_n",
            "sphere_drag_coefficient",
            "row_a_load_n",
            "drag_coefficient",
        ];
        let found = headline(all.into_iter());
        assert_eq!(
            found[..3],
            ["sphere_drag_coefficient", "drag_coefficient", "drag_n"]
        );
        assert_eq!(
            found[3..],
            ["row_b_load_n", "row_a_load_n", "stress_max_pa"]
        );
        let glide = [
            "row_a_load_n",
            "angle_of_attack_deg",
            "glide_ratio",
            "speed_m_s",
        ];
        assert_eq!(
            headline(glide.into_iter()),
            [
                "speed_m_s",
                "glide_ratio",
                "row_a_load_n",
                "angle_of_attack_deg"
            ]
        );
        let many: Vec<String> = (0..20).map(|k| format!("row_{k}_load_n")).collect();
        assert_eq!(headline(many.iter().map(String::as_str)).len(), MOST);
        // All rows of a glide, though there are more than room for.
        let rows = ["a", "b", "c", "d"].map(|row| format!("row_{row}_load_n"));
        let others = [
            "speed_m_s",
            "sink_m_s",
            "glide_ratio",
            "stress_max_pa",
            "drag_n",
        ];
        let all = rows.iter().map(String::as_str).chain(others);
        let found = headline(all.clone());
        assert_eq!(found.len(), LENGTH);
        assert!(rows.iter().all(|row| found.contains(&row.as_str())));
        let found = headline(all.chain(["line_load_over_breaking_load_max"]));
        assert_eq!((found.len(), found.last()), (9, Some(&"row_d_load_n")));
    }
}
