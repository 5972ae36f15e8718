//! The speed on the lattice, `resolution.lattice_speed`: as given, or that of the real speed of sound.

use super::problem::Problem;
use super::usual;
use super::values::positive;

/// Largest lattice speed allowed: Mach 0.26, where the error of weak compressibility, of order Ma², reaches 7 %.
pub const LATTICE_SPEED_LIMIT: f64 = 0.15;

/// Largest lattice speed that is taken without being asked for: Mach 0.14, an error of 2 %.
const FASTEST: f64 = 0.08;

/// Smallest lattice speed at which sound is as fast as in reality; slower winds would take too many steps.
const SLOWEST: f64 = 0.03;

/// Lattice speed of winds that are slower. From 0.05 to 0.12 the drag of a canopy does not move beyond its interval, and a sphere's by 0.7 %
/// (docs/results/2026-11-24-quiet-and-stable-air.md): fewer steps cost nothing.
const OF_SLOW_WIND: f64 = 0.08;

/// Checks `resolution.lattice_speed`, or derives it from the speed that it stands for and the speed of sound, `None` of liquids [m/s].
pub(super) fn check(
    written: Option<f64>,
    reference_speed_m_s: f64,
    sound_m_s: Option<f64>,
) -> Result<f64, Problem> {
    const KEY: &str = "resolution.lattice_speed";
    let Some(written) = written else {
        return Ok(usual::noted(KEY, derived(reference_speed_m_s, sound_m_s)));
    };
    let lattice_speed = positive(KEY, written)?;
    if lattice_speed > LATTICE_SPEED_LIMIT {
        return Err(Problem::new(
            KEY,
            format!(
                "{KEY} = {lattice_speed} is Mach {:.2}: too high for a weakly compressible method",
                lattice_speed * 3f64.sqrt()
            ),
            format!("choose at most {LATTICE_SPEED_LIMIT} (Mach 0.26); 0.08 is usual"),
        ));
    }
    Ok(lattice_speed)
}

/// Lattice speed without one given. On the lattice sound moves 1/√3 of a cell per step.
fn derived(reference_speed_m_s: f64, sound_m_s: Option<f64>) -> f64 {
    let of_sound = sound_m_s.map_or(0.0, |sound| reference_speed_m_s / sound / 3f64.sqrt());
    if of_sound < SLOWEST {
        OF_SLOW_WIND
    } else {
        of_sound.min(FASTEST)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::case::scene::SOUND_M_S;

    /// 25 m/s is Mach 0.0735; 5 m/s would take 0.0085; 80 m/s 0.136.
    #[test]
    fn without_one_sound_is_as_fast_as_it_is_where_that_is_affordable() {
        let of = |speed: f64, sound| check(None, speed, sound).unwrap();
        for (speed, lattice_speed) in [(25.0, 0.042_415), (5.0, OF_SLOW_WIND), (80.0, 0.08)] {
            let found = of(speed, Some(SOUND_M_S));
            assert!((found - lattice_speed).abs() < 1e-6, "{speed}: {found}");
        }
        // Thin cold air, in which sound is slower, and a liquid.
        assert!(of(25.0, Some(299.5)) > 0.048);
        assert_eq!(of(25.0, None), OF_SLOW_WIND);
    }

    #[test]
    fn a_derived_one_is_told_and_a_given_one_untouched() {
        let told = |written| {
            let (found, taken) = usual::collected(|| check(written, 25.0, Some(SOUND_M_S)));
            (
                found.unwrap(),
                taken.get("resolution.lattice_speed").cloned(),
            )
        };
        let (found, taken) = told(None);
        assert_eq!(taken.unwrap(), found);
        for given in [0.01, 0.1, LATTICE_SPEED_LIMIT] {
            assert_eq!(told(Some(given)), (given, None));
        }
        assert!(check(Some(0.2), 25.0, None).is_err());
        assert!(check(Some(0.0), 25.0, None).is_err());
    }
}
