//! Charts of runs with several rigid bodies.

use libtest_mimic::Trial;

use crate::command_line::ripstop;
use crate::engines::plain;

pub fn trials() -> Vec<Trial> {
    plain("body_charts::hold_all_bodies", charts)
}

/// Charts of the history show two spheres with their names, and a legend is nothing that one sphere needs.
fn charts() {
    let folder = tempfile::tempdir().unwrap();
    let page = |name: &str| {
        let page = folder.path().join(name).join("report.html");
        std::fs::read_to_string(page).unwrap()
    };
    let drawn = |name: &str, changes: &[&str]| {
        let out = folder.path().join(name);
        let mut arguments = vec!["run", "cases/sphere.toml", "--engine", "cpu", "--out"];
        arguments.push(out.to_str().unwrap());
        let small = [
            "resolution.cells_per_diameter=absent",
            "resolution.cell_size_m=0.02",
            "air.refinement={around=\"nothing\"}",
            "air.wind_tunnel.size_m=[0.5, 0.7, 0.4]",
            "air.wind_tunnel.sponge_length_m=0.1",
            "bodies.sphere.position_m=[0.2, 0.2, 0.2]",
            "output.history_plots=true",
            "time.end_s=2.0",
        ];
        for change in small.iter().chain(changes) {
            arguments.extend(["--set", change]);
        }
        let output = ripstop(&arguments);
        assert_eq!(output.code, 0, "{}", output.errors);
        ["drag_coefficient", "lift_coefficient", "force_x_n"].map(|column| {
            let path = out.join(format!("history_{column}.svg"));
            std::fs::read_to_string(&path).unwrap_or_else(|why| panic!("{path:?}: {why}"))
        })
    };
    let two = [
        "bodies.other.position_m=[0.2, 0.5, 0.2]",
        "bodies.other.sphere.diameter_m=0.08",
    ];
    for svg in drawn("two", &two) {
        assert!(svg.contains(">sphere<") && svg.contains(">other<"), "{svg}");
    }
    // The page of the run has them, too: the drag of both, which one is which, and no more charts than columns.
    let two = page("two");
    assert!(two.contains(">sphere<") && two.contains(">other<"));
    let charts = |page: &str| page.matches("<svg").count();
    for svg in drawn("one", &[]) {
        assert!(!svg.contains(">sphere<"), "{svg}");
    }
    let one = page("one");
    assert!(!one.contains(">sphere<"));
    assert_eq!([charts(&one), charts(&two)], [3, 3]);
}
