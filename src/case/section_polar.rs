//! Polars of sections as a case gives them: rows, files of XFOIL, or how they are to be computed.

use super::problem::Problem;
use super::usual;
use super::values::within;
use crate::aero::polar::{Polar, PolarPoint};

/// Where the polar of a profile is from.
#[derive(Debug, Clone)]
pub enum SectionPolar {
    /// Given.
    Given(Polar),
    /// To be computed at the Reynolds numbers of its strips.
    Computed {
        /// Exponent of the amplification at which a layer turns turbulent.
        critical_amplification: f64,
        /// x/c above and below at which it does so at the latest.
        transition: [Option<f64>; 2],
    },
}

/// How a polar is to be computed.
pub(super) fn computed(
    key: &str,
    critical: Option<f64>,
    transition: Option<[f64; 2]>,
) -> Result<SectionPolar, Problem> {
    let own = |name: &str| format!("{key}.{name}");
    let critical = usual::or(own("critical_amplification"), critical, 9.0);
    let place = |place: f64| within(&own("transition"), place, 0.0, 1.0);
    let transition = match transition {
        Some([above, below]) => [Some(place(above)?), Some(place(below)?)],
        None => [None; 2],
    };
    Ok(SectionPolar::Computed {
        critical_amplification: within(&own("critical_amplification"), critical, 0.5, 20.0)?,
        transition,
    })
}

/// Angle in degrees, lift and drag, and the moment where it is known.
pub(super) type PolarRow = ([f64; 3], Option<f64>);

pub(super) fn polar_of(key: &str, rows: &[PolarRow]) -> Result<Polar, Problem> {
    let points = rows
        .iter()
        .map(|&([degrees, lift, drag], moment)| PolarPoint {
            angle_rad: degrees.to_radians(),
            lift,
            drag,
            moment,
        });
    Polar::new(points.collect()).map_err(|why| {
        Problem::new(
            key,
            format!("{key}: {why}"),
            "give rows [angle in degrees, lift coefficient, drag coefficient] with growing angles",
        )
    })
}

/// Rows of a file as XFOIL writes it: a head, a line of dashes, then rows of numbers; angles of repeated points are taken once.
pub(super) fn rows_of_xfoil(text: &str) -> Vec<PolarRow> {
    let mut rows: Vec<PolarRow> = text
        .lines()
        .filter_map(|line| {
            let numbers: Result<Vec<f64>, _> = line.split_whitespace().map(str::parse).collect();
            match *numbers.ok()? {
                [angle, lift, drag, _, moment, ..] => Some(([angle, lift, drag], Some(moment))),
                _ => None,
            }
        })
        .collect();
    rows.sort_by(|a, b| a.0[0].total_cmp(&b.0[0]));
    rows.dedup_by(|a, b| a.0[0] == b.0[0]);
    rows
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn polars_of_xfoil_are_read() {
        let text = "
       XFOIL         Version 6.99
 Calculated polar for: NACA 0012
 xtrf =   1.000 (top)        1.000 (bottom)
 Mach =   0.000     Re =     1.000 e 6     Ncrit =   9.000

   alpha    CL        CD       CDp       CM     Top_Xtr  Bot_Xtr
  ------ -------- --------- --------- -------- -------- --------
   1.000   0.1100   0.00550   0.00100   0.0010   0.5000   0.8000
   0.000   0.0000   0.00540   0.00100   0.0000   0.6500   0.6500
   1.000   0.1100   0.00550   0.00100   0.0000   0.5000   0.8000
";
        assert_eq!(
            rows_of_xfoil(text),
            [
                ([0.0, 0.0, 0.0054], Some(0.0)),
                ([1.0, 0.11, 0.0055], Some(0.001))
            ]
        );
    }
}
