use super::*;
use crate::output::ReadOut;
use crate::sweep::{Vary, points};

/// A sweep over lattices of 12, 16 and 24 cells, crosswise with two masses and two starts; `value` of run, cells, mass, start.
fn sweep(cells: &str, value: impl Fn(f64, f64, usize) -> Quantity) -> Sweep {
    let varies: Vec<Vary> = vec![
        format!("resolution.cells_per_diameter={cells}")
            .parse()
            .unwrap(),
        "payload.mass_kg=100,200".parse().unwrap(),
        Vary::ensemble(2),
    ];
    sweep_of(&varies, |run, number| {
        let of = |key: &str| run.values[key].parse::<f64>().unwrap();
        value(
            of("resolution.cells_per_diameter"),
            of("payload.mass_kg"),
            number % 2,
        )
    })
}

/// A sweep that is done, on 24 cells where it does not say otherwise; `value` of run and number.
fn sweep_of(varies: &[Vary], value: impl Fn(&Outcome, usize) -> Quantity) -> Sweep {
    let runs = points(varies).unwrap();
    let runs = runs.iter().enumerate().map(|(number, point)| {
        let mut run = Outcome::waiting(point, "00", None);
        let cells = run.values.get("resolution.cells_per_diameter");
        let cells = cells.map_or(24.0, |cells| cells.parse::<f64>().unwrap());
        let quantity = value(&run, number);
        run.cell_size_m = Some(1.0 / cells);
        run.status = Status::Done;
        run.comparison = vec![ComparisonRow::new(
            "peak",
            &quantity,
            [30.0, 30.0],
            "paper",
            &LatticeError::None,
        )];
        run.results.insert(&ReadOut::new("peak", "g", ""), quantity);
        run
    });
    Sweep {
        schema_version: 1,
        title: "Drop".to_owned(),
        case: "case.toml".to_owned(),
        variant: None,
        leading_keys: Sweep::leading(varies),
        lattice_key: Sweep::lattice_key(varies),
        runs: runs.collect(),
        ladders: Vec::new(),
    }
}

/// Series, lattices and numbers of starts of a sweep.
fn groups(varies: &[&str], starts: usize) -> Vec<(String, Vec<String>, Vec<usize>)> {
    let mut varies: Vec<Vary> = varies.iter().map(|text| text.parse().unwrap()).collect();
    if starts > 1 {
        varies.push(Vary::ensemble(starts));
    }
    ladders(&sweep_of(&varies, |_, _| Quantity::new(1.0)))
        .into_iter()
        .map(|ladder| (ladder.series, ladder.lattices, ladder.starts))
        .collect()
}

/// Starts on one lattice differ in nothing else, whatever varies together with what.
#[test]
fn starts_are_of_one_case() {
    let words =
        |all: &[&str]| -> Vec<String> { all.iter().map(|word| (*word).to_owned()).collect() };
    // Rings follow the cells: a lattice each, as before.
    let follow = ["resolution.cells_per_diameter=12,16,24; rings=6,8,12"];
    let expected = (String::new(), words(&["12", "16", "24"]), vec![2, 2, 2]);
    assert_eq!(groups(&follow, 2), [expected]);
    // On 24 cells they do not: these are two cases.
    let beside = ["resolution.cells_per_diameter=24,24; rings=12,16"];
    let of = |rings: &str| (format!("rings = {rings}"), words(&["24"]), vec![3]);
    assert_eq!(groups(&beside, 3), [of("12"), of("16")]);
    // Starts by hand, of two masses.
    let by_hand = [
        "resolution.shift_cells=[0.0, 0.0, 0.1],[0.0, 0.0, 0.2],[0.0, 0.0, 0.3]; payload.mass_kg=100,100,200",
    ];
    let found = groups(&by_hand, 1);
    let found: Vec<(&str, &[usize])> = (found.iter())
        .map(|(series, _, starts)| (&series[..], &starts[..]))
        .collect();
    let expected: [(&str, &[usize]); 2] = [
        ("payload.mass_kg = 100", &[2]),
        ("payload.mass_kg = 200", &[1]),
    ];
    assert_eq!(found, expected);
    // What follows from a leading key tells nothing more.
    let cross = [
        "payload.mass_kg=100,200; gravity=9.8,3.7",
        "resolution.cells_per_diameter=12,24",
    ];
    let names: Vec<String> = groups(&cross, 2).into_iter().map(|group| group.0).collect();
    assert_eq!(names, ["payload.mass_kg = 100", "payload.mass_kg = 200"]);
}

#[test]
fn lattices_of_every_series_are_judged() {
    let at = |cells: f64, mass: f64, start: usize| {
        let off = if start == 0 { -1e-3 } else { 1e-3 };
        let own = if mass == 100.0 {
            20.0 + 50.0 / (cells * cells)
        } else {
            500.0 / cells
        };
        Quantity::new(own + off)
    };
    let mut sweep = sweep("24,12,16", at);
    let told = ladders(&sweep);
    let names: Vec<&str> = told.iter().map(|ladder| ladder.series.as_str()).collect();
    assert_eq!(names, ["payload.mass_kg = 100", "payload.mass_kg = 200"]);
    let [light, heavy] = [&told[0].rungs[0], &told[1].rungs[0]];
    assert_eq!(told[0].lattices, ["12", "16", "24"]);
    assert_eq!(told[0].starts, [2, 2, 2]);
    // Student's t for one degree of freedom; two starts at ±0.001 about their mean.
    let half = 12.706 * 1e-3 * 2_f64.sqrt();
    assert!((light.intervals[2].unwrap() - half).abs() < 1e-9);
    assert_eq!(light.interval_of, "one of 2 starts");
    assert!((light.order.unwrap() - 2.0).abs() < 1e-6, "{light:?}");
    assert!((light.tends_to.unwrap() - 20.0).abs() < 1e-6);
    assert_eq!(light.resolved, Some(true), "{}", light.verdict);
    let error: f64 = 1.25 * 50.0 / (24.0 * 24.0);
    assert!((light.error.unwrap() - error.hypot(half)).abs() < 1e-6);
    assert!((heavy.order.unwrap() - 1.0).abs() < 1e-6, "{heavy:?}");
    assert_eq!(heavy.resolved, Some(false));
    assert!(
        heavy.verdict.starts_with("unresolved: ±130 %"),
        "{}",
        heavy.verdict
    );
    // 20.1 lies beyond its error from 30, 20.8 within its own.
    assert_eq!(told[0].comparison[0].resolved, Some(true));
    assert_eq!(told[1].comparison[0].resolved, Some(false));

    mark_unresolved(&mut sweep);
    for run in &sweep.runs {
        let marked = run.results.get("peak").unwrap().unresolved.is_some();
        assert_eq!(marked, run.values["payload.mass_kg"] == "200");
    }
    let text = ladder_markdown(&told, &["peak".to_owned()]);
    assert!(text.contains("| 12 | 16 | 24 | order |"), "{text}");
    assert!(
        text.contains("payload.mass_kg = 200 (2, 2, 2 starts)"),
        "{text}"
    );
    let folder = tempfile::tempdir().unwrap();
    write_ladders(folder.path(), &told).unwrap();
    let mut csv = csv::Reader::from_path(folder.path().join("ladder.csv")).unwrap();
    let header = csv.headers().unwrap().clone();
    let rows: Vec<_> = csv.records().map(Result::unwrap).collect();
    let place = |name: &str| header.iter().position(|own| own == name).unwrap();
    assert_eq!(rows.len(), 2);
    assert_eq!(&rows[1][place("resolved")], "false");
    assert_eq!(&rows[1][place("lattice_3")], "24");
}

#[test]
fn two_lattices_and_lost_values_stay_unknown() {
    let told = |cells: &str, lost: f64| {
        let at = |own: f64, _: f64, _: usize| {
            if own == lost {
                Quantity::missing("no peak")
            } else {
                Quantity::new(20.0 + 1.0 / own)
            }
        };
        ladders(&sweep(cells, at))[0].rungs[0].clone()
    };
    let two = told("12,24", 0.0);
    assert_eq!((two.resolved, two.order), (None, None));
    assert_eq!(two.verdict, "unknown: two lattices, spread 0.042");
    assert_eq!(told("12,16,24", 16.0).verdict, two.verdict);
    assert!(told("12,16,24", 24.0).verdict.contains("did not determine"));
    assert_eq!(told("12", 0.0).verdict, "unknown: one lattice");
}

#[test]
fn an_interval_joins_the_error_and_none_leaves_it_unknown() {
    let run = |interval: Option<f64>| {
        let at = |cells: f64, _: f64, _: usize| Quantity {
            value: Some(1.0 + 0.1 / cells),
            unit: "1".to_owned(),
            confidence: interval,
            ..Quantity::default()
        };
        let mut one = sweep("12,16,24", at);
        one.runs.retain(|run| !run.folder.contains("start"));
        ladders(&one)[0].rungs[0].clone()
    };
    let bare = run(None);
    assert_eq!(bare.resolved, None);
    assert!(bare.verdict.contains("--ensemble"), "{}", bare.verdict);
    assert_eq!(run(Some(1e-4)).resolved, Some(true));
    // The interval alone is more than 5 %; the differences drown in it.
    let wide = run(Some(0.08));
    assert_eq!((wide.resolved, wide.order), (Some(false), None));
}

#[test]
fn means_over_starts_are_better_known_than_one() {
    let at = |_: f64, _: f64, start: usize| {
        Quantity::new(if start == 0 { 0.9 } else { 1.1 }).with_confidence(0.1)
    };
    let mut sweep = sweep("12", at);
    for run in &mut sweep.runs {
        let own = run.results.get("peak").cloned().unwrap();
        run.results
            .insert(&ReadOut::new("opening_force_factor", "1", ""), own);
    }
    let told = &ladders(&sweep)[0];
    let [mean, extreme] = [&told.rungs[0], &told.rungs[1]];
    assert!((mean.values[0].unwrap() - 1.0).abs() < 1e-12);
    assert_eq!(mean.interval_of, "mean of 2 starts");
    assert_eq!(extreme.interval_of, "one of 2 starts");
    let ratio = extreme.intervals[0].unwrap() / mean.intervals[0].unwrap();
    assert!((ratio - 2_f64.sqrt()).abs() < 1e-12, "{ratio}");
}

/// What is nothing on every lattice is no share of anything.
#[test]
fn nothing_is_known_well() {
    for rung in ladders(&sweep("12,16,24", |_, _, _| Quantity::new(0.0)))
        .iter()
        .flat_map(|ladder| &ladder.rungs)
    {
        assert_eq!(rung.resolved, Some(true), "{}", rung.verdict);
        assert!(!rung.verdict.contains("NaN"), "{}", rung.verdict);
    }
}

#[test]
fn sweeps_of_other_keys_have_no_ladder() {
    let mut sweep = sweep("12,16", |_, _, _| Quantity::new(1.0));
    sweep.leading_keys = vec!["payload.mass_kg".to_owned()];
    sweep.lattice_key = None;
    assert!(ladders(&sweep).is_empty());
    assert_eq!(ladder_markdown(&[], &[]), "");
}
