//! Tables and charts of a trim.

use crate::measure;
use crate::output::{Chart, OutputError, Series, write_table};
use crate::run::run_folder::RunFolder;
use crate::simulation::Simulation;
use crate::statics::Trim;

/// Tables of a trim.
pub(in crate::run) const TABLES: [&str; 3] =
    ["trim_iterations.csv", "trim_span.csv", "trim_pressure.csv"];

/// Charts of a trim, without their endings.
pub(in crate::run) const CHARTS: [&str; 4] =
    ["trim_span", "trim_pressure", "trim_rows", "trim_cells"];

/// Writes tables and charts of a trim; nothing where there is none.
pub(in crate::run) fn write(
    folder: &RunFolder<'_>,
    simulation: &Simulation,
    trim: Option<&Trim>,
) -> Result<(), OutputError> {
    let Some(state) = trim else {
        return Ok(());
    };
    let columns = [
        "iteration",
        "speed_m_s",
        "sink_m_s",
        "glide_ratio",
        "angle_of_attack_deg",
        "internal_pressure_coefficient",
        "pitch_deg",
        "turn_deg",
        "outline_change",
        "guide_n",
        "riser_balance_error",
        "energy_norm",
        "evaluations",
        "air_s",
        "fabric_s",
    ];
    let rows: Vec<Vec<f64>> = state
        .iterations
        .iter()
        .map(|i| {
            vec![
                i.number as f64,
                i.speed_m_s,
                i.sink_m_s,
                i.glide_ratio,
                i.attack_rad.to_degrees(),
                i.inside,
                i.pitch_rad.to_degrees(),
                i.turn_rad.to_degrees(),
                i.shape_change,
                i.guide_n,
                i.balance_error,
                i.relative_norm,
                i.outcome.evaluations as f64,
                i.seconds[0],
                i.seconds[1],
            ]
        })
        .collect();
    write_table(&folder.join(TABLES[0]), &columns, &rows)?;
    let Some(flight) = &state.flight else {
        return Ok(());
    };
    let rows: Vec<Vec<f64>> = flight
        .strips
        .iter()
        .map(|s| {
            vec![
                s.y_m,
                s.place,
                s.chord_m,
                s.circulation_m2_s,
                s.lift,
                s.lift * s.chord_m,
                s.effective_rad.to_degrees(),
                s.drag,
            ]
        })
        .collect();
    let columns = [
        "y_m",
        "place",
        "chord_m",
        "circulation_m2_s",
        "lift_coefficient",
        "lift_coefficient_times_chord_m",
        "effective_angle_deg",
        "section_drag_coefficient",
    ];
    write_table(&folder.join(TABLES[1]), &columns, &rows)?;
    let title = &simulation.scene().title;
    let over_span = |name: &str, of: &dyn Fn(&crate::trim::glider::StripState) -> f64| Series {
        name: name.to_owned(),
        points: flight.strips.iter().map(|s| [s.y_m, of(s)]).collect(),
        bars: Vec::new(),
        markers: false,
        colour: None,
    };
    Chart {
        title: title.clone(),
        labels: [
            "distance from the middle along y [m]".to_owned(),
            "lift coefficient; times chord [m]".to_owned(),
        ],
        categories: Vec::new(),
        series: vec![
            over_span("lift coefficient", &|s| s.lift),
            over_span("lift coefficient times chord", &|s| s.lift * s.chord_m),
        ],
    }
    .write(&folder.join(CHARTS[0]), folder.provenance())?;
    pressure(folder, title, flight)?;
    if let (Some(wing), Some(structure)) = (
        simulation.scene().wing(),
        &simulation.structure_frame().structure,
    ) {
        let rows = measure::row_loads(wing, structure);
        let names = rows.iter().map(|row| row.name.clone()).collect();
        let series = Series {
            name: String::new(),
            points: rows
                .iter()
                .enumerate()
                .map(|(i, row)| [i as f64 + 1.0, row.load_n])
                .collect(),
            bars: Vec::new(),
            markers: true,
            colour: None,
        };
        Chart {
            title: title.clone(),
            labels: ["row".to_owned(), "tension of its risers [N]".to_owned()],
            categories: names,
            series: vec![series],
        }
        .write(&folder.join(CHARTS[2]), folder.provenance())?;
        cells(folder, title, simulation)?;
    }
    Ok(())
}

/// Sections of the pressure outside at the middle, half way and near the tip.
fn pressure(
    folder: &RunFolder<'_>,
    title: &str,
    flight: &crate::trim::Flight,
) -> Result<(), OutputError> {
    let outer = &flight.outer;
    let row = outer.around.len();
    let mut rows = Vec::new();
    for (strip, state) in flight.strips.iter().enumerate() {
        for (panel, s) in outer.around.iter().enumerate() {
            rows.push(vec![
                state.y_m,
                state.place,
                s * s,
                s.signum(),
                outer.coefficients[strip * row + panel],
            ]);
        }
    }
    let columns = [
        "y_m",
        "place",
        "chord_place",
        "side",
        "pressure_coefficient",
    ];
    write_table(&folder.join(TABLES[2]), &columns, &rows)?;
    let count = flight.strips.len();
    let series = [0, count / 2, (count * 9) / 10]
        .into_iter()
        .filter(|strip| *strip < count)
        .map(|strip| Series {
            name: format!("y = {:.2} m", flight.strips[strip].y_m),
            // Upwards is suction, as is usual.
            points: (0..row)
                .map(|i| {
                    let s = outer.around[i];
                    [s * s, -outer.coefficients[strip * row + i]]
                })
                .collect(),
            bars: Vec::new(),
            markers: false,
            colour: None,
        });
    Chart {
        title: title.to_owned(),
        labels: [
            "place along the chord, x/c".to_owned(),
            "pressure coefficient outside, times -1".to_owned(),
        ],
        categories: Vec::new(),
        series: series.collect(),
    }
    .write(&folder.join(CHARTS[1]), folder.provenance())?;
    Ok(())
}

/// Widths of the cells, flown and designed.
fn cells(folder: &RunFolder<'_>, title: &str, simulation: &Simulation) -> Result<(), OutputError> {
    let (Some(wing), Some(body), Some(cloth)) = (
        simulation.scene().wing(),
        &simulation.scene().body,
        simulation.cloth(),
    ) else {
        return Ok(());
    };
    let series = [
        ("designed", &body.structure.positions_m),
        ("flown", &cloth.positions_m),
    ]
    .map(|(name, positions)| Series {
        name: name.to_owned(),
        points: measure::cell_widths_m(wing, positions)
            .iter()
            .enumerate()
            .map(|(cell, width)| [cell as f64 + 1.0, *width])
            .collect(),
        bars: Vec::new(),
        markers: false,
        colour: None,
    });
    Chart {
        title: title.to_owned(),
        labels: [
            "cell, from the left tip".to_owned(),
            "distance of its ribs, mean over the outline [m]".to_owned(),
        ],
        categories: Vec::new(),
        series: series.into(),
    }
    .write(&folder.join(CHARTS[3]), folder.provenance())?;
    Ok(())
}
