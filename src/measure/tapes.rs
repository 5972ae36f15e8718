//! Loads of tapes, belts and bands that are sewn on the fabric, over their breaking loads.

use crate::cloth::Structure;
use crate::frame::CableKind;

/// Breaking load of every cable segment that is a tape \[N\], `[cable_count]`; `None` for other cables, and where it is not told.
pub(super) fn tape_strengths_n(structure: &Structure) -> impl Iterator<Item = Option<f64>> {
    let cables = structure.cables.iter();
    cables.map(|cable| {
        let breaking = cable.breaking_load_n;
        breaking.filter(|_| cable.kind == CableKind::Belt)
    })
}

/// Load over breaking load of all tapes whose breaking load is told, by the tensions of all cable segments \[N\].
pub(crate) fn tape_load_shares(
    structure: &Structure,
    tensions_n: &[f64],
) -> impl Iterator<Item = f64> {
    let tapes = tensions_n.iter().zip(tape_strengths_n(structure));
    tapes.filter_map(|(tension_n, strength_n)| Some(tension_n / strength_n?))
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;
    use crate::lines::Cable;

    #[test]
    fn every_tape_is_judged_by_its_own_strength() {
        let mut structure = Structure::default();
        let nodes = [0.0, 1.0].map(|x| structure.add_node(DVec3::X * x));
        for (breaking_load_n, kind) in [
            (Some(1.0), CableKind::SuspensionLine),
            (Some(200.0), CableKind::Belt),
            (None, CableKind::Belt),
            (Some(50.0), CableKind::Belt),
        ] {
            let cable = Cable {
                breaking_load_n,
                ..Cable::linear(1e-6, 1000.0, 1e9)
            };
            structure.add_cable(&nodes, &[1.0], &cable, kind);
        }
        let shares = tape_load_shares(&structure, &[90.0, 100.0, 80.0, 20.0]);
        assert_eq!(shares.collect::<Vec<_>>(), [0.5, 0.4]);
    }
}
