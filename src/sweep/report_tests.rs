use super::*;
use crate::output::ReadOut;
use crate::sweep::{Vary, points};

fn sweep() -> Sweep {
    let varies: Vec<Vary> = [
        "air.speed_m_s=20,30;time.end_s=2,1",
        "belts=as_written,absent",
    ]
    .map(|text| text.parse().unwrap())
    .to_vec();
    let mut runs: Vec<Outcome> = points(&varies)
        .unwrap()
        .iter()
        .map(|point| Outcome::waiting(point, "00", None))
        .collect();
    for (k, run) in runs.iter_mut().take(3).enumerate() {
        run.status = Status::Done;
        let drag = Quantity::new(0.8 + 0.01 * k as f64).with_confidence(0.05);
        run.results
            .insert(&ReadOut::new("drag_coefficient", "1", ""), drag);
        let time = Quantity::new(0.05).with_sampling_error(0.001);
        run.results
            .insert(&ReadOut::new("fill_time_s", "s", ""), time);
    }
    runs[3].status = Status::Failed;
    runs[3].message = Some("it broke down".to_owned());
    Sweep {
        schema_version: 1,
        title: "Canopy".to_owned(),
        case: "case.toml".to_owned(),
        variant: Some("quick".to_owned()),
        leading_keys: Sweep::leading(&varies),
        lattice_key: Sweep::lattice_key(&varies),
        ladders: Vec::new(),
        runs,
    }
}

fn ratio() -> ReadOut {
    ReadOut::new("ratio", "1", "ratio")
}

#[test]
fn the_table_has_a_row_for_each_run_and_says_what_failed() {
    let chosen = Chosen {
        pairs: Vec::new(),
        results: vec!["drag_coefficient".to_owned(), "fill_time_s".to_owned()],
        histories: Vec::new(),
    };
    let text = markdown(&sweep(), &chosen);
    let expected = "\
| air.speed_m_s | belts | run | drag_coefficient | fill_time_s [s] |
|---|---|---|---|---|
| 20 | as_written | done | 0.800 ±0.050 | 0.0500 ±0.0010 |
| 20 | absent | done | 0.810 ±0.050 | 0.0500 ±0.0010 |
| 30 | as_written | done | 0.820 ±0.050 | 0.0500 ±0.0010 |
| 30 | absent | failed | - | - |

speed_m_s=30,belts=absent: it broke down
";
    assert_eq!(text, expected);
}

#[test]
fn runs_whose_account_was_not_met_are_marked() {
    let mut sweep = sweep();
    sweep.runs[1].missed = vec!["residual stiffness: NOT MET".to_owned()];
    let text = markdown(&sweep, &Chosen::default());
    let row = format!("* {}: residual stiffness: NOT MET\n", sweep.runs[1].folder);
    for expected in [
        "| 20 | absent | done † |",
        "† trust: NOT ALL WAS MET in 1 of 4 runs:",
        &row,
    ] {
        assert!(text.contains(expected), "{text}");
    }
    assert_eq!(text.matches('†').count(), 2);
}

#[test]
fn files_hold_all_runs_and_read_back() {
    let folder = tempfile::tempdir().unwrap();
    let before = sweep();
    for (k, run) in before.runs.iter().take(2).enumerate() {
        let own = folder.path().join(&run.folder);
        std::fs::create_dir(&own).unwrap();
        let text = format!("time_s,ratio\n-0.1,0\n0.0,0.2\n0.1,0.{}\n0.2,\n", k + 4);
        std::fs::write(own.join("history.csv"), text).unwrap();
    }
    let chosen = Chosen {
        pairs: Vec::new(),
        results: vec!["drag_coefficient".to_owned(), "unknown".to_owned()],
        histories: vec![ratio()],
    };
    write(folder.path(), &before, &chosen).unwrap();
    assert_eq!(Sweep::read(folder.path()).unwrap(), before);
    let mut csv = csv::Reader::from_path(folder.path().join("sweep.csv")).unwrap();
    let header = csv.headers().unwrap().clone();
    assert_eq!(
        header.iter().take(7).collect::<Vec<_>>(),
        [
            "air.speed_m_s",
            "belts",
            "time.end_s",
            "folder",
            "status",
            "drag_coefficient",
            "drag_coefficient_uncertainty"
        ]
    );
    let rows: Vec<_> = csv.records().map(Result::unwrap).collect();
    assert_eq!(rows.len(), 4);
    assert_eq!((&rows[1][5], &rows[1][6]), ("0.81", "0.05"));
    assert_eq!((&rows[3][4], &rows[3][5]), ("failed", ""));
    for file in ["sweep_drag_coefficient", "sweep_history_ratio"] {
        for kind in ["png", "svg"] {
            let path = folder.path().join(format!("{file}.{kind}"));
            assert!(
                std::fs::metadata(&path).unwrap().len() > 1000,
                "{file}.{kind}"
            );
        }
    }
    let svg = std::fs::read_to_string(folder.path().join("sweep_drag_coefficient.svg")).unwrap();
    let from = svg.split_once("<metadata>").unwrap().1;
    assert!(from.starts_with("\nSoftware: ripstop version "), "{from}");
    assert!(from.contains("\nSource: case.toml, variant quick\n</metadata>"));
    assert!(!folder.path().join("sweep_unknown.png").exists());
    let history = histories(folder.path(), &before, &ratio());
    assert_eq!(history.series.len(), 2);
    assert_eq!(history.series[1].points, [[0.0, 0.2], [0.1, 0.5]]);
    let drag = chart(&before, "drag_coefficient");
    assert_eq!(drag.series.len(), 2);
    assert_eq!(drag.series[0].points[0], [20.0, 0.8]);
    let [speed, value] = drag.series[0].points[1];
    assert!(speed == 30.0 && (value - 0.82).abs() < 1e-12);
    assert_eq!(drag.series[1].name, "belts = absent");
}
