//! Loads of the air on a flown wing: pressure on its triangles, traction for the drag that pressures lack, drag of lines; and the glide that they make.

use glam::{DVec2, DVec3};
use serde::{Deserialize, Serialize};

use super::balance::{self, Balance, Sums, Weights, stream, turned};
use super::flown_sections::{Between, FlownStrip, is_within_turns, turn_rad};
use super::mouth::pressure_inside;
use super::outer::OuterPressure;
use super::skin::Skin;
use super::{Settings, TrimError};
use crate::aero::decambering::{AGREEMENT, Branch, Decambering, Section, ViscousFlow};
use crate::aero::drag::{self, DragArea, LineSegment};
use crate::aero::potential_flow::{MEMORY_LIMIT, PotentialFlow};
use crate::aero::surface::PanelSurface;
use crate::cloth::Structure;
use crate::geometry::wing::section::Side;
use crate::geometry::wing::{BuiltWing, LineKind, Part};

/// Places along an intake at which the pressure before it is taken.
const INTAKE_POINTS: usize = 40;

/// √(x/c) up to which the point where the stream divides is looked for on either side of the nose, and places there.
const NOSE_ROOT: f64 = 0.5;
const NOSE_POINTS: usize = 200;

/// Angle of the stream with which the first search begins [rad].
const START_RAD: f64 = 0.14;

/// Balances whose wake is laid along the stream that the one before found.
const WAKES: usize = 3;

/// A change of the stream that leaves the wake where it is [rad].
const WAKE_TOLERANCE_RAD: f64 = 2e-3;

/// A wing with what hangs on it.
#[derive(Debug)]
pub struct Glider<'a> {
    wing: &'a BuiltWing,
    structure: &'a Structure,
    settings: &'a Settings,
    /// Diameter of every cable in the stream [m]; zero where it is sewn on.
    diameters_m: &'a [f64],
    gravity_m_s2: f64,
    /// Which panels there are.
    pub skin: Skin,
    /// Profiles that every strip lies between.
    between: Vec<Between>,
    /// Share of every strip's area whose cells have an intake.
    open_shares: Vec<f64>,
    /// Fabric of the panels of each strip, both halves [m²].
    strip_fabric_m2: Vec<f64>,
    /// Between the points where the risers hang.
    hang_m: DVec3,
}

/// Loads on the structure, at the attitude that the balance wants.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct Loads {
    /// Pressure inside less that outside, on panels and tips along their normals [Pa], `[triangle_count]`.
    pub jumps_pa: Vec<f64>,
    /// Traction and drag of lines [N], `[node_count]`.
    pub nodal_n: Vec<DVec3>,
}

impl Loads {
    /// True if they are loads of this structure.
    #[must_use]
    pub fn fits(&self, structure: &Structure) -> bool {
        self.jumps_pa.len() == structure.triangles.len()
            && [0, structure.node_count()].contains(&self.nodal_n.len())
    }
}

/// A strip of the half wing in flight.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct StripState {
    /// Distance of its middle from the plane of symmetry [m].
    pub y_m: f64,
    /// Along the span, in half spans of cells.
    pub place: f64,
    /// Chord [m].
    pub chord_m: f64,
    /// Length along the span [m].
    pub width_m: f64,
    /// Circulation [m²/s].
    pub circulation_m2_s: f64,
    /// Lift coefficient on its chord.
    pub lift: f64,
    /// Angle of attack of its section [rad].
    pub effective_rad: f64,
    /// Drag coefficient of its section.
    pub drag: f64,
}

/// A glide and the loads that go with it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Flight {
    /// Speed, angles, turn.
    pub balance: Balance,
    /// Angle of the chord in the middle to the stream [rad].
    pub attack_rad: f64,
    /// Lift of the wing and its lines, across the stream [N].
    pub lift_n: f64,
    /// Lift of the wing by the far wake [N].
    pub far_lift_n: f64,
    /// Lift of the wing by pressures on fabric [N].
    pub pressure_lift_n: f64,
    /// Drag that the pressures on fabric have [N].
    pub pressure_drag_n: f64,
    /// Of the far wake [N].
    pub induced_drag_n: f64,
    /// Of the sections' polars [N].
    pub section_drag_n: f64,
    /// Of lines and risers, along the stream [N].
    pub line_drag_n: f64,
    /// Of the pilot [N].
    pub pilot_drag_n: f64,
    /// Weight of all [N].
    pub weight_n: f64,
    /// Coefficient of the pressure inside.
    pub inside: f64,
    /// Strips from the middle to the tip.
    pub strips: Vec<StripState>,
    /// Coefficients of pressure outside.
    pub outer: OuterPressure,
    /// Panels, the caps' included.
    pub panels: usize,
    /// Largest difference of a strip's lift coefficient from its polar's.
    pub section_residual: f64,
    /// Whether all sections are at angles, and have turns of their trailing edge, that their polars cover.
    pub is_covered: bool,
    /// What acts on the structure.
    pub loads: Loads,
}

/// Dynamic viscosity of air at 15 °C [Pa s].
const VISCOSITY_PA_S: f64 = 1.79e-5;

impl Flight {
    /// Reynolds number of the mean chord, in air of a density [kg/m³].
    #[must_use]
    pub fn reynolds_number(&self, density_kg_m3: f64) -> f64 {
        let areas = self
            .strips
            .iter()
            .map(|strip| strip.chord_m * strip.width_m);
        let spans = self.strips.iter().map(|strip| strip.width_m);
        let chord_m = areas.sum::<f64>() / spans.sum::<f64>();
        density_kg_m3 * self.balance.speed_m_s * chord_m / VISCOSITY_PA_S
    }
}

/// What the air does to a shape at one angle of the stream, over the dynamic pressure.
struct Sample {
    viscous: ViscousFlow,
    outer: OuterPressure,
    inside: f64,
    far_lift_m2: f64,
    induced_m2: f64,
    strip_drag_m2: Vec<f64>,
    pressure: Sums,
    lines_m2: DVec3,
    sums: Sums,
}

impl<'a> Glider<'a> {
    /// Prepares panels; `gravity_m_s2` pulls down.
    pub fn new(
        wing: &'a BuiltWing,
        structure: &'a Structure,
        diameters_m: &'a [f64],
        settings: &'a Settings,
        gravity_m_s2: f64,
    ) -> Result<Self, TrimError> {
        let skin = Skin::new(wing, settings.panels_per_side, settings.strips);
        let between = skin
            .strip_middles()
            .iter()
            .map(|&u| {
                let rib = (u + 0.5 * wing.cells as f64).round() as usize;
                wing.frames[rib.min(wing.cells)].profiles
            })
            .collect();
        let mut strip_fabric_m2 = vec![0.0; skin.sections.len() - 1];
        for (triangle, tag) in structure.triangles.iter().zip(&wing.tags) {
            if matches!(tag.part, Part::Upper | Part::Lower) {
                strip_fabric_m2[skin.strip_of(tag.number as usize)] += triangle.rest_area_m2;
            }
        }
        let [right, left] = wing.hang_points.map(|n| structure.positions_m[n as usize]);
        Ok(Self {
            wing,
            structure,
            settings,
            diameters_m,
            gravity_m_s2,
            open_shares: skin.open_shares(wing),
            skin,
            between,
            strip_fabric_m2,
            hang_m: 0.5 * (right + left),
        })
    }

    /// Positions turned about the hang points, nose up [m].
    #[must_use]
    pub fn turned_m(&self, positions_m: &[DVec3], angle_rad: f64) -> Vec<DVec3> {
        let turn = |p: &DVec3| self.hang_m + turned(*p - self.hang_m, angle_rad);
        positions_m.iter().map(turn).collect()
    }

    /// Nodes of the panels for positions of the mesh [m].
    #[must_use]
    pub fn panel_nodes_m(&self, positions_m: &[DVec3]) -> Vec<DVec3> {
        self.skin.nodes_m(self.wing, positions_m)
    }

    /// Pitch of the chord in the middle, nose up [rad].
    #[must_use]
    pub fn pitch_rad(&self, positions_m: &[DVec3]) -> f64 {
        let [nose, tail] = self.wing.middle_chord_m(positions_m);
        (nose.z - tail.z).atan2(tail.x - nose.x)
    }

    fn weights(&self, positions_m: &[DVec3]) -> Weights {
        let masses = &self.structure.masses_kg;
        let wing_kg: f64 = masses.iter().sum();
        let moment: DVec3 = masses
            .iter()
            .zip(positions_m)
            .map(|(m, p)| *m * (*p - self.hang_m))
            .sum();
        Weights {
            gravity_m_s2: self.gravity_m_s2,
            wing_kg,
            centre_m: moment / wing_kg.max(f64::MIN_POSITIVE),
            pilot_kg: self.settings.pilot_mass_kg,
            pilot_area_m2: self.settings.pilot_drag_area_m2,
            density_kg_m3: self.settings.density_kg_m3,
        }
    }

    /// The glide of a shape: `positions_m` of the mesh, `nodes_m` of the panels that the air sees, and the angle of the stream to begin with;
    /// `None`: the shape has not flown yet.
    pub fn glide(
        &self,
        positions_m: &[DVec3],
        nodes_m: &[DVec3],
        start_rad: Option<f64>,
    ) -> Result<Flight, TrimError> {
        let around = 2 * self.settings.panels_per_side;
        let surface = PanelSurface::new(nodes_m.to_vec(), around, true, true)?;
        let strips: Vec<FlownStrip> = (self.between.iter().zip(&self.open_shares).enumerate())
            .map(|(j, (&between, &open_share))| FlownStrip {
                between,
                turn_rad: turn_rad(&surface, j, &self.wing.profiles, between),
                open_share,
            })
            .collect();
        let found = self
            .settings
            .sections
            .of_strips(&self.wing.profiles, &strips)?;
        let sections: Vec<Section> = found
            .iter()
            .map(|(polar, flow)| Section { polar, flow: *flow })
            .collect();
        let weights = self.weights(positions_m);
        let mut start = start_rad.unwrap_or(START_RAD);
        let mut wakes_left = WAKES;
        loop {
            let flow = PotentialFlow::new(&surface, stream(start), MEMORY_LIMIT)?;
            let decambering = Decambering::new(&flow, sections.clone())?;
            let sample = |angle: f64| self.sample(positions_m, &surface, &decambering, angle);
            let balance = balance::find(start, &weights, |angle| Ok(sample(angle)?.sums))?;
            wakes_left -= 1;
            let moved = (balance.stream_rad - start).abs();
            if moved < WAKE_TOLERANCE_RAD || wakes_left == 0 {
                let sample = sample(balance.stream_rad)?;
                if sample.viscous.residual > AGREEMENT {
                    return Err(TrimError::SectionsDisagree {
                        angle_deg: balance.stream_rad.to_degrees(),
                        residual: sample.viscous.residual,
                    });
                }
                let mut flight = self.flight(positions_m, &surface, (balance, weights), sample);
                flight.is_covered &= strips.iter().all(|strip| is_within_turns(strip.turn_rad));
                return Ok(flight);
            }
            start = balance.stream_rad;
        }
    }

    fn sample(
        &self,
        positions_m: &[DVec3],
        surface: &PanelSurface,
        decambering: &Decambering,
        angle_rad: f64,
    ) -> Result<Sample, TrimError> {
        // A stream of 1 m/s of air of 1 kg/m³.
        const DYNAMIC_PA: f64 = 0.5;
        let along = stream(angle_rad);
        let viscous = decambering
            .solve(&[along], Branch::Attached, 1.0)?
            .remove(0);
        let coefficients = viscous.flow.pressure_coefficients(surface);
        let outer = OuterPressure::new(&self.skin, surface, &coefficients);
        let inside = self
            .settings
            .inside
            .unwrap_or_else(|| self.by_the_mouths(&outer));
        let far = viscous.flow.trefftz_forces(surface, 1.0);
        let induced_m2 = far.induced_drag_n / DYNAMIC_PA;
        let strip_drag_m2: Vec<f64> = decambering
            .sections()
            .iter()
            .zip(&viscous.effective_rad)
            .enumerate()
            .map(|(j, (section, &angle))| {
                2.0 * surface.chord_m(j) * surface.span_m(j).length() * section.polar.drag(angle)
            })
            .collect();
        let mut pressure = Sums {
            force_m2: DVec3::ZERO,
            moment_m3: 0.0,
        };
        self.each_jump(&outer, inside, |triangle, jump| {
            let triangle = &self.structure.triangles[triangle];
            let pull = triangle.doubled_area_vector(positions_m) * (0.5 * jump);
            add(
                &mut pressure,
                self.middle_m(triangle.nodes, positions_m),
                pull,
            );
        });
        let mut sums = pressure;
        let lacking_m2 = induced_m2 - pressure.force_m2.dot(along);
        self.each_traction(&strip_drag_m2, lacking_m2, |triangle, traction_m2| {
            let nodes = self.structure.triangles[triangle].nodes;
            add(
                &mut sums,
                self.middle_m(nodes, positions_m),
                along * traction_m2,
            );
        });
        let mut lines_m2 = DVec3::ZERO;
        for line in self.lines(positions_m) {
            let force = drag::forces(&[line], &[], along, 1.0, DVec3::ZERO).force_n / DYNAMIC_PA;
            lines_m2 += force;
            let middle = 0.5 * (line.ends_m[0] + line.ends_m[1]) - self.hang_m;
            add(&mut sums, middle, force);
        }
        Ok(Sample {
            far_lift_m2: far.lift_n / DYNAMIC_PA,
            viscous,
            outer,
            inside,
            induced_m2,
            strip_drag_m2,
            pressure,
            lines_m2,
            sums,
        })
    }

    fn flight(
        &self,
        positions_m: &[DVec3],
        surface: &PanelSurface,
        (balance, weights): (Balance, Weights),
        sample: Sample,
    ) -> Flight {
        let q = balance.dynamic_pa;
        let along = stream(balance.stream_rad);
        let up = DVec3::new(-along.z, 0.0, along.x);
        let speed = balance.speed_m_s;
        let lifts = sample.viscous.flow.section_lift_coefficients(surface);
        let half = 0.5 * self.wing.cells as f64;
        let strips = self
            .skin
            .strip_middles()
            .iter()
            .enumerate()
            .map(|(j, u)| {
                let chord_m = surface.chord_m(j);
                let width_m = surface.span_m(j).length();
                let noses = [j, j + 1].map(|j| surface.node_m(self.skin.per_side, j).y);
                StripState {
                    y_m: 0.5 * (noses[0] + noses[1]),
                    place: u / half,
                    chord_m,
                    width_m,
                    circulation_m2_s: speed * sample.viscous.flow.circulation_m2_s[j],
                    lift: lifts[j],
                    effective_rad: sample.viscous.effective_rad[j],
                    drag: sample.strip_drag_m2[j] / (2.0 * chord_m * width_m),
                }
            })
            .collect();
        let pilot = DragArea {
            position_m: self.hang_m,
            area_m2: self.settings.pilot_drag_area_m2,
        };
        let pilot_n = drag::forces(
            &[],
            &[pilot],
            along * speed,
            self.settings.density_kg_m3,
            self.hang_m,
        );
        Flight {
            attack_rad: balance.stream_rad + self.pitch_rad(positions_m),
            lift_n: q * sample.sums.force_m2.dot(up),
            far_lift_n: q * sample.far_lift_m2,
            pressure_lift_n: q * sample.pressure.force_m2.dot(up),
            pressure_drag_n: q * sample.pressure.force_m2.dot(along),
            induced_drag_n: q * sample.induced_m2,
            section_drag_n: q * sample.strip_drag_m2.iter().sum::<f64>(),
            line_drag_n: q * sample.lines_m2.dot(along),
            pilot_drag_n: pilot_n.force_n.dot(along),
            weight_n: weights.gravity_m_s2 * (weights.wing_kg + weights.pilot_kg),
            inside: sample.inside,
            strips,
            panels: surface.panels.len(),
            section_residual: sample.viscous.residual,
            is_covered: sample.viscous.is_covered,
            loads: self.loads(positions_m, &balance, &sample),
            outer: sample.outer,
            balance,
        }
    }

    /// Loads in the frame in which the shape is turned to its balance.
    fn loads(&self, positions_m: &[DVec3], balance: &Balance, sample: &Sample) -> Loads {
        let q = balance.dynamic_pa;
        let along = stream(balance.stream_rad);
        let count = self.structure.triangles.len();
        let mut loads = Loads {
            jumps_pa: vec![0.0; count],
            nodal_n: vec![DVec3::ZERO; self.structure.node_count()],
        };
        self.each_jump(&sample.outer, sample.inside, |triangle, jump| {
            loads.jumps_pa[triangle] = q * jump;
        });
        let world = turned(along, balance.turn_rad);
        let lacking_m2 = sample.induced_m2 - sample.pressure.force_m2.dot(along);
        self.each_traction(
            &sample.strip_drag_m2,
            lacking_m2,
            |triangle, traction_m2| {
                for node in self.structure.triangles[triangle].nodes {
                    loads.nodal_n[node as usize] += world * (q * traction_m2 / 3.0);
                }
            },
        );
        let segments = self.line_numbers().zip(self.lines(positions_m));
        for (cable, line) in segments {
            let force = drag::forces(&[line], &[], along, 1.0, DVec3::ZERO).force_n * (2.0 * q);
            for node in self.structure.cables[cable].nodes {
                loads.nodal_n[node as usize] += turned(force, balance.turn_rad) * 0.5;
            }
        }
        loads
    }

    /// Coefficient inside by what stands before the mouths of the cells, their mean; that of stagnation where there are none (cases must say what a
    /// closed wing has).
    fn by_the_mouths(&self, outer: &OuterPressure) -> f64 {
        let Some(intakes) = self.wing.intakes else {
            return 1.0;
        };
        let open = intakes.open_cells(self.wing.cells);
        // Evenly in √(x/c), which is that along the outline near the nose.
        let ends = [intakes.from, intakes.to].map(f64::sqrt);
        let [rearmost, foremost] = outer.within([-ends[1], -ends[0]]);
        let (mut sum, mut weight) = (0.0, 0.0);
        for cell in open {
            let pair = &self.wing.frames[cell..cell + 2];
            let area = self.wing.flat_cell_area_m2(cell);
            let mut before: Vec<[f64; 2]> = Vec::with_capacity(INTAKE_POINTS + 1);
            let mut last = None;
            let mut along = 0.0;
            for i in 0..=INTAKE_POINTS {
                let root = ends[0] + (ends[1] - ends[0]) * i as f64 / INTAKE_POINTS as f64;
                let place = root * root;
                let height = pair[0].height(&self.wing.profiles, Side::Lower, place);
                let point = DVec2::new(place, height);
                along += last.map_or(0.0, |last: DVec2| last.distance(point));
                last = Some(point);
                let s = (-root).clamp(rearmost, foremost);
                before.push([along, outer.at(self.skin.of_cell(cell), s)]);
            }
            let divides = self.dividing_root(outer, cell);
            let divides = match before.len() - 1 {
                // Ahead of the front lip, or on the upper side; behind the rear lip; in between.
                _ if divides <= ends[0] => f64::NEG_INFINITY,
                _ if divides >= ends[1] => f64::INFINITY,
                last => {
                    let share = (divides - ends[0]) / (ends[1] - ends[0]);
                    before[(share * last as f64).round() as usize][0]
                }
            };
            sum += area * pressure_inside(&before, divides);
            weight += area;
        }
        if weight > 0.0 { sum / weight } else { 1.0 }
    }

    /// √(x/c) of the point around the nose where the stream divides, below zero on the upper side.
    fn dividing_root(&self, outer: &OuterPressure, cell: usize) -> f64 {
        let roots =
            (0..=2 * NOSE_POINTS).map(|i| NOSE_ROOT * (i as f64 / NOSE_POINTS as f64 - 1.0));
        let before = |root: f64| outer.at(self.skin.of_cell(cell), -root);
        let highest = roots.max_by(|a, b| before(*a).total_cmp(&before(*b)));
        highest.unwrap_or(0.0)
    }

    /// Calls with every loaded triangle, and the difference of the coefficients inside and outside, which pushes along its normal.
    fn each_jump(&self, outer: &OuterPressure, inside: f64, mut each: impl FnMut(usize, f64)) {
        for (triangle, tag) in self.wing.tags.iter().enumerate() {
            let place = f64::from(tag.chord_place);
            let cell = tag.number as usize;
            match tag.part {
                Part::Upper => {
                    let outside = outer.at(self.skin.of_cell(cell), place.sqrt());
                    each(triangle, inside - outside);
                }
                Part::Lower => {
                    let outside = outer.at(self.skin.of_cell(cell), -place.sqrt());
                    each(triangle, inside - outside);
                }
                // Normals of ribs point to the right.
                Part::Rib if cell == 0 => each(triangle, outer.at_tip(place) - inside),
                Part::Rib if cell == self.wing.cells => {
                    each(triangle, inside - outer.at_tip(place));
                }
                Part::Rib | Part::MiniRib | Part::Diagonal => {}
            }
        }
    }

    /// Calls with every triangle of the panels and its share of drag over the dynamic pressure [m²]: what its strip has, and what pressures
    /// lack, both spread evenly.
    fn each_traction(
        &self,
        strip_drag_m2: &[f64],
        lacking_m2: f64,
        mut each: impl FnMut(usize, f64),
    ) {
        let whole: f64 = self.strip_fabric_m2.iter().sum();
        for (triangle, tag) in self.wing.tags.iter().enumerate() {
            if !matches!(tag.part, Part::Upper | Part::Lower) {
                continue;
            }
            let strip = self.skin.strip_of(tag.number as usize);
            let per_area = strip_drag_m2[strip] / self.strip_fabric_m2[strip] + lacking_m2 / whole;
            each(
                triangle,
                per_area * self.structure.triangles[triangle].rest_area_m2,
            );
        }
    }

    /// Numbers of the cables in the stream.
    fn line_numbers(&self) -> impl Iterator<Item = usize> + '_ {
        let kinds = self.wing.line_kinds.iter().enumerate();
        kinds
            .filter(|(_, kind)| !matches!(kind, LineKind::Tape(_)))
            .map(|(cable, _)| cable)
    }

    fn lines<'b>(&'b self, positions_m: &'b [DVec3]) -> impl Iterator<Item = LineSegment> + 'b {
        self.line_numbers().map(|cable| LineSegment {
            ends_m: self.structure.cables[cable]
                .nodes
                .map(|n| positions_m[n as usize]),
            diameter_m: self.diameters_m[cable],
            coefficient: self.settings.line_drag_coefficient,
        })
    }

    /// Middle of a triangle seen from the hang points [m].
    fn middle_m(&self, nodes: [u32; 3], positions_m: &[DVec3]) -> DVec3 {
        let sum: DVec3 = nodes.iter().map(|n| positions_m[*n as usize]).sum();
        sum / 3.0 - self.hang_m
    }
}

fn add(sums: &mut Sums, arm_m: DVec3, force_m2: DVec3) {
    sums.force_m2 += force_m2;
    sums.moment_m3 += arm_m.cross(force_m2).y;
}
