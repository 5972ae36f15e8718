//! The polar of a wing by itself: `[aero.wing]`.

use super::exit;
use super::failure::Failure;
use super::log::emit;
use super::polar_arguments::PolarArguments;
use super::threads;
use crate::case::Case;
use crate::case::bare_wing::{BareWing, SectionPolar};
use crate::output::{
    Chart, OutputError, Provenance, ReadOut, Series, aligned, prepare_directory, significant,
    write_table,
};
use crate::polar::{self, Coefficients, Numbers, Point, Polar, matrix_bytes};
use crate::report::{self, PageTable, PolarPage};

/// The file of a row for each angle.
const POLAR_TABLE: &str = "polar.csv";

/// Columns of [`POLAR_TABLE`].
pub(super) const COLUMNS: [ReadOut; 18] = [
    ReadOut::new("angle_of_attack_deg", "deg", "angle of attack"),
    ReadOut::new(
        "lift_coefficient",
        "1",
        "lift coefficient; over q and the reference area",
    ),
    ReadOut::new(
        "drag_coefficient",
        "1",
        "drag coefficient; induced and of the sections",
    ),
    ReadOut::new("induced_drag_coefficient", "1", "induced drag coefficient"),
    ReadOut::new(
        "profile_drag_coefficient",
        "1",
        "drag coefficient of the sections",
    ),
    ReadOut::new(
        "pitching_moment_coefficient",
        "1",
        "coefficient of the moment about the moment point, nose up; over the reference chord",
    ),
    ReadOut::new(
        "side_force_coefficient",
        "1",
        "coefficient of the side force, to the right",
    ),
    ReadOut::new(
        "rolling_moment_coefficient",
        "1",
        "coefficient of the rolling moment, left tip up; over the reference chord",
    ),
    ReadOut::new(
        "yawing_moment_coefficient",
        "1",
        "coefficient of the yawing moment, nose to the right; over the reference chord",
    ),
    ReadOut::new("lift_to_drag_ratio", "1", "lift over drag"),
    ReadOut::new("lift_n", "N", "lift"),
    ReadOut::new("drag_n", "N", "drag"),
    ReadOut::new(
        "stalled_area_share",
        "1",
        "share of the area whose sections are beyond their highest lift",
    ),
    ReadOut::new(
        "sections_covered",
        "1",
        "1 where all sections are at angles that their polars reach, else 0",
    ),
    ReadOut::new(
        "separated_lift_coefficient",
        "1",
        "lift coefficient of a second, separated solution; none where there is none",
    ),
    ReadOut::new("separated_drag_coefficient", "1", "its drag coefficient"),
    ReadOut::new(
        "separated_pitching_moment_coefficient",
        "1",
        "its coefficient of the moment",
    ),
    ReadOut::new(
        "section_residual",
        "1",
        "largest difference of lift between sections and wing",
    ),
];

/// Columns of `span.csv`.
const SPAN_COLUMNS: [&str; 11] = [
    "angle_of_attack_deg",
    "x_m",
    "y_m",
    "z_m",
    "chord_m",
    "width_m",
    "reynolds_number",
    "lift_coefficient",
    "drag_coefficient",
    "effective_angle_deg",
    "stalled",
];

/// Speed of sound of air at 15 °C [m/s], and the Mach number up to which air counts as of one density.
const SPEED_OF_SOUND_M_S: f64 = 340.3;
const LARGEST_MACH: f64 = 0.3;

/// Span of the largest aircraft, rounded up [m].
const LARGEST_SPAN_M: f64 = 120.0;

/// Angles whose span-wise loads are drawn, at most.
const DRAWN_SPANS: usize = 5;

pub(super) fn polar(arguments: &PolarArguments, case: &Case) -> Result<u8, Failure> {
    let Some(wing) = &case.scene.bare_wing else {
        return Ok(0);
    };
    if !arguments.overwrite && arguments.out.join(POLAR_TABLE).exists() {
        return Err(Failure::Other(
            exit::OCCUPIED,
            format!(
                "{} holds a polar; --overwrite replaces it, --out DIR takes another folder",
                arguments.out.display()
            ),
        ));
    }
    threads::start(arguments.case.thread_count())?;
    prepare_directory(&arguments.out).map_err(|error| failed(&error))?;
    let began = std::time::Instant::now();
    let found = polar::solve(wing)
        .map_err(|why| Failure::Other(exit::BAD_CASE, format!("{}: {why}", case.name)))?;
    let numbers = polar::numbers(&found);
    write(arguments, case, wing, &found, &numbers).map_err(|error| failed(&error))?;
    let mut text = format!("{}\n{}\n\n", case.scene.title, line(wing, &found));
    text += &aligned(&table(&found));
    text.push('\n');
    let rows: Vec<Vec<String>> = told(wing, &numbers).into_iter().map(Vec::from).collect();
    text += &aligned(&rows);
    for note in notes(wing, &found) {
        text += &format!("note: {note}\n");
    }
    text += &format!(
        "{:.1} s; tables, charts and page: {}\n",
        began.elapsed().as_secs_f64(),
        arguments.out.display()
    );
    emit(&text)?;
    let missed = found
        .points
        .iter()
        .filter(|point| point.coefficients.is_none());
    Ok(if missed.count() == found.points.len() {
        exit::DIVERGED
    } else {
        0
    })
}

fn failed(error: &OutputError) -> Failure {
    Failure::Other(exit::OUTPUT_FAILED, error.to_string())
}

/// What `ripstop check` prints of a wing by itself.
pub(super) fn outlook(case: &Case, wing: &BareWing) -> String {
    let [panels, strips] = polar::panels_and_strips(wing);
    let chords = wing.wing.stations.iter().map(|s| s.chord_m);
    let longest = chords.fold(0.0, f64::max);
    let mut rows = vec![
        [
            "wing".to_owned(),
            format!(
                "{} stations, area {} m2, projected span {} m, mean chord {} m",
                wing.wing.stations.len(),
                significant(wing.reference_area_m2, 4),
                significant(wing.wing.projected_span_m(), 4),
                significant(wing.reference_chord_m, 4)
            ),
        ],
        [
            "moments".to_owned(),
            format!("about {:.4?} m", wing.moment_point_m.to_array()),
        ],
        [
            "air".to_owned(),
            format!(
                "{} m/s, {} kg/m3; Reynolds number {} on the longest chord",
                wing.speed_m_s,
                wing.density_kg_m3,
                significant(wing.speed_m_s * longest / wing.viscosity_m2_s, 3)
            ),
        ],
        [
            "panels".to_owned(),
            format!(
                "{} per side, {} strips: {panels} unknowns, {:.0} MB",
                wing.panels_per_side,
                strips,
                matrix_bytes(panels, strips) as f64 / 1e6
            ),
        ],
        [
            "angles".to_owned(),
            format!(
                "{} from {} to {} deg, sideslip {} deg",
                wing.angles_deg.len(),
                significant(wing.angles_deg[0], 3),
                significant(wing.angles_deg[wing.angles_deg.len() - 1], 3),
                significant(wing.sideslip_deg, 3)
            ),
        ],
    ];
    for profile in &wing.profiles {
        let polar = if matches!(profile.polar, SectionPolar::Given(_)) {
            "polar as given"
        } else {
            "polar computed at the Reynolds numbers of its strips"
        };
        rows.push([
            format!("profile {}", profile.name),
            format!(
                "{} % thick; {polar}",
                significant(100.0 * profile.outline.thickness(), 3)
            ),
        ]);
    }
    let rows: Vec<Vec<String>> = rows.into_iter().map(Vec::from).collect();
    format!(
        "{}\n{}no air is simulated: `ripstop polar` computes it\n",
        case.scene.title,
        aligned(&rows)
    )
}

/// How it was computed.
fn line(wing: &BareWing, found: &Polar) -> String {
    let halves = if wing.wing.is_symmetric && wing.sideslip_deg == 0.0 {
        "half of "
    } else {
        ""
    };
    let sideslip = if wing.sideslip_deg == 0.0 {
        String::new()
    } else {
        format!(", sideslip {} deg", wing.sideslip_deg)
    };
    let reynolds = found
        .points
        .iter()
        .flat_map(|p| &p.strips)
        .map(|s| s.reynolds);
    let (low, high) = reynolds.fold((f64::INFINITY, 0.0f64), |(low, high), r| {
        (low.min(r), high.max(r))
    });
    format!(
        "area {} m2, span {} m, mean chord {} m; {} m/s{sideslip}, Reynolds number {} to {}; {} panels on {halves}the wing",
        significant(wing.reference_area_m2, 4),
        significant(wing.wing.projected_span_m(), 4),
        significant(wing.reference_chord_m, 4),
        wing.speed_m_s,
        significant(low, 3),
        significant(high, 3),
        found.panels
    )
}

/// Numbers that are read off, with their meaning.
fn told(wing: &BareWing, numbers: &Numbers) -> Vec<[String; 2]> {
    let missing = "not in this sweep".to_owned();
    let at = |pair: Option<(f64, f64)>| {
        pair.map_or_else(
            || missing.clone(),
            |(value, angle)| format!("{} at {} deg", significant(value, 4), significant(angle, 3)),
        )
    };
    let one = |value: Option<f64>, unit: &str| {
        value.map_or_else(
            || missing.clone(),
            |v| format!("{}{unit}", significant(v, 4)),
        )
    };
    let span = wing.wing.projected_span_m();
    vec![
        [
            "lift slope, straight part".to_owned(),
            one(numbers.lift_slope_per_deg, " per deg"),
        ],
        [
            "angle without lift".to_owned(),
            one(
                numbers
                    .zero_lift_deg
                    .map(|angle| if angle.abs() < 1e-6 { 0.0 } else { angle }),
                " deg",
            ),
        ],
        [
            "highest lift coefficient".to_owned(),
            at(numbers.highest_lift),
        ],
        ["least drag coefficient".to_owned(), at(numbers.least_drag)],
        ["highest lift over drag".to_owned(), at(numbers.best_glide)],
        [
            "neutral point behind the reference point".to_owned(),
            one(
                numbers
                    .moment_slope
                    .map(|slope| -slope * wing.reference_chord_m),
                " m",
            ),
        ],
        [
            "aspect ratio, projected span".to_owned(),
            significant(span * span / wing.reference_area_m2, 4),
        ],
    ]
}

fn notes(wing: &BareWing, found: &Polar) -> Vec<String> {
    let mut notes = Vec::new();
    let angles = |is: &dyn Fn(&&Point) -> bool| -> Option<String> {
        let all: Vec<String> = found
            .points
            .iter()
            .filter(is)
            .map(|p| significant(p.angle_deg, 3))
            .collect();
        (!all.is_empty()).then(|| all.join(", "))
    };
    if let Some(all) = angles(&|p| p.coefficients.is_none()) {
        notes.push(format!(
            "sections and wing do not agree at {all} deg: there are no coefficients"
        ));
    }
    if let Some(all) = angles(&|p| p.coefficients.is_some() && !p.is_covered) {
        notes.push(format!("sections are at angles that their polars do not reach at {all} deg: lift levels off there"));
    }
    if found.below_range {
        notes.push(format!(
            "strips lie below a Reynolds number of {:.0e}, of which their computed polars are",
            polar::LEAST_REYNOLDS
        ));
    }
    let mach = wing.speed_m_s / SPEED_OF_SOUND_M_S;
    if mach > LARGEST_MACH {
        notes.push(format!(
            "the wing flies at {:.2} times the speed of sound; the method knows air of one density, good up to {LARGEST_MACH}",
            mach
        ));
    }
    let span_m = wing.wing.projected_span_m();
    if span_m > LARGEST_SPAN_M {
        notes.push(format!(
            "the wing spans {} m, more than any that flies: lengths are in metres",
            significant(span_m, 4)
        ));
    }
    if !found.sections_stall {
        notes.push("a computed polar of a section ends before its highest lift: highest lift and stall of the wing are not known".to_owned());
    }
    if let Some(all) = angles(&|p| p.separated.is_some()) {
        notes.push(format!(
            "a second, separated solution is there at {all} deg: a wing that has stalled follows it"
        ));
    }
    notes
}

const HEAD: [&str; 8] = [
    "angle [deg]",
    "C_L",
    "C_D",
    "C_D induced",
    "C_m",
    "L/D",
    "stalled",
    "separated C_L",
];

fn table(found: &Polar) -> Vec<Vec<String>> {
    let row = |point: &Point| {
        let number = |value: f64| format!("{value:.4}");
        let of = |value: &dyn Fn(&Coefficients) -> f64| {
            point
                .coefficients
                .as_ref()
                .map_or_else(String::new, |c| number(value(c)))
        };
        vec![
            significant(point.angle_deg, 4),
            of(&|c| c.lift),
            of(&Coefficients::drag),
            of(&|c| c.induced_drag),
            of(&|c| c.pitching_moment),
            point
                .coefficients
                .as_ref()
                .map_or_else(String::new, |c| format!("{:.2}", c.lift / c.drag())),
            format!("{:.0} %", 100.0 * point.stalled_share),
            point
                .separated
                .as_ref()
                .map_or_else(String::new, |c| number(c.lift)),
        ]
    };
    std::iter::once(HEAD.map(str::to_owned).to_vec())
        .chain(found.points.iter().map(row))
        .collect()
}

fn write(
    arguments: &PolarArguments,
    case: &Case,
    wing: &BareWing,
    found: &Polar,
    numbers: &Numbers,
) -> Result<(), OutputError> {
    let folder = &arguments.out;
    write_table(
        &folder.join(POLAR_TABLE),
        &COLUMNS.each_ref().map(|column| &*column.name),
        found.points.iter().map(|p| row(wing, p)),
    )?;
    let agreed = found.points.iter().filter(|p| p.coefficients.is_some());
    let strips = agreed.flat_map(|point| {
        point.strips.iter().map(|s| {
            [
                point.angle_deg,
                s.place_m.x,
                s.place_m.y,
                s.place_m.z,
                s.chord_m,
                s.width_m,
                s.reynolds,
                s.lift,
                s.drag,
                s.effective_rad.to_degrees(),
                f64::from(u8::from(!s.is_below_stall)),
            ]
        })
    });
    write_table(&folder.join("span.csv"), &SPAN_COLUMNS, strips)?;
    let charts = charts(found);
    let provenance = Provenance {
        program: format!("ripstop version {}", env!("CARGO_PKG_VERSION")),
        source: case.name.clone(),
        case: case.text.clone(),
    };
    for (name, chart) in &charts {
        chart.write(&folder.join(name), &provenance)?;
    }
    report::write_polar(
        folder,
        &PolarPage {
            title: case.scene.title.clone(),
            line: line(wing, found),
            numbers: told(wing, numbers),
            charts: charts.into_iter().map(|(_, chart)| chart).collect(),
            tables: vec![PageTable {
                heading: "All angles".to_owned(),
                rows: table(found),
            }],
            notes: notes(wing, found),
            case: case.text.clone(),
        },
    )
}

fn row(wing: &BareWing, point: &Point) -> [f64; 18] {
    let nothing = f64::NAN;
    let of =
        |value: &dyn Fn(&Coefficients) -> f64| point.coefficients.as_ref().map_or(nothing, value);
    let other =
        |value: &dyn Fn(&Coefficients) -> f64| point.separated.as_ref().map_or(nothing, value);
    let area = 0.5 * wing.density_kg_m3 * wing.speed_m_s.powi(2) * wing.reference_area_m2;
    [
        point.angle_deg,
        of(&|c| c.lift),
        of(&Coefficients::drag),
        of(&|c| c.induced_drag),
        of(&|c| c.profile_drag),
        of(&|c| c.pitching_moment),
        of(&|c| c.side_force),
        of(&|c| c.rolling_moment),
        of(&|c| c.yawing_moment),
        of(&|c| c.lift / c.drag()),
        of(&|c| area * c.lift),
        of(&|c| area * c.drag()),
        point.stalled_share,
        f64::from(u8::from(point.is_covered)),
        other(&|c| c.lift),
        other(&Coefficients::drag),
        other(&|c| c.pitching_moment),
        point.residual,
    ]
}

/// Charts by the names of their files.
fn charts(found: &Polar) -> Vec<(&'static str, Chart)> {
    type Axes<'a> = &'a dyn Fn(&Point, &Coefficients) -> [f64; 2];
    // Names tell two branches apart.
    let has_two = found.points.iter().any(|p| p.separated.is_some());
    let drawn = |labels: [&str; 2], axes: Axes| {
        let series = |name: &str, of: &dyn Fn(&Point) -> Option<Coefficients>| Series {
            name: name.to_owned(),
            points: (found.points.iter())
                .filter_map(|p| Some(axes(p, &of(p)?)))
                .collect(),
            bars: Vec::new(),
            markers: true,
            colour: None,
        };
        Chart {
            title: String::new(),
            labels: labels.map(str::to_owned),
            categories: Vec::new(),
            series: vec![
                series(if has_two { "from small angles" } else { "" }, &|p| {
                    p.coefficients
                }),
                series("separated", &|p| p.separated),
            ]
            .into_iter()
            .filter(|series| !series.points.is_empty())
            .collect(),
        }
    };
    let angle = "angle of attack [deg]";
    vec![
        (
            "lift",
            drawn([angle, "lift coefficient"], &|p, c| [p.angle_deg, c.lift]),
        ),
        (
            "drag_polar",
            drawn(["drag coefficient", "lift coefficient"], &|_, c| {
                [c.drag(), c.lift]
            }),
        ),
        (
            "glide",
            drawn([angle, "lift over drag"], &|p, c| {
                [p.angle_deg, c.lift / c.drag()]
            }),
        ),
        (
            "moment",
            drawn([angle, "pitching moment coefficient"], &|p, c| {
                [p.angle_deg, c.pitching_moment]
            }),
        ),
        ("span", span_chart(found)),
    ]
}

/// Lift coefficients of the strips along the span at a few angles.
fn span_chart(found: &Polar) -> Chart {
    let agreed: Vec<&Point> = found
        .points
        .iter()
        .filter(|p| p.coefficients.is_some())
        .collect();
    let step = agreed.len().div_ceil(DRAWN_SPANS).max(1);
    let series = agreed.iter().step_by(step).map(|point| Series {
        name: format!("{} deg", significant(point.angle_deg, 3)),
        points: point.strips.iter().map(|s| [s.place_m.y, s.lift]).collect(),
        bars: Vec::new(),
        markers: false,
        colour: None,
    });
    Chart {
        title: String::new(),
        labels: [
            "distance from the plane of symmetry [m]",
            "lift coefficient of the section",
        ]
        .map(str::to_owned),
        categories: Vec::new(),
        series: series.collect(),
    }
}
