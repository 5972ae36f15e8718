//! Wings of LEparagliding: our own drawing in its format, brought in, measured and flown.

use std::fmt::Write;
use std::path::Path;

use libtest_mimic::Trial;
use ripstop::case::{self, Choices, leparagliding};

use crate::command_line::{Finished, ripstop, root};
use crate::engines::plain;
use crate::folders::json;

pub fn trials() -> Vec<Trial> {
    [
        plain("import::a_wing_has_the_measures_of_its_drawing", measures),
        plain("import::the_example_is_up_to_date", example),
        plain("import::folders_within_folders", nested),
        plain("import::rods_and_the_speed_bar", rods_and_bar),
        plain("import::a_wing_flies", flies),
        plain("import::a_wing_of_xflr5_has_its_measures", of_xflr5),
        plain("import::what_cannot_be_brought_in_is_told", refused),
    ]
    .into_iter()
    .flatten()
    .collect()
}

/// Ribs of a half.
const RIBS: usize = 12;

/// Flat span and chord in the middle of the drawing [cm]; the wing scale.
const SPAN_CM: f64 = 800.0;
const CHORD_CM: f64 = 220.0;
pub const SCALE: f64 = 1.05;

/// Place of a rib, and chord there [cm]: an ellipse upon a rectangle.
pub fn rib(number: usize, even: bool) -> [f64; 2] {
    let offset = if even { 0.0 } else { 0.5 };
    let last = (RIBS - 1) as f64 + offset;
    let x = 0.5 * SPAN_CM * (number as f64 + offset) / last;
    let share = 2.0 * x / SPAN_CM;
    [
        x,
        CHORD_CM * (0.3 + 0.7 * (1.0 - share * share).max(0.0).sqrt()),
    ]
}

/// A drawing of ours in the format of LEparagliding 3, with what its own files have: headings, tabs, numbers without a leading digit.
pub fn drawing(even: bool, kind: &str) -> String {
    let mut text = String::from(
        "****************\n* Input data file 3.28 version  *\n****************\n*             1. GEOMETRY                                    *\n* Brand name\n\"Ripstop\"\n* Wing name\n\"Own wing\"\n* Drawing scale\n1.\n",
    );
    let _ = write!(
        text,
        "* Wing scale\n{SCALE}\n* Number of cells\n\t{}\n* Number of ribs\n\t{}\n* Alpha wingtip, parameter\n2.0\t1\n* Paraglider type and parameter\n\"{kind}\" \t1\n* Rib geometric parameters\nRib\tx-rib\ty-LE\n",
        2 * RIBS - 1,
        2 * RIBS
    );
    for number in 0..RIBS {
        let [x, chord] = rib(number, even);
        let lean = 50.0 * (2.0 * x / SPAN_CM).powf(1.4);
        let front = 0.4 * (CHORD_CM - chord);
        let back = front + chord;
        let _ = writeln!(
            text,
            " {}\t{x:.2}\t{front:.2}   {back:.2}\t{x:.2}\t.00 {lean:.2} 33.33 .00\t0.00 50.0",
            number + 1
        );
    }
    text += "*************\n*             2. AIRFOILS       \t *\n* Airfoil name, intake in, intake out , open , disp, rweight\n";
    for number in 0..RIBS {
        let file = if number + 1 == RIBS {
            "edge.txt"
        } else {
            "own.txt"
        };
        let open = u8::from(number + 2 < RIBS);
        let _ = writeln!(text, "{}\t{file}\t1.0\t3.0\t{open}\t0\t1\t15", number + 1);
    }
    text += "*************\n*            3. ANCHOR POINTS   *\n* Airf Anch A B C D E F\n";
    for number in 0..RIBS {
        let _ = writeln!(text, "{}\t3\t10\t35 \t65.5 0 0\t100", number + 1);
    }
    text += "***\n*          4. AIRFOIL HOLES  *\n1\n1\n12\n0\n***\n*           5. SKIN TENSION *\nExtrados\n0.\t\t0.1\t\t0.\t\t0.\n6.\t\t1.0\t\t12.\t\t1.5\n14.\t\t2.2\t\t25.\t\t2.0\n75.\t\t2.4\t\t70.\t\t1.8\n90.\t\t1.0\t\t88.\t\t0.9\n100.\t\t0.\t\t100.\t\t0.1\n0.0114\n***\n*  8. Global AoA estimation *\n* Finesse GR\n8.0\n* Center of pressure\n30.\n* Calage %\n42\n* Risers lenght cm\n45\n* Line lenght cm\n480\n* Karabiners cm\n42\n";
    text += "***\n*          9. SUSPENSION LINES DESCRIPTION *\n3\n3\n";
    // Attached at every second rib; of an even number of cells the first is that in the middle. The last line of B leads to an anchor of A.
    for row in 1..=3 {
        let ends: Vec<usize> = (1..RIBS).step_by(2).collect();
        let _ = writeln!(text, "{}", ends.len() + usize::from(row == 2));
        for (number, end) in ends.iter().enumerate() {
            let _ = writeln!(
                text,
                "3\t1 1\t2 {}\t3 {}\t0 0\t{row} {end}",
                number / 3 + 1,
                number + 1
            );
        }
        if row == 2 {
            let _ = writeln!(text, "2\t1 1\t2 3\t0 0\t0 0\t1 {}", RIBS);
        }
    }
    text += "***\n*       10. BRAKES *\n250\n4\n";
    for (number, end) in ["3", "5.4", "8", "11"].iter().enumerate() {
        let _ = writeln!(
            text,
            "3 1 1 2 {} 3 {} 0 0 6 {end}",
            number / 2 + 1,
            number + 1
        );
    }
    text += "* Brake distribution\n0 25 50 80 100\n0 0 0 0 0\n***\n*       11. Ramification lengths *\n3\t150\n4\t200\t80\n3\t120\n4\t180\t80\n***\n*  12. H V and VH ribs *\n0\n";
    text += RODS;
    text += "***\n*       28. PARAMETERS FOR CALAGE VARIATION\n***\n1\n3\n10. 35.  65.5  0  0  0\n-4 4 5 10\n";
    text
}

/// Two groups of rods around noses, as scheme 1 has them.
const RODS: &str = "***\n*       21. JONCS DEFINITION (NYLON RODS)\n***\n1\n2\n1 1 8\n4.2   10.8    1.36   2.0\n3.67  9.0    0.79   2.0\n0.0   9.35    6.3   9.35\n2   9 11\n5.0   12.0    1.36   2.0\n3.67  8.0    0.79   2.0\n0.0   9.35    6.3   9.35\n";

/// The same scheme as blocks of several kinds: an arc within ribs, and the two rods of a nose that is curved inwards.
const OTHER_RODS: &str = "***\n*       21. JONCS DEFINITION (NYLON RODS)\n***\n2\n2\n1 2\n1\n1 3 4\n15 2 20 3 1.0\n0.0   9.35    6.3   9.35\n2 3\n1\n1 1 6\n4.2   10.8    1.0   2.0\n3.5   5.0     1.0   0.7\n4.5   5.0     2.2   1.0\n3.67  12.1    0.79   2.0\n0.0   10.35    6.3   9.35\n";

/// A profile as LEparagliding has it: numbers of points before the coordinates.
fn airfoil(thickness: f64) -> String {
    let half = |x: f64| {
        let polynomial = 0.2969 * x.sqrt() - 0.126 * x - 0.3516 * x * x + 0.2843 * x.powi(3);
        5.0 * thickness * (polynomial - 0.1036 * x.powi(4))
    };
    let places: Vec<f64> = (0..=40)
        .map(|k| 0.5 * (1.0 - (std::f64::consts::PI * f64::from(k) / 40.0).cos()))
        .collect();
    let mut text = String::from("own\n 81\n 41\n 4\n 37\n");
    for x in places.iter().rev() {
        let _ = writeln!(text, " {x:.6}     {:.6}", half(*x));
    }
    for x in &places[1..] {
        let _ = writeln!(text, " {x:.6}     {:.6}", -half(*x));
    }
    text
}

pub fn put(folder: &Path, even: bool, kind: &str) {
    std::fs::create_dir_all(folder).unwrap();
    let write = |name: &str, text: &str| std::fs::write(folder.join(name), text).unwrap();
    write("leparagliding.txt", &drawing(even, kind));
    write("own.txt", &airfoil(0.17));
    write("edge.txt", &airfoil(0.0));
}

/// What `ripstop import` says of a file or a folder.
pub fn brought_in(from: &Path, out: &Path) -> Finished {
    ripstop(&[
        "import",
        from.to_str().unwrap(),
        "--out",
        out.to_str().unwrap(),
    ])
}

/// The drawing that the documentation brings in, by its command.
fn example() {
    let folder = root().join("cases/drawings/own-wing");
    if std::env::var_os("RIPSTOP_WRITE_DOCS").is_some() {
        put(&folder, true, "ds");
    }
    let fresh = tempfile::tempdir().unwrap();
    put(fresh.path(), true, "ds");
    for name in ["leparagliding.txt", "own.txt", "edge.txt"] {
        let [kept, now] = [&folder, fresh.path()]
            .map(|at: &Path| std::fs::read_to_string(at.join(name)).unwrap_or_default());
        assert!(
            kept == now,
            "cases/drawings/own-wing/{name} is not what tests/import.rs draws: run with RIPSTOP_WRITE_DOCS=1"
        );
    }
    let out = fresh.path().join("out");
    let file = folder.join("leparagliding.txt");
    let output = brought_in(&file, &out);
    assert_eq!(output.code, 0, "{}", output.errors);
}

fn measures() {
    for even in [true, false] {
        let folder = tempfile::tempdir().unwrap();
        put(folder.path(), even, "ds");
        let area_cm2: f64 = (1..RIBS)
            .map(|k| {
                let ([x, chord], [before, other]) = (rib(k, even), rib(k - 1, even));
                (x - before) * (chord + other)
            })
            .sum::<f64>()
            + 2.0 * rib(0, even)[0] * rib(0, even)[1];
        let area_m2 = 1e-4 * SCALE * SCALE * area_cm2;
        // What the other program would have found, told as it does.
        let text = format!("Flat area =  {area_m2:.4} m2  1. ft2\nFlat span =  8.40 m  1. ft\n");
        std::fs::write(folder.path().join("lep-out.txt"), text).unwrap();
        let out = folder.path().join("out");
        let file = folder.path().join("leparagliding.txt");
        let output = brought_in(&file, &out);
        assert_eq!(output.code, 0, "{}", output.errors);
        let case = case::load(&out.join("wing.toml"), &Choices::default()).unwrap();
        let wing = case.scene.wing().unwrap();
        assert_eq!(wing.plan.cells, 2 * RIBS - if even { 2 } else { 1 });
        let found = &wing.built.measures;
        assert!(
            (found.flat_area_m2 / area_m2 - 1.0).abs() < 1e-3,
            "{found:?}"
        );
        assert!((found.flat_span_m / 8.4 - 1.0).abs() < 1e-3, "{found:?}");
        for told in [
            "flat area",
            "edge.txt is flat",
            "1 brake lines end between two ribs",
        ] {
            assert!(output.printed.contains(told), "{told}: {}", output.printed);
        }
        // It lies there already.
        let again = brought_in(&file, &out);
        assert_eq!(again.code, 2);
        assert!(
            again.errors.contains("is there already"),
            "{}",
            again.errors
        );
    }
}

/// A folder of folders brings in all wings that lie in it, one in a folder of its own and those beside it.
fn nested() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    for name in ["all/wing", "all/wing/22", "all/series/a/b"] {
        put(&at(name), true, "ds");
    }
    let out = at("out");
    let all = at("all");
    let output = brought_in(&all, &out);
    assert_eq!(output.code, 0, "{}", output.errors);
    for name in ["wing", "wing/22", "series/a/b"] {
        assert!(out.join(name).join("wing.toml").is_file(), "{name}");
        let name = Path::new(name).display().to_string();
        assert!(
            output
                .printed
                .lines()
                .any(|line| line.starts_with(&format!("{name} "))),
            "{name}: {}",
            output.printed
        );
    }
    // The folder of a wing is one.
    let own = at("own");
    let one = all.join("series").join("a").join("b");
    let output = brought_in(&one, &own);
    assert_eq!(output.code, 0, "{}", output.errors);
    let text = std::fs::read_to_string(own.join("wing.toml")).unwrap();
    let is_as_drawn = |line: &str| {
        line.starts_with("upper = [[0.0, ") && line.contains("skin tension, section 5")
    };
    assert!(text.lines().any(is_as_drawn), "{text}");
}

fn rods_and_bar() {
    let drawn = drawing(true, "ds");
    let of = |text: &str| leparagliding::import(text, Some(80.0), |_| None).unwrap();
    let table = |text: &str| -> toml::Table { text.parse().unwrap() };
    let imported = of(&drawn);
    let wing = &table(&imported.text)["structure"]["wing"];
    let numbers = |value: &toml::Value| -> Vec<f64> {
        let numbers = value.as_array().unwrap().iter();
        numbers
            .map(|number| {
                number
                    .as_float()
                    .or(number.as_integer().map(|i| i as f64))
                    .unwrap()
            })
            .collect()
    };
    let rods = &wing["rods"];
    assert_eq!(rods.as_table().unwrap().len(), 2);
    let [upper, lower] = ["upper", "lower"].map(|side| numbers(&rods["nose_1"][side]));
    for (found, end) in [(upper, 0.108), (lower, 0.09)] {
        assert!(
            found[0] == 0.0 && (found[1] - end).abs() < 1e-12,
            "{found:?}"
        );
    }
    // The first rib stands in the middle: 0 here.
    let ribs = numbers(&rods["nose_2"]["ribs"]);
    assert_eq!(ribs, [8.0, 9.0, 10.0]);
    // Without a rib there they count from 1. A rib has one rod; those that are not there are told.
    let odd = of(&drawing(false, "ds").replace("2   9 11", "2   7 14"));
    let ribs = numbers(&table(&odd.text)["structure"]["wing"]["rods"]["nose_2"]["ribs"]);
    assert_eq!(ribs, [9.0, 10.0, 11.0, 12.0]);
    let told = "rods of 4 of the ribs 7 to 14";
    let all = &odd.left_out;
    assert!(all.iter().any(|line| line.contains(told)), "{all:?}");
    // Turned by 4° about C, at 0.655 of a chord of 2.2 m times the scale.
    let shortened = &wing["speed_bar"]["shortening_m"];
    let chord_m = 0.01 * CHORD_CM * SCALE;
    for (row, place) in [("A", 0.1), ("B", 0.35)] {
        let expected = (0.655 - place) * chord_m * 4f64.to_radians().sin();
        let found = shortened[row].as_float().unwrap();
        assert!((found - expected).abs() < 1e-6, "{row}: {found} {expected}");
    }
    assert!(shortened.get("C").is_none(), "{shortened}");
    // Where the scheme has several kinds, what is left out is told.
    let other = of(&drawn.replace(RODS, OTHER_RODS));
    let rods = table(&other.text)["structure"]["wing"]["rods"].clone();
    let around = numbers(&rods["nose_1"]["lower"]);
    assert!((around[1] - 0.121).abs() < 1e-12, "{around:?}");
    assert_eq!(rods.as_table().unwrap().len(), 1);
    for told in [
        "rods within ribs 3 to 4",
        "two rods in each of the ribs 1 to 6",
    ] {
        let all = &other.left_out;
        assert!(
            all.iter().any(|line| line.contains(told)),
            "{told}: {all:?}"
        );
    }
    // Files of older versions have neither.
    let older = of(&drawn[..drawn.find(RODS).unwrap()]);
    let wing = table(&older.text)["structure"]["wing"].clone();
    assert!(wing.get("rods").is_none() && wing.get("speed_bar").is_none());
    for told in ["section 21 (rods)", "section 28"] {
        let all = &older.left_out;
        assert!(
            all.iter().any(|line| line.contains(told)),
            "{told}: {all:?}"
        );
    }
}

fn flies() {
    let folder = tempfile::tempdir().unwrap();
    put(folder.path(), true, "ds");
    let [out, run] = ["out", "run"].map(|name| folder.path().join(name));
    let file = folder.path().join("leparagliding.txt");
    let output = ripstop(&[
        "import",
        file.to_str().unwrap(),
        "--pilot",
        "60",
        "--out",
        out.to_str().unwrap(),
    ]);
    assert_eq!(output.code, 0, "{}", output.errors);
    let output = ripstop(&[
        "run",
        out.join("wing.toml").to_str().unwrap(),
        "--set",
        "structure.wing.mesh.along_chord=16",
        "--set",
        "structure.wing.mesh.across_cell=2",
        "--set",
        "equilibrium.trim.panels_per_side=10",
        "--out",
        run.to_str().unwrap(),
    ]);
    assert_eq!(output.code, 0, "{}{}", output.printed, output.errors);
    let summary = json(&run.join("summary.json"));
    let value = |name: &str| summary["results"][name]["value"].as_f64().unwrap();
    assert!(
        (7.0..15.0).contains(&value("speed_m_s")),
        "{}",
        output.printed
    );
    assert!(
        (3.0..10.0).contains(&value("glide_ratio")),
        "{}",
        output.printed
    );
    assert!(value("riser_balance_error") < 0.01);
}

fn refused() {
    let folder = tempfile::tempdir().unwrap();
    let import = |even: bool, kind: &str, spoil: &dyn Fn(&Path)| {
        let at = folder.path().join(format!("{even}{kind}"));
        put(&at, even, kind);
        spoil(&at);
        let out = at.join("out");
        let file = at.join("leparagliding.txt");
        brought_in(&file, &out)
    };
    let one_skin = import(true, "ss", &|_| ());
    let no_airfoil = import(true, "ds", &|at| {
        std::fs::remove_file(at.join("own.txt")).unwrap()
    });
    let cut_short = import(false, "ds", &|at| {
        let path = at.join("leparagliding.txt");
        let text = std::fs::read_to_string(&path).unwrap();
        let end = text.find("10. BRAKES").unwrap();
        std::fs::write(&path, &text[..end]).unwrap();
    });
    let sheet = folder.path().join("glider.ods");
    std::fs::write(&sheet, "PK").unwrap();
    let openglider = ripstop(&["import", sheet.to_str().unwrap()]);
    let back = |number: usize| {
        let chord = rib(number, true)[1];
        format!("{:.2}", 0.4 * (CHORD_CM - chord) + chord)
    };
    for (output, told) in [
        (one_skin, "only \"ds\""),
        (no_airfoil, "own.txt"),
        (cut_short, "section 10 (brakes)"),
        (openglider, "OpenGlider"),
    ] {
        assert_eq!(output.code, 2, "{}", output.errors);
        assert!(output.errors.contains(told), "{told}: {}", output.errors);
    }
    // Slips of the pen: what stands there, what is written, and what is told.
    let long = format!("{}0", back(3).replace('.', ""));
    let slips = [
        (&back(3)[..], &long[..], "the chord of rib 4 (section 1)"),
        (
            "ribs\n\t24",
            "ribs\n\t33",
            "tells of 33 ribs, but lists 12 of a half: 23 or 24",
        ),
        (
            "\n 4\t",
            "\n 4\t-",
            "rib 4 (section 1) does not lie farther out",
        ),
        ("\n 4\t", "\n 4,\t", "rib 4 has no row in section 1"),
        (
            "3\t1 1\t2 1\t3 1",
            "5\t1 1\t2 1\t3 1",
            "a path of lines has 5 levels",
        ),
        (
            "BRAKES *\n250",
            "BRAKES *\n0",
            "the main line of the brakes, section 10, is not positive",
        ),
        ("\n4\t200\t80", "\n4\t200", "section 11"),
        // Files of one skin hold other things: what they are is told before those.
        ("\"ds\" \t1", "\"ss\" \t1", "only \"ds\""),
    ];
    for (from, to, told) in slips {
        let output = import(true, "ds", &|at| {
            let path = at.join("leparagliding.txt");
            let text = std::fs::read_to_string(&path).unwrap();
            assert!(text.contains(from), "{from}");
            std::fs::write(&path, text.replacen(from, to, 1)).unwrap();
        });
        assert_eq!(output.code, 2, "{told}: {}", output.errors);
        assert!(output.errors.contains(told), "{told}: {}", output.errors);
    }
}

/// A wing of ours as XFLR5 writes it: developed span 4 m, the outer half leaning by 30 degrees, twist and sweep; one profile by its family, one from a file.
fn of_xflr5() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    let file = at("arched.xwimp");
    let text = "Arched wing\n0.0 1.2 0.0 0.0 0.0 13 19 1 0 NACA/_/2412 NACA/_/2412\n\
                1.0 1.0 0.1 30.0 -1.5 13 19 1 0 NACA/_/2412 NACA/_/2412\n\
                2.0 0.5 0.4 30.0 -3.0 13 5 1 -2 thin/_/tip thin/_/tip\n";
    std::fs::write(&file, text).unwrap();
    let out = at("out");
    let arguments = [
        "import",
        file.to_str().unwrap(),
        "--speed",
        "14",
        "--out",
        out.to_str().unwrap(),
    ];
    let missing = ripstop(&arguments);
    assert_eq!(missing.code, 2);
    assert!(
        missing.errors.contains("thin tip.dat"),
        "{}",
        missing.errors
    );
    assert!(!out.exists(), "half an import is left");
    // A symmetric profile of 9 %, from the trailing edge around the nose.
    let mut tip = "tip\n".to_owned();
    for k in -12..=12_i32 {
        let x = (f64::from(k) / 12.0).powi(2);
        let half = 0.45
            * (0.2969 * x.sqrt() - 0.126 * x - 0.3516 * x * x + 0.2843 * x.powi(3)
                - 0.1036 * x.powi(4));
        tip += &format!("{x:.6} {:.6}\n", if k < 0 { half } else { -half });
    }
    std::fs::write(at("thin tip.dat"), tip).unwrap();
    let output = ripstop(&arguments);
    assert_eq!(output.code, 0, "{}", output.errors);
    let path = out.join("wing.toml");
    let case = case::load(&path, &Choices::default()).unwrap();
    let wing = case.scene.bare_wing.unwrap();
    assert_eq!(wing.speed_m_s, 14.0);
    // 2 (1.1 + 0.75) m², and 1 + cos 30° on each side.
    assert!(
        (wing.reference_area_m2 - 3.7).abs() < 1e-5,
        "{}",
        wing.reference_area_m2
    );
    let span = 2.0 * (1.0 + 30f64.to_radians().cos());
    assert!((wing.wing.projected_span_m() - span).abs() < 1e-5);
    let last = &wing.wing.stations[2];
    // Positions are those of the quarter chord, about which XFLR5 twists.
    assert!((last.position_m.x - 0.525).abs() < 1e-9 && (last.position_m.z - 0.5).abs() < 1e-5);
    assert!((last.twist_rad.to_degrees() + 3.0).abs() < 1e-9);
    let broken = at("broken.xwimp");
    std::fs::write(
        &broken,
        "Wing\n0.0 1.0 0.0 0.0 0.0 13 19 1 0 a a\n1.0 1.0 x\n",
    )
    .unwrap();
    let output = ripstop(&["import", broken.to_str().unwrap()]);
    assert_eq!(output.code, 2);
    assert!(output.errors.contains("line 3"), "{}", output.errors);
}
