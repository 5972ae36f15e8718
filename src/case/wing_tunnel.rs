//! Checks of `[structure.wing.tunnel]` and of the pulls of rows: a wing in the wind, and lines that are hauled in.

use glam::{DMat3, DVec3};

use super::file::{self, File, Friction, HalfName, HeldName};
use super::problem::Problem;
use super::usual;
use super::values::{vector, wing_key as key, within};
use crate::geometry::table::lookup;
use crate::geometry::wing::{self, LineKind};
use crate::lines::drag::LineDrag;

/// Shortest that a riser may be hauled in to, over its length.
const SHORTEST_RISER: f64 = 0.05;

/// C_d of a round line across the stream, if nothing is written (Hoerner, Fluid-Dynamic Drag, 1965, chapter 3).
pub(super) const USUAL_LINE_DRAG: f64 = 1.1;

/// How a wing stands in the wind.
#[derive(Debug, Clone)]
pub struct Tunnel {
    /// Turn about the hang points, nose up [rad].
    pub pitch_rad: f64,
    /// What is held.
    pub held: HeldName,
    /// How the air passes along panels and the ribs at the tips.
    pub friction: Friction,
    /// The same of what stands inside.
    pub inner_friction: Friction,
    /// The shape as designed, in its place and attitude [m], `[node_count]`; the wing may start laid together.
    pub designed_m: Vec<DVec3>,
}

/// Risers of a row that are hauled in.
#[derive(Debug, Clone, PartialEq)]
pub struct Pull {
    /// Number of the row in the plan.
    pub row: usize,
    /// The risers' segments, by their numbers among all cables.
    pub cables: Vec<usize>,
    /// Times [s] and lengths that the risers are shortened by then [m]; straight between them, constant beyond.
    pub points: Vec<[f64; 2]>,
}

impl Pull {
    /// Length that the risers are shortened by at a time [m].
    #[must_use]
    pub fn at(&self, time_s: f64) -> f64 {
        lookup(&self.points, time_s)
    }

    /// Time after which nothing is hauled any more [s].
    #[must_use]
    pub fn end_s(&self) -> f64 {
        self.points.last().map_or(0.0, |[time, _]| *time)
    }

    /// True if what was hauled in is let out again.
    #[must_use]
    pub fn lets_go(&self) -> bool {
        let most = self.points.iter().map(|p| p[1]).fold(0.0, f64::max);
        self.points.last().is_some_and(|p| p[1] < 0.5 * most)
    }
}

/// Checks that air and `[structure.wing.tunnel]` go together.
pub(super) fn check_air(file: &File, table: &file::Wing) -> Result<(), Problem> {
    let own = key("tunnel");
    let Some(air) = &file.air else {
        if table.tunnel.is_some() {
            return Err(Problem::new(
                own.as_str(),
                format!("[{own}] has no effect: it needs [air.wind_tunnel]"),
                format!("remove [{own}], or add the air"),
            ));
        }
        return Ok(());
    };
    if table.tunnel.is_none() {
        return Err(Problem::new(
            "air",
            format!(
                "a wing in moving air needs [{own}]: where its hang points are, and how it stands"
            ),
            format!("add [{own}] with place_m, or remove [air] and give [equilibrium]"),
        ));
    }
    if air.wind_tunnel.is_none() {
        return Err(Problem::new(
            "air",
            "a wing stands in a wind tunnel: falling wings are not computed yet",
            "give [air.wind_tunnel]",
        ));
    }
    if table.pitch_guide_n_m.is_some() {
        return Err(Problem::new(
            key("pitch_guide_n_m"),
            "the pitch guide stands for what prescribed pressure does not know: in the wind it would falsify lift and drag",
            "remove it",
        ));
    }
    Ok(())
}

/// Puts a wing where it stands in the wind; its structure then is at its start. Lines have the given diameters, by their numbers among all
/// cables.
pub(super) fn place(
    (wing, line_diameters_m): (&mut wing::BuiltWing, &[f64]),
    table: &file::Wing,
    written: &file::WingTunnel,
) -> Result<Tunnel, Problem> {
    let key = |name: &str| key(&format!("tunnel.{name}"));
    let place_m = vector(&key("place_m"), written.place_m)?;
    let pitch_rad = within(
        &key("pitch_deg"),
        usual::or(key("pitch_deg"), written.pitch_deg, 0.0),
        -90.0,
        90.0,
    )?
    .to_radians();
    let ratio = within(
        &key("start_thickness_ratio"),
        usual::or(
            key("start_thickness_ratio"),
            written.start_thickness_ratio,
            1.0,
        ),
        0.05,
        1.0,
    )?;
    let held = usual::or(key("held"), written.held, HeldName::HangPoints);
    if held == HeldName::Everything && ratio < 1.0 {
        return Err(Problem::new(
            key("start_thickness_ratio"),
            format!(
                "{} has no effect on a wing that is held everywhere: it would never fill",
                key("start_thickness_ratio")
            ),
            "remove it, or hold less",
        ));
    }
    let friction = usual::or(key("friction"), written.friction, Friction::None);
    let inner_friction = usual::or(
        key("inner_friction"),
        written.inner_friction,
        Friction::None,
    );
    let line_drag = usual::or(
        key("line_drag_coefficient"),
        written.line_drag_coefficient,
        USUAL_LINE_DRAG,
    );
    let line_drag = within(&key("line_drag_coefficient"), line_drag, 0.0, 10.0)?;
    if line_drag > 0.0 {
        wing.structure.give_lines_drag(|line| LineDrag {
            coefficient: line_drag,
            diameter_m: line_diameters_m[line],
        });
    }
    let middle_m = wing.hang_points.iter().fold(DVec3::ZERO, |sum, &node| {
        sum + 0.5 * wing.structure.positions_m[node as usize]
    });
    // Nose, at negative x, up.
    let turn = DMat3::from_rotation_y(pitch_rad);
    let placed = |places: &[DVec3]| -> Vec<DVec3> {
        let place = |p: &DVec3| place_m + turn * (*p - middle_m);
        places.iter().map(place).collect()
    };
    let designed_m = placed(&wing.structure.positions_m);
    wing.structure.positions_m = if ratio < 1.0 {
        placed(&wing.laid_together_m(&wing.structure.positions_m, ratio))
    } else {
        designed_m.clone()
    };
    // Lines that are hauled in have to move what they hang on.
    let hauled: Vec<bool> = table.rows.values().map(|row| row.pull.is_some()).collect();
    let attachments = wing.attachments(|row| !hauled[row]);
    let structure = &mut wing.structure;
    match held {
        HeldName::HangPoints => {}
        HeldName::Attachments => {
            for node in attachments {
                structure.held[node as usize] = true;
            }
        }
        HeldName::Everything => structure.held.fill(true),
    }
    Ok(Tunnel {
        pitch_rad,
        held,
        friction,
        inner_friction,
        designed_m,
    })
}

/// Checks the pulls of all rows.
pub(super) fn pulls(
    file: &File,
    table: &file::Wing,
    wing: &wing::BuiltWing,
) -> Result<Vec<Pull>, Problem> {
    let mut pulls = Vec::new();
    for (row, (name, written)) in table.rows.iter().enumerate() {
        let own = |of: &str| key(&format!("rows.{name}.{of}"));
        let key = own("pull");
        let Some(pull) = &written.pull else { continue };
        if file.time.is_none() {
            return Err(Problem::new(
                key.as_str(),
                format!("[{key}] needs [time]: an equilibrium knows none"),
                format!("add [time], or give {}", own("trim_m")),
            ));
        }
        let table = &pull.table;
        let grows = table.windows(2).all(|p| p[1][0] > p[0][0]);
        let shares = table.iter().all(|p| (0.0..=1.0).contains(&p[1]));
        let begins = table.first().is_some_and(|p| p[0] >= 0.0 && p[1] == 0.0);
        if !(grows && shares && begins) {
            return Err(Problem::new(
                own("pull.table"),
                format!(
                    "{} is no list of [time in s, share of length_m] that begins with a share of 0, with times growing from t = 0 on and shares from 0 to 1",
                    own("pull.table")
                ),
                "e.g. [[0.0, 0.0], [1.2, 1.0]]",
            ));
        }
        let length_m = within(&own("pull.length_m"), pull.length_m, 0.0, 1e3)?;
        let risers = wing.line_kinds.iter().enumerate();
        let risers = risers.filter(|(_, kind)| **kind == LineKind::Riser { row });
        // Right before left.
        let cables: Vec<usize> = risers
            .enumerate()
            .filter(|(half, _)| match pull.half {
                None => true,
                Some(HalfName::Right) => *half == 0,
                Some(HalfName::Left) => *half == 1,
            })
            .map(|(_, (cable, _))| cable)
            .collect();
        let shortest_m = cables
            .iter()
            .map(|&cable| wing.structure.cables[cable].rest_length_m)
            .fold(f64::INFINITY, f64::min);
        if length_m > (1.0 - SHORTEST_RISER) * shortest_m {
            return Err(Problem::new(
                own("pull.length_m"),
                format!(
                    "{} = {length_m} is too much for a riser of {shortest_m:.3} m",
                    own("pull.length_m")
                ),
                format!("haul in less, or make {} longer", own("riser_length_m")),
            ));
        }
        pulls.push(Pull {
            row,
            cables,
            points: table
                .iter()
                .map(|[t, share]| [*t, share * length_m])
                .collect(),
        });
    }
    Ok(pulls)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pulls_follow_their_table() {
        let pull = Pull {
            row: 0,
            cables: vec![0],
            points: vec![[0.5, 0.0], [1.5, 0.2], [2.0, 0.0]],
        };
        for (time_s, expected) in [
            (0.0, 0.0),
            (0.5, 0.0),
            (1.0, 0.1),
            (1.5, 0.2),
            (1.75, 0.1),
            (9.0, 0.0),
        ] {
            assert!((pull.at(time_s) - expected).abs() < 1e-12, "{time_s}");
        }
        assert!(pull.lets_go() && pull.end_s() == 2.0);
    }
}
