//! Loads of lines, and of tapes, belts and bands that are sewn on the fabric, over their breaking loads.

use crate::cloth::Structure;
use crate::frame::CableKind;

/// What of the cables is asked for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Carrier {
    /// Suspension lines, what goes on from them over gaps and vents, and risers.
    Lines,
    /// What is sewn on the fabric.
    Tapes,
}

/// Breaking load of every cable segment of the kind \[N\], `[cable_count]`; `None` for other cables, and where it is not told.
pub(super) fn strengths_n(structure: &Structure, of: Carrier) -> impl Iterator<Item = Option<f64>> {
    structure.cables.iter().map(move |cable| {
        let is_tape = cable.kind == CableKind::Belt;
        let is_asked = is_tape == (of == Carrier::Tapes);
        cable.breaking_load_n.filter(|_| is_asked)
    })
}

/// Load over breaking load of all cables of the kind whose breaking load is told, by the tensions of all cable segments \[N\].
pub(crate) fn load_shares(
    structure: &Structure,
    of: Carrier,
    tensions_n: &[f64],
) -> impl Iterator<Item = f64> {
    let cables = tensions_n.iter().zip(strengths_n(structure, of));
    cables.filter_map(|(tension_n, strength_n)| Some(tension_n / strength_n?))
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;
    use crate::lines::Cable;

    #[test]
    fn every_cable_is_judged_by_its_own_strength() {
        let mut structure = Structure::default();
        let nodes = [0.0, 1.0].map(|x| structure.add_node(DVec3::X * x));
        for (breaking_load_n, kind) in [
            (Some(100.0), CableKind::SuspensionLine),
            (Some(200.0), CableKind::Belt),
            (None, CableKind::Belt),
            (Some(50.0), CableKind::Belt),
            (Some(400.0), CableKind::Riser),
            (None, CableKind::VentLine),
        ] {
            let cable = Cable {
                breaking_load_n,
                ..Cable::linear(1e-6, 1000.0, 1e9)
            };
            structure.add_cable(&nodes, &[1.0], &cable, kind);
        }
        let tensions_n = [90.0, 100.0, 80.0, 20.0, 300.0, 10.0];
        let shares = |of| load_shares(&structure, of, &tensions_n).collect::<Vec<_>>();
        assert_eq!(shares(Carrier::Tapes), [0.5, 0.4]);
        assert_eq!(shares(Carrier::Lines), [0.9, 0.75]);
    }
}
