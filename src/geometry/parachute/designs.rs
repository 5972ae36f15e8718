//! Constructed canopies as patterns of gores.
//!
//! Canopies are polygons, as gores with straight edges make them, of the nominal area S₀: that of the whole canopy with its vent, slots
//! and gap, but for the annular one without its opening. A vent's diameter is that of the circle of the same area; D₀ = √(4 S₀/π).

use std::f64::consts::PI;

use super::pattern::{Pattern, Section, Slots, Station};

/// A canopy.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Design {
    /// Nominal area S₀ [m²].
    pub nominal_area_m2: f64,
    /// Number of gores; a cruciform canopy has none, and folds as if it had four.
    pub gores: usize,
    /// Rings of triangles from vent or apex to skirt.
    pub rings: usize,
    /// Diameter of the vent, if any; of an annular canopy's opening [m].
    pub vent_diameter_m: Option<f64>,
    /// What it is.
    pub shape: Shape,
}

/// Kinds of canopies.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Shape {
    /// Cone that rises `cone_angle_rad` from the skirt's plane; flat with zero. With slots, if any, from and to distances from the
    /// apex along the gores' centre lines.
    Conical {
        /// Angle of the gores' centre lines with the plane of the skirt [rad].
        cone_angle_rad: f64,
        /// Radial slots along seams.
        slots: Option<RadialSlots>,
    },
    /// Flat canopy and a ring sewn to its edge.
    ExtendedSkirt {
        /// Width of that ring over the diameter of the flat part.
        extension_ratio: f64,
        /// Width of a gore at the skirt over that at the edge of the flat part.
        skirt_width_ratio: f64,
    },
    /// Flat ring.
    Annular,
    /// Flat disk, gap, cylindrical band.
    DiskGapBand {
        /// Diameter of the circle of the disk's area [m].
        disk_diameter_m: f64,
        /// Width of the gap [m].
        gap_width_m: f64,
        /// Width of the band [m].
        band_width_m: f64,
    },
    /// Flat rings, with slots between them that run around the canopy.
    Ringslot {
        /// Number of slots; there is one ring more.
        slots: usize,
        /// Width of a slot, along the gores' centre lines [m].
        slot_width_m: f64,
        /// Tapes across every slot between two seams.
        tapes_per_gore: usize,
    },
    /// Two crossed rectangles, sewn on each other where they cross (one layer of fabric there).
    Cruciform {
        /// Length of either rectangle [m].
        length_m: f64,
        /// Width [m].
        width_m: f64,
        /// Lines along each of the four ends.
        lines_per_end: usize,
    },
}

/// Slots along seams, evenly around the canopy.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RadialSlots {
    /// Number.
    pub count: usize,
    /// Width \[m\]; zero for a cut.
    pub width_m: f64,
    /// Where they begin, from the apex [m].
    pub from_m: f64,
    /// Where they end [m].
    pub to_m: f64,
}

/// Disk, gap and band of a disk-gap-band canopy over D₀, where the case does not give them: those of the Viking type, as in table 3 of
/// "Analysis and Verification of Aerodynamic Characteristics of Tianwen-1 Mars Parachute" (2022; D₀ 15.96 m, disk 11.53 m, gap 0.69 m).
/// Their band, 1.94 m, agrees within 0.7 % with what the nominal area leaves, which is taken.
pub const VIKING_DISK: f64 = 0.7224;

/// Gap over D₀, from the same source.
pub const VIKING_GAP: f64 = 0.0432;

/// Rings that a slot takes at least: one to open, one to close.
const SLOT_RINGS: usize = 2;

/// Why a design cannot be built.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum DesignFault {
    /// The vent does not leave fabric.
    #[error(
        "the vent (or opening) reaches the edge of the fabric, at {0:.4} m from the apex along a gore"
    )]
    Vent(f64),
    /// Slots lie outside the fabric.
    #[error("slots must lie on the fabric, from {0:.4} m to {1:.4} m from the apex along a gore")]
    Slots(f64, f64),
    /// Slots as wide as the gores.
    #[error("slots take more than half the width of the gores, which is {0:.4} m where they begin")]
    SlotWidth(f64),
    /// Slots around the canopy wider than the rings between them.
    #[error("slots leave rings of {0:.4} m, narrower than the slots")]
    RingWidth(f64),
}

impl Design {
    /// Nominal diameter D₀ [m].
    #[must_use]
    pub fn nominal_diameter_m(&self) -> f64 {
        (4.0 * self.nominal_area_m2 / PI).sqrt()
    }

    /// Distance along a centre line at which a flat polygon has the area of a circle of this diameter, for half widths b = slope · s [m].
    fn reach_m(&self, diameter_m: f64, slope: f64) -> f64 {
        (0.25 * PI * diameter_m * diameter_m / (self.gores as f64 * slope)).sqrt()
    }

    /// The pattern.
    pub fn pattern(&self) -> Result<Pattern, DesignFault> {
        let flat = (PI / self.gores as f64).tan();
        let count = self.gores as f64;
        let slope = match self.shape {
            Shape::Conical { cone_angle_rad, .. } => flat * cone_angle_rad.cos(),
            _ => flat,
        };
        let on = |distance_m: f64| Station {
            distance_m,
            half_width_m: slope * distance_m,
        };
        // Conical canopies have the vent of a flat circle in their horizontal projection.
        let vent = self
            .vent_diameter_m
            .map_or(0.0, |d| self.reach_m(d, flat) * flat / slope);
        let full = |area: f64| (area / (count * slope)).sqrt();
        let mut skirt_multiple = 1;
        let pieces: Vec<Piece> = match self.shape {
            Shape::Conical { slots, .. } => {
                let end = full(self.nominal_area_m2);
                match slots {
                    None => vec![Piece::sewn(on(vent), on(end))],
                    Some(slots) => self.slotted(&slots, vent, end, slope)?,
                }
            }
            Shape::Annular => {
                let end = full(self.nominal_area_m2 + count * slope * vent * vent);
                vec![Piece::sewn(on(vent), on(end))]
            }
            Shape::ExtendedSkirt {
                extension_ratio,
                skirt_width_ratio,
            } => {
                let share = 1.0 + 2.0 * extension_ratio * (1.0 + skirt_width_ratio);
                let edge = full(self.nominal_area_m2 / share);
                let skirt = Station {
                    distance_m: edge * (1.0 + 2.0 * extension_ratio),
                    half_width_m: slope * edge * skirt_width_ratio,
                };
                vec![
                    Piece::sewn(on(vent), on(edge)),
                    Piece::sewn(on(edge), skirt),
                ]
            }
            Shape::DiskGapBand {
                disk_diameter_m,
                gap_width_m,
                band_width_m,
            } => {
                let edge = self.reach_m(disk_diameter_m, slope);
                let below = |distance_m: f64| Station {
                    distance_m: edge + distance_m,
                    half_width_m: slope * edge,
                };
                let mut band = Piece::sewn(below(gap_width_m), below(gap_width_m + band_width_m));
                band.section.sewn = false;
                vec![Piece::sewn(on(vent), on(edge)), band]
            }
            Shape::Ringslot {
                slots,
                slot_width_m,
                ..
            } => {
                let end = full(self.nominal_area_m2);
                let ring = (end - vent - slots as f64 * slot_width_m) / (slots + 1) as f64;
                if ring < slot_width_m {
                    return Err(DesignFault::RingWidth(ring));
                }
                let of_ring = |number: usize| {
                    let from = vent + number as f64 * (ring + slot_width_m);
                    let mut piece = Piece::sewn(on(from), on(from + ring));
                    piece.section.sewn = number == 0;
                    piece
                };
                (0..=slots).map(of_ring).collect()
            }
            Shape::Cruciform {
                length_m,
                width_m,
                lines_per_end,
            } => {
                let half = 0.5 * width_m;
                let end = Station {
                    distance_m: 0.5 * length_m,
                    half_width_m: half,
                };
                let mut arm = Piece::sewn(on(half), end);
                arm.section.slots = Some(Slots {
                    every: 1,
                    width_m: 0.0,
                    open_at_skirt: true,
                });
                // Every line at a node: 2 m segments over lines − 1 spaces.
                let spaces = lines_per_end.saturating_sub(1).max(1);
                skirt_multiple = if spaces.is_multiple_of(2) {
                    spaces / 2
                } else {
                    spaces
                };
                let mut middle = Piece::sewn(on(vent), on(half));
                middle.section.has_seams = false;
                vec![middle, arm]
            }
        };
        let edge = pieces[0].section.to.distance_m;
        if vent >= 0.95 * edge {
            return Err(DesignFault::Vent(edge));
        }
        Ok(Pattern {
            gores: self.gores,
            sections: shared_out(pieces, self.rings),
            skirt_multiple,
            tapes_per_gore: match self.shape {
                Shape::Ringslot { tapes_per_gore, .. } => tapes_per_gore,
                _ => 0,
            },
        })
    }

    fn slotted(
        &self,
        slots: &RadialSlots,
        vent: f64,
        end: f64,
        slope: f64,
    ) -> Result<Vec<Piece>, DesignFault> {
        if !(slots.from_m > vent && slots.from_m < slots.to_m && slots.to_m < end) {
            return Err(DesignFault::Slots(vent, end));
        }
        if slots.width_m > slope * slots.from_m {
            return Err(DesignFault::SlotWidth(2.0 * slope * slots.from_m));
        }
        let on = |distance_m: f64| Station {
            distance_m,
            half_width_m: slope * distance_m,
        };
        let mut slotted = Piece::sewn(on(slots.from_m), on(slots.to_m));
        slotted.least_rings = SLOT_RINGS;
        slotted.section.slots = Some(Slots {
            every: self.gores / slots.count,
            width_m: slots.width_m,
            open_at_skirt: false,
        });
        Ok(vec![
            Piece::sewn(on(vent), on(slots.from_m)),
            slotted,
            Piece::sewn(on(slots.to_m), on(end)),
        ])
    }
}

/// A section before its rings are known.
#[derive(Debug)]
struct Piece {
    section: Section,
    least_rings: usize,
}

impl Piece {
    const fn sewn(from: Station, to: Station) -> Self {
        Self {
            section: Section {
                from,
                to,
                rings: 0,
                sewn: true,
                slots: None,
                has_seams: true,
            },
            least_rings: 1,
        }
    }
}

/// Sections with `rings` shared out by their lengths, narrow parts of gores counted as longer.
fn shared_out(pieces: Vec<Piece>, rings: usize) -> Vec<Section> {
    let plain = |piece: &Piece| piece.section.to.distance_m - piece.section.from.distance_m;
    let height_m = pieces.iter().map(plain).sum::<f64>() / rings as f64;
    let length = |piece: &Piece| piece.section.weighted_length_m(height_m);
    let total: f64 = pieces.iter().map(length).sum();
    pieces
        .into_iter()
        .map(|piece| Section {
            rings: ((rings as f64 * length(&piece) / total).round() as usize)
                .max(piece.least_rings),
            ..piece.section
        })
        .collect()
}
