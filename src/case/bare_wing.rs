//! Checks of `[aero.wing]`.

use std::path::Path;
use std::sync::Arc;

use glam::DVec3;

use super::file::{self, File};
use super::problem::Problem;
pub use super::section_polar::SectionPolar;
use super::section_polar::{PolarRow, computed, polar_of, rows_of_xfoil};
use super::usual;
use super::values::{count_within, positive, vector, within};
use crate::aero::surface::{Station, Wing};
use crate::geometry::mesh::{sections, surface};
use crate::geometry::profile::{Profile, ProfileError};

const KEY: &str = "aero.wing";

/// Most angles of one sweep.
const MOST_ANGLES: usize = 400;

/// Steepest stream for which wakes that leave a wing in a plane mean anything [°].
const STEEPEST_DEG: f64 = 60.0;

/// A wing by itself.
#[derive(Debug, Clone)]
pub struct BareWing {
    /// Its sections.
    pub wing: Wing,
    /// Number of the profile of every station.
    pub station_profiles: Vec<usize>,
    /// Profiles.
    pub profiles: Vec<BareProfile>,
    /// Speed of the air [m/s].
    pub speed_m_s: f64,
    /// Density of the air [kg/m³].
    pub density_kg_m3: f64,
    /// Kinematic viscosity of the air [m²/s].
    pub viscosity_m2_s: f64,
    /// Angles of attack, growing [°].
    pub angles_deg: Vec<f64>,
    /// Angle of sideslip [°].
    pub sideslip_deg: f64,
    /// Area of the coefficients [m²].
    pub reference_area_m2: f64,
    /// Length of the coefficients of moments [m].
    pub reference_chord_m: f64,
    /// Point that moments are about [m].
    pub moment_point_m: DVec3,
    /// Panels along each side of a section.
    pub panels_per_side: usize,
    /// Strips along the span, of the half of a symmetric wing.
    pub strips: usize,
    /// How much narrower strips become towards tips.
    pub tip_clustering: f64,
}

/// A profile of a wing by itself.
#[derive(Debug, Clone)]
pub struct BareProfile {
    /// Its name.
    pub name: String,
    /// Its outline.
    pub outline: Arc<Profile>,
    /// Its polar.
    pub polar: SectionPolar,
}

fn key(name: &str) -> String {
    format!("{KEY}.{name}")
}

/// Checks the table, if there is one; files are looked up relative to `folder`.
pub(super) fn check(file: &File, folder: &Path) -> Result<Option<BareWing>, Problem> {
    let Some(file::Aero { wing: written }) = &file.aero else {
        return Ok(None);
    };
    refuse_others(file)?;
    let Drawn {
        wing,
        station_profiles,
        profiles,
    } = match &written.mesh {
        Some(mesh) => cut(written, mesh, folder)?,
        None => drawn(written, folder)?,
    };
    let mean = MeanChord::of(&wing);
    let number = |name: &str, value: Option<f64>, usual: f64| {
        let value = usual::or(key(name), value, usual);
        positive(&key(name), value)
    };
    let whole = |name: &str, value: Option<usize>, usual: usize, low: usize, high: usize| {
        count_within(&key(name), usual::or(key(name), value, usual), low, high)
    };
    let moment_point_m = usual::or(
        key("moment_point_m"),
        written.moment_point_m,
        mean.quarter_m.to_array(),
    );
    let clustering = usual::or(key("tip_clustering"), written.tip_clustering, 0.8);
    let sideslip = usual::or(key("sideslip_deg"), written.sideslip_deg, 0.0);
    Ok(Some(BareWing {
        speed_m_s: positive(&key("speed_m_s"), written.speed_m_s)?,
        density_kg_m3: number("air_density_kg_m3", written.air_density_kg_m3, 1.225)?,
        viscosity_m2_s: number(
            "kinematic_viscosity_m2_s",
            written.kinematic_viscosity_m2_s,
            1.46e-5,
        )?,
        angles_deg: angles(written)?,
        sideslip_deg: within(&key("sideslip_deg"), sideslip, -30.0, 30.0)?,
        reference_area_m2: number(
            "reference_area_m2",
            written.reference_area_m2,
            wing.flat_area_m2(),
        )?,
        reference_chord_m: number("reference_chord_m", written.reference_chord_m, mean.chord_m)?,
        moment_point_m: vector(&key("moment_point_m"), moment_point_m)?,
        panels_per_side: whole("panels_per_side", written.panels_per_side, 20, 4, 200)?,
        strips: whole("strips", written.strips, 24, 2, 400)?,
        tip_clustering: within(&key("tip_clustering"), clustering, 0.0, 1.0)?,
        wing,
        station_profiles,
        profiles,
    }))
}

/// A wing with the profiles of its stations.
struct Drawn {
    wing: Wing,
    station_profiles: Vec<usize>,
    profiles: Vec<BareProfile>,
}

/// The wing by its stations.
fn drawn(written: &file::BareWing, folder: &Path) -> Result<Drawn, Problem> {
    if written.stations.is_empty() {
        return Err(Problem::new(
            key("stations"),
            format!("{KEY}.stations is empty"),
            "give at least two stations along the span, with chords of more than 0 except at tips",
        ));
    }
    let profiles = written
        .profiles
        .iter()
        .map(|(name, profile)| check_profile(name, profile, folder))
        .collect::<Result<Vec<_>, _>>()?;
    let station_profiles = written
        .stations
        .iter()
        .map(|station| {
            let names = written.profiles.keys();
            let mut numbered = names.enumerate();
            let found = numbered.find(|(_, name)| **name == station.profile);
            found.map(|(number, _)| number).ok_or_else(|| {
                Problem::new(
                    key("stations"),
                    format!(
                        "a station names the profile `{}`, which is not there",
                        station.profile
                    ),
                    format!(
                        "name one of [aero.wing.profiles]: {}",
                        written
                            .profiles
                            .keys()
                            .cloned()
                            .collect::<Vec<_>>()
                            .join(", ")
                    ),
                )
            })
        })
        .collect::<Result<Vec<_>, _>>()?;
    let unused = (0..profiles.len()).find(|number| !station_profiles.contains(number));
    if let Some(number) = unused {
        return Err(Problem::new(
            key(&format!("profiles.{}", profiles[number].name)),
            format!("no station has the profile `{}`", profiles[number].name),
            "remove it, or name it in a station",
        ));
    }
    let chord_fraction = usual::or(key("chord_fraction"), written.chord_fraction, 0.25);
    let mut wing = Wing {
        stations: stations(written, &station_profiles, &profiles)?,
        chord_fraction: within(&key("chord_fraction"), chord_fraction, 0.0, 1.0)?,
        is_symmetric: usual::or(key("symmetric"), written.symmetric, true),
    };
    check_wing(&wing)?;
    wing.roll_along_span();
    for (station, written) in wing.stations.iter_mut().zip(&written.stations) {
        if let Some(roll) = written.roll_deg {
            station.roll_rad = within(&key("stations"), roll, -180.0, 180.0)?.to_radians();
        }
    }
    if wing.is_symmetric && wing.stations[0].roll_rad != 0.0 {
        return Err(Problem::new(
            key("stations"),
            format!(
                "{KEY}: the first station of a symmetric wing stands in the plane of symmetry: its roll_deg is 0"
            ),
            "remove roll_deg there, or give the whole wing with symmetric = false",
        ));
    }
    Ok(Drawn {
        wing,
        station_profiles,
        profiles,
    })
}

fn check_wing(wing: &Wing) -> Result<(), Problem> {
    let y = |station: Option<&Station>| station.map_or(0.0, |s| s.position_m.y);
    let (first, last) = (y(wing.stations.first()), y(wing.stations.last()));
    if wing.stations.len() > 1 && last < first {
        return Err(Problem::new(
            key("stations"),
            format!("{KEY}: the stations run from y = {first} to y = {last} m, to the left"),
            "give the right half, y > 0, from the middle outwards; or, with symmetric = false, the whole wing from the left tip to the right one",
        ));
    }
    wing.check().map_err(|why| {
        Problem::new(
            key("stations"),
            format!("{KEY}: {why}"),
            "give at least two stations along the span, with chords of more than 0 except at tips",
        )
    })
}

/// The wing by sections of a surface.
fn cut(written: &file::BareWing, mesh: &file::BareMesh, folder: &Path) -> Result<Drawn, Problem> {
    let own = |name: &str| key(&format!("mesh.{name}"));
    let beside = [
        ("stations", !written.stations.is_empty()),
        ("profiles", !written.profiles.is_empty()),
        ("symmetric", written.symmetric == Some(false)),
        ("chord_fraction", written.chord_fraction.is_some()),
    ];
    if let Some((name, _)) = beside.iter().find(|(_, present)| *present) {
        return Err(Problem::new(
            key(name),
            format!("{} says what {KEY}.mesh says, too", key(name)),
            "give the wing by stations, or by a mesh, whose right half is cut into sections",
        ));
    }
    let count = count_within(&own("sections"), mesh.sections, 3, 60)?;
    let path = folder.join(&mesh.file);
    let scale = positive(&own("scale"), mesh.scale)?;
    let refused = |why: String| {
        Problem::new(
            own("file"),
            format!(
                "cannot cut the wing {} into sections: {why}",
                path.display()
            ),
            "give an OBJ, STL or PLY file of a wing's surface, relative to the case file: x downstream, y along the span, z up",
        )
    };
    let surface = surface::read(&path, scale).map_err(refused)?;
    let found = sections::sections(&surface, count).map_err(refused)?;
    let polar = computed(&key("mesh"), mesh.critical_amplification, mesh.transition)?;
    let mut wing = Wing {
        stations: Vec::new(),
        chord_fraction: 0.25,
        is_symmetric: true,
    };
    let mut profiles = Vec::new();
    for (number, section) in found.into_iter().enumerate() {
        let outline = Arc::new(section.profile);
        let mut position_m = section.quarter_m;
        if number == 0 {
            position_m.y = 0.0;
        }
        wing.stations.push(Station {
            position_m,
            chord_m: section.chord_m,
            twist_rad: section.twist_rad,
            roll_rad: section.roll_rad,
            profile: Arc::clone(&outline),
        });
        profiles.push(BareProfile {
            name: format!("section_{number}"),
            outline,
            polar: polar.clone(),
        });
    }
    check_wing(&wing)?;
    Ok(Drawn {
        wing,
        station_profiles: (0..profiles.len()).collect(),
        profiles,
    })
}

/// A wing by itself leaves nothing to simulate.
fn refuse_others(file: &File) -> Result<(), Problem> {
    let others = [
        ("air", file.air.is_some()),
        ("structure", file.structure.is_some()),
        ("bodies", !file.bodies.is_empty()),
        ("time", file.time.is_some()),
        ("equilibrium", file.equilibrium.is_some()),
        ("payload", file.payload.is_some()),
        ("coupling", file.coupling.is_some()),
        ("output", file.output.is_some()),
        ("comparison", !file.comparison.is_empty()),
    ];
    match others.iter().find(|(_, present)| *present) {
        None => Ok(()),
        Some((table, _)) => Err(Problem::new(
            *table,
            format!(
                "[aero] is a wing by itself, for `ripstop polar`: nothing would read [{table}]"
            ),
            "remove it, or [aero]; a wing of fabric is [structure.wing]",
        )),
    }
}

fn stations(
    written: &file::BareWing,
    numbers: &[usize],
    profiles: &[BareProfile],
) -> Result<Vec<Station>, Problem> {
    written
        .stations
        .iter()
        .zip(numbers)
        .enumerate()
        .map(|(place, (station, number))| {
            // Named for the reader, and marked where all stations stand.
            let within = |name: &str, value: f64, low: f64, high: f64| {
                let named = format!("{KEY}, station {}: {name}", place + 1);
                within(&named, value, low, high).map_err(|problem| Problem {
                    key: key("stations"),
                    ..problem
                })
            };
            let twist = usual::or(key("stations.twist_deg"), station.twist_deg, 0.0);
            Ok(Station {
                position_m: vector(&key("stations"), station.position_m)?,
                chord_m: within("chord_m", station.chord_m, 0.0, 1e4)?,
                twist_rad: within("twist_deg", twist, -90.0, 90.0)?.to_radians(),
                roll_rad: 0.0,
                profile: Arc::clone(&profiles[*number].outline),
            })
        })
        .collect()
}

fn angles(written: &file::BareWing) -> Result<Vec<f64>, Problem> {
    let key = key("angles_deg");
    let [from, to, step] = usual::or(&key, written.angles_deg, [-6.0, 20.0, 1.0]);
    let count = ((to - from) / step + 1e-9).floor() + 1.0;
    let steep = from.abs().max(to.abs());
    if step > 0.0 && to >= from && count <= MOST_ANGLES as f64 && steep <= STEEPEST_DEG {
        return Ok((0..count as usize)
            .map(|k| from + step * k as f64)
            .collect());
    }
    Err(Problem::new(
        &key,
        format!("{key} = [{from}, {to}, {step}] is no sweep"),
        format!(
            "give from, to and a step greater than 0, between -{STEEPEST_DEG} and {STEEPEST_DEG} degrees and at most {MOST_ANGLES} angles, e.g. [-6.0, 20.0, 1.0]"
        ),
    ))
}

/// The outline of a profile by the digits of NACA or a file.
pub(super) fn check_outline(
    key: &str,
    written: (&Option<String>, &Option<String>),
    folder: &Path,
) -> Result<Profile, Problem> {
    match written {
        (Some(digits), None) => Profile::naca(digits).map_err(|why| {
            Problem::new(key, why.to_string(), "e.g. naca = \"23015\"")
        }),
        (None, Some(file)) => Profile::read(&folder.join(file)).map_err(|why: ProfileError| {
            Problem::new(
                format!("{key}.file"),
                format!("cannot read the profile {}: {why}", folder.join(file).display()),
                "give a file in Selig's format, relative to the case file: a title, then x/c and y/c per line from the upper trailing edge around the nose to the lower one",
            )
        }),
        (Some(_), Some(_)) => Err(Problem::new(
            key,
            "a profile has `naca` and `file`: it needs exactly one of them",
            "remove one; where `naca` follows from a design, write naca = \"absent\" beside `file`",
        )),
        (None, None) => Err(Problem::new(
            key,
            "a profile needs `naca` or `file`",
            "give naca = \"23015\", or file = \"profile.dat\" with coordinates in Selig's format",
        )),
    }
}

fn check_profile(
    name: &str,
    written: &file::BareProfile,
    folder: &Path,
) -> Result<BareProfile, Problem> {
    let key = key(&format!("profiles.{name}"));
    let outline = check_outline(&key, (&written.naca, &written.file), folder)?;
    let is_given = written.polar.is_some() || written.polar_file.is_some();
    if is_given && (written.critical_amplification.is_some() || written.transition.is_some()) {
        return Err(Problem::new(
            &key,
            "critical_amplification and transition are of a polar that is computed; this one is given",
            "remove them, or the polar",
        ));
    }
    let polar = match (&written.polar, &written.polar_file) {
        (None, None) => computed(&key, written.critical_amplification, written.transition)?,
        (Some(rows), None) => {
            let rows: Vec<PolarRow> = rows.iter().map(|&row| (row, None)).collect();
            SectionPolar::Given(polar_of(&format!("{key}.polar"), &rows)?)
        }
        (None, Some(file)) => {
            let key = format!("{key}.polar_file");
            let path = folder.join(file);
            let text = std::fs::read_to_string(&path).map_err(|why| {
                Problem::new(
                    &key,
                    format!("cannot read the polar {}: {why}", path.display()),
                    "give a file relative to the case file",
                )
            })?;
            SectionPolar::Given(polar_of(&key, &rows_of_xfoil(&text))?)
        }
        (Some(_), Some(_)) => {
            return Err(Problem::new(
                &key,
                "a profile needs at most one of `polar` and `polar_file`",
                "remove one; without both the polar is computed",
            ));
        }
    };
    Ok(BareProfile {
        name: name.to_owned(),
        outline: Arc::new(outline),
        polar,
    })
}

/// Mean aerodynamic chord: ∫ c² ds/∫ c ds, and where its quarter lies.
pub(super) struct MeanChord {
    pub(super) chord_m: f64,
    quarter_m: DVec3,
}

impl MeanChord {
    pub(super) fn of(wing: &Wing) -> Self {
        // Pieces are short against what is linear between stations.
        const PIECES: usize = 64;
        let (mut area, mut square, mut quarter) = (0.0, 0.0, DVec3::ZERO);
        for pair in wing.stations.windows(2) {
            let step = pair[1].position_m - pair[0].position_m;
            let length = step.y.hypot(step.z) / PIECES as f64;
            for piece in 0..PIECES {
                let t = (piece as f64 + 0.5) / PIECES as f64;
                let chord = pair[0].chord_m + t * (pair[1].chord_m - pair[0].chord_m);
                let back = DVec3::X * ((0.25 - wing.chord_fraction) * chord);
                let at = pair[0].position_m.lerp(pair[1].position_m, t) + back;
                area += chord * length;
                square += chord * chord * length;
                quarter += chord * length * at;
            }
        }
        let mut quarter_m = quarter / area;
        if wing.is_symmetric {
            quarter_m.y = 0.0;
        }
        Self {
            chord_m: square / area,
            quarter_m,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Of a straight taper with the ratio λ the mean chord is 2/3 c (1 + λ + λ²)/(1 + λ).
    #[test]
    fn the_mean_chord_is_that_of_a_taper() {
        let station = |y: f64, chord_m: f64| Station {
            position_m: DVec3::new(0.25 * chord_m, y, 0.0),
            chord_m,
            twist_rad: 0.0,
            roll_rad: 0.0,
            profile: Arc::new(Profile::naca("0012").unwrap()),
        };
        let mean = MeanChord::of(&Wing {
            stations: vec![station(0.0, 2.0), station(3.0, 1.0)],
            chord_fraction: 0.25,
            is_symmetric: true,
        });
        assert!((mean.chord_m - 4.0 / 3.0 * 1.75 / 1.5).abs() < 1e-4);
        assert!((mean.quarter_m.x - 0.25 * mean.chord_m).abs() < 1e-4);
    }
}
