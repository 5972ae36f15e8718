//! What is read from inputs: each reader as the program uses it, up to where a run would begin. It may refuse an input with a message, and
//! must not panic.

use std::collections::BTreeSet;
use std::fmt::Write;
use std::path::{Path, PathBuf};

use ripstop::case::{self, Case, Choices};
use ripstop::checkpoint;
use ripstop::geometry::line_table;
use ripstop::geometry::profile::Profile;
use ripstop::measure::{self, Record};
use ripstop::plan::{self, Plan, Precision};
use ripstop::simulation::Simulation;
use ripstop::validity;
use tempfile::TempDir;

/// What reads files of a user.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Reader {
    /// Case files.
    Case,
    /// OBJ, STL, PLY and lep-sim files, with the doctor that examines them.
    Mesh,
    /// Coordinates of profiles and tables of lines.
    Profile,
    /// Checkpoints.
    Checkpoint,
}

impl Reader {
    pub const ALL: [Self; 4] = [Self::Case, Self::Mesh, Self::Profile, Self::Checkpoint];

    pub const fn name(self) -> &'static str {
        match self {
            Self::Case => "case",
            Self::Mesh => "mesh",
            Self::Profile => "profile",
            Self::Checkpoint => "checkpoint",
        }
    }

    pub fn named(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|reader| reader.name() == name)
    }
}

const FABRIC: &str = "[fabric]\nthickness_m = 1e-4\ndensity_kg_m3 = 500.0\nyoungs_modulus_pa = 1e8\npoisson_ratio = 0.2\n";

const ACCEPT: &str = "accept = [\"doubled_vertices\", \"doubled_faces\", \"non_manifold_edges\", \"orientation\", \"self_crossing\", \"pieces\", \
                      \"loose_pieces\", \"size\"]\n";

/// A small run whose state checkpoints hold.
struct Small {
    identity: &'static str,
    simulation: Simulation,
    record: Record,
}

/// A reader, and what it needs beside its input.
pub struct Target {
    reader: Reader,
    /// Where inputs are put that are read as files; `in` holds the files that cases name.
    folder: TempDir,
    runs: Vec<Small>,
    /// What has been accepted so far.
    accepted: BTreeSet<&'static str>,
}

impl Target {
    /// A reader; `cases` is the folder of shipped cases.
    pub fn new(reader: Reader, cases: &Path) -> Self {
        let folder = tempfile::tempdir().unwrap();
        let place = folder.path().join("in");
        for (from, to) in [
            (cases.join("bad"), place.clone()),
            (cases.join("meshes"), place.join("meshes")),
            (cases.join("meshes"), folder.path().join("meshes")),
        ] {
            std::fs::create_dir_all(&to).unwrap();
            for file in std::fs::read_dir(from).unwrap().map(Result::unwrap) {
                std::fs::copy(file.path(), to.join(file.file_name())).unwrap();
            }
        }
        let target = Self {
            reader,
            folder,
            runs: if reader == Reader::Checkpoint {
                runs()
            } else {
                Vec::new()
            },
            accepted: BTreeSet::new(),
        };
        target.write_cases();
        target
    }

    fn place(&self) -> PathBuf {
        self.folder.path().join("in")
    }

    /// Cases that name the files of inputs.
    fn write_cases(&self) {
        let write = |name: &str, text: &str| std::fs::write(self.place().join(name), text).unwrap();
        for format in ["obj", "stl", "ply"] {
            let file = format!("file = \"mesh.{format}\"\nscale = 1.0\n{ACCEPT}");
            let weld = if format == "obj" {
                ""
            } else {
                "weld_tolerance_m = 1e-3\n"
            };
            write(
                &format!("{format}-fabric.toml"),
                &format!(
                    "version = 1\n[structure.mesh]\n{file}{weld}held_nodes = [1]\n{FABRIC}[time]\nend_s = 0.05\nstep_s = 1e-3\n"
                ),
            );
            write(
                &format!("{format}-body.toml"),
                &format!(
                    "version = 1\n[air]\ndensity_kg_m3 = 1.2\nkinematic_viscosity_m2_s = 0.01\n[air.wind_tunnel]\nspeed_m_s = 5.0\n\
                     size_m = [4.0, 4.0, 4.0]\nstart_time_s = 0.01\n[resolution]\ncell_size_m = 0.1\nlattice_speed = 0.05\n\
                     operator = \"recursive_regularised\"\n[coupling]\nover_relaxation = 1.0\n[bodies.one]\nposition_m = [2.0, 2.0, 2.0]\nreference.area_m2 = 1.0\nreference.length_m = 1.0\n[bodies.one.mesh]\n{file}[time]\nend_s = 0.1\n"
                ),
            );
        }
        write(
            "lep-sim.toml",
            &format!(
                "version = 1\n[structure.lep_sim]\nfile = \"lep-sim.json\"\n[structure.lep_sim.line_material]\narea_m2 = 1e-6\ndensity_kg_m3 = 1000.0\n\
                 youngs_modulus_pa = 2e10\n{FABRIC}[equilibrium]\npressure_pa = 50.0\ntolerance = 1e-2\nevaluation_limit = 100\n"
            ),
        );
        let lines = "held_nodes = []\nlines = \"lines.csv\"\n[structure.mesh.line_material]\narea_m2 = 1e-6\ndensity_kg_m3 = 1000.0\nyoungs_modulus_pa = 2e10\n";
        write(
            "lines.toml",
            &format!(
                "version = 1\n[structure.mesh]\nfile = \"small-sheet.obj\"\nscale = 1.0\n{ACCEPT}{lines}{FABRIC}[time]\nend_s = 0.05\nstep_s = 1e-3\n"
            ),
        );
        let wing = std::fs::read_to_string(self.place().join("wing-profile-line.toml")).unwrap();
        write(
            "profile.toml",
            &wing.replace("wing-profile-line.dat", "profile.dat"),
        );
    }

    /// What nothing has been accepted of so far, though seeds hold good ones of each: the reader would not be tried in depth.
    pub fn never_accepted(&self) -> Vec<&'static str> {
        let all = ways(self.reader).iter();
        all.copied()
            .filter(|way| !self.accepted.contains(way))
            .collect()
    }

    /// Reads one input.
    pub fn read(&mut self, input: &[u8]) {
        match self.reader {
            Reader::Case => self.case(input),
            Reader::Mesh => self.mesh(input),
            Reader::Profile => self.profile(input),
            Reader::Checkpoint => self.checkpoint(input),
        }
    }

    /// The case and its first two variants.
    fn case(&mut self, input: &[u8]) {
        // The file could not be read as text.
        let Ok(text) = std::str::from_utf8(input) else {
            return;
        };
        let variants = text.lines().filter_map(|line| {
            let name = line.trim().strip_prefix("[variants.")?;
            name.split(['.', ']']).next().map(str::to_owned)
        });
        for variant in std::iter::once(None).chain(variants.map(Some)).take(3) {
            let choices = Choices {
                variant,
                overrides: Vec::new(),
            };
            if told(case::parse("case.toml", text, &self.place(), &choices)) {
                self.accepted.insert("case");
            }
        }
    }

    fn load(&mut self, name: &'static str) {
        let path = self.place().join(format!("{name}.toml"));
        let choices = Choices::default();
        if told(case::load(&path, &choices)) {
            self.accepted.insert(name);
        } else if let Ok(meshes) = case::examine_meshes(&path, &choices) {
            // What `ripstop check` tells of a mesh that is refused.
            let _ = plan::mesh_report(&meshes);
        }
    }

    fn put(&self, name: &str, input: &[u8]) {
        std::fs::write(self.place().join(name), input).unwrap();
    }

    /// The input as every kind of mesh, as fabric and as a body.
    fn mesh(&mut self, input: &[u8]) {
        if input.trim_ascii_start().starts_with(b"{") {
            self.put("lep-sim.json", input);
            return self.load("lep-sim");
        }
        for (format, ways) in [
            ("obj", ["obj-fabric", "obj-body"]),
            ("stl", ["stl-fabric", "stl-body"]),
            ("ply", ["ply-fabric", "ply-body"]),
        ] {
            self.put(&format!("mesh.{format}"), input);
            ways.into_iter().for_each(|way| self.load(way));
        }
    }

    /// The input as coordinates of a profile, alone and on a wing, and as a table of lines.
    fn profile(&mut self, input: &[u8]) {
        if let Ok(text) = std::str::from_utf8(input) {
            if let Ok(profile) = Profile::parse(text) {
                let _ = (profile.resampled(50), profile.thickness());
                let _ = profile.camber(&[0.0, 0.25, 0.5, 1.0]);
                self.put("profile.dat", input);
                self.load("profile");
            }
            let _ = Profile::naca(text.lines().next().unwrap_or_default());
            if line_table::parse(text).is_ok() {
                self.put("lines.csv", input);
                self.load("lines");
            }
        }
    }

    /// The input as the checkpoint of each small run.
    fn checkpoint(&mut self, input: &[u8]) {
        self.put(checkpoint::FILE_NAME, input);
        let folder = self.place();
        for run in &mut self.runs {
            match checkpoint::open(&folder, run.identity) {
                Ok(found) => {
                    let restored = run.simulation.restore(&found.reader);
                    let restored =
                        restored.and_then(|()| run.record.restore(&found.reader, &folder));
                    match restored {
                        Ok(()) => {
                            self.accepted.insert(run.identity);
                            let _ = (run.simulation.time_s(), run.simulation.wind_speed_m_s());
                            let _ = run.simulation.structure_frame();
                            let _ = run.record.history_rows().count();
                        }
                        Err(error) => assert!(!error.to_string().is_empty()),
                    }
                }
                Err(error) => assert!(!error.to_string().is_empty()),
            }
        }
    }
}

/// Everything that a good input of a reader passes through.
const fn ways(reader: Reader) -> &'static [&'static str] {
    match reader {
        Reader::Case => &["case"],
        Reader::Mesh => &[
            "obj-fabric",
            "obj-body",
            "stl-fabric",
            "stl-body",
            "ply-fabric",
            "ply-body",
            "lep-sim",
        ],
        Reader::Profile => &["profile", "lines"],
        Reader::Checkpoint => &["sheet", "canopy"],
    }
}

/// What `ripstop check` does with a case that was read, or tells of one that was not; true if it was.
fn told(read: Result<Case, Box<case::CaseError>>) -> bool {
    let case = match read {
        Ok(case) => case,
        Err(error) => {
            assert!(
                !error.to_string().trim().is_empty(),
                "an error without a message"
            );
            let mut text = String::new();
            write!(text, "{:?}", miette::Report::new(*error)).unwrap();
            return false;
        }
    };
    let plan = Plan::new(&case.scene, Precision::F32);
    if plan.sizes.fit_into(None).is_err() {
        return true;
    }
    let _ = plan.report(&case.scene, &case.coarser, 1);
    let _ = measure::averaging(&case.scene);
    let _ = measure::result_names(&case.scene);
    let _ = validity::beforehand(&case.scene, &plan);
    let _ = validity::expected_errors(&case.scene);
    true
}

/// Runs as small as they can be: fabric that touches itself in steps of various lengths, and a canopy in air.
fn runs() -> Vec<Small> {
    let sheet = [
        "structure.sheet.divisions=[4, 4]",
        "time.step_s=0.01",
        "time.adaptive.tolerance_m=1e-3",
        "time.adaptive.smallest_step_s=1e-3",
        "contact.thickness_m=2e-3",
    ];
    let canopy = [
        "resolution.cells_per_diameter=6.0",
        "air.wind_tunnel.size_m=[2.0, 1.994, 1.994]",
        "air.wind_tunnel.sponge_length_m=0.2",
        "structure.flat_circular.confluence_m=[0.2, 0.997, 0.997]",
        "structure.flat_circular.rings=4",
    ];
    [
        ("sheet", "hanging-sheet", &sheet[..]),
        ("canopy", "flat-circular-tunnel", &canopy),
    ]
    .into_iter()
    .map(|(identity, shipped, overrides)| {
        let shipped = case::SHIPPED.iter().find(|(name, _)| *name == shipped);
        let choices = Choices {
            variant: None,
            overrides: overrides.iter().map(|o| (*o).to_owned()).collect(),
        };
        let case = case::parse(identity, shipped.unwrap().1, Path::new("."), &choices);
        let case = case.unwrap_or_else(|error| panic!("{identity}: {error}"));
        let plan = Plan::new(&case.scene, Precision::F32);
        let mut simulation = Simulation::new(case.scene, plan, None).unwrap();
        let mut record = Record::new(&simulation);
        for _ in 0..3 {
            simulation.advance().unwrap();
        }
        record.add(&mut simulation).unwrap();
        Small {
            identity,
            simulation,
            record,
        }
    })
    .collect()
}

/// Checkpoints of the small runs.
fn checkpoints() -> Vec<Vec<u8>> {
    let folder = tempfile::tempdir().unwrap();
    let written = runs().into_iter().map(|mut run| {
        checkpoint::write(folder.path(), run.identity, |out| {
            run.simulation.save(out)?;
            run.record.save(out)
        })
        .unwrap();
        std::fs::read(folder.path().join(checkpoint::FILE_NAME)).unwrap()
    });
    written.collect()
}

/// From now on an allocation that needs more than `more` bytes beyond what is taken aborts; where the system has no such limit, nothing happens.
pub fn limit_memory(more: u64) {
    // Threads have their stacks before.
    rayon::broadcast(|_| ());
    #[cfg(target_os = "linux")]
    {
        let status = std::fs::read_to_string("/proc/self/status").unwrap();
        let line = status.lines().find_map(|line| line.strip_prefix("VmData:"));
        let taken: u64 = line
            .unwrap()
            .trim()
            .trim_end_matches(" kB")
            .parse()
            .unwrap();
        let limit = (taken << 10) + more;
        rlimit::Resource::DATA.set(limit, limit).unwrap();
        rlimit::Resource::CORE.set(0, 0).unwrap();
    }
}

/// Files under `folder` whose names end in one of `endings`, in order.
pub fn files(folder: &Path, endings: &[&str]) -> Vec<PathBuf> {
    let Ok(entries) = std::fs::read_dir(folder) else {
        return Vec::new();
    };
    let mut found: Vec<PathBuf> = Vec::new();
    for path in entries.map(|entry| entry.unwrap().path()) {
        if path.is_dir() {
            found.extend(files(&path, endings));
        } else if endings
            .iter()
            .any(|end| path.to_string_lossy().ends_with(end))
        {
            found.push(path);
        }
    }
    found.sort();
    found
}

/// What inputs are made from: what is shipped with the program, and a few small files of formats that are not.
pub fn seeds(reader: Reader, cases: &Path) -> Vec<Vec<u8>> {
    let read = |endings: &[&str]| -> Vec<Vec<u8>> {
        let files = files(cases, endings);
        files
            .iter()
            .map(|path| std::fs::read(path).unwrap())
            .collect()
    };
    let mut seeds = match reader {
        Reader::Case => read(&[".toml"]),
        Reader::Mesh => read(&[".obj", ".ply", ".stl", "lep-sim.json"]),
        Reader::Profile => read(&[".dat", ".csv"]),
        Reader::Checkpoint => checkpoints(),
    };
    if reader == Reader::Mesh {
        seeds.extend([ascii_stl(), binary_stl(), binary_ply(), lep_sim()]);
    }
    if reader == Reader::Profile {
        let naca = Profile::naca("2412").unwrap().resampled(12);
        let points = naca
            .iter()
            .rev()
            .map(|p| format!("{:.5} {:.5}\n", p.x, p.y));
        seeds.push(format!("NACA 2412\n{}", points.collect::<String>()).into_bytes());
        seeds.push(b"23015\n".to_vec());
        seeds.push(
            b"x_m,y_m,z_m,end_x_m,end_y_m,end_z_m,length_m\n0,0,0,0,0,-1,1\n0,1,0,0,0,-1,\n"
                .to_vec(),
        );
    }
    assert!(!seeds.is_empty(), "no seeds for {}", reader.name());
    seeds
}

const CORNERS: [[f32; 3]; 4] = [
    [0.0, 0.0, 0.0],
    [1.0, 0.0, 0.0],
    [0.0, 1.0, 0.0],
    [0.0, 0.0, 1.0],
];

const FACES: [[u8; 3]; 4] = [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]];

fn ascii_stl() -> Vec<u8> {
    let mut text = "solid body\n".to_owned();
    for face in FACES {
        text += "facet normal 0 0 0\nouter loop\n";
        for [x, y, z] in face.map(|corner| CORNERS[usize::from(corner)]) {
            writeln!(text, "vertex {x} {y} {z}").unwrap();
        }
        text += "endloop\nendfacet\n";
    }
    (text + "endsolid body\n").into_bytes()
}

fn binary_stl() -> Vec<u8> {
    let mut bytes = vec![b' '; 80];
    bytes.extend((FACES.len() as u32).to_le_bytes());
    for face in FACES {
        bytes.extend([0; 12]);
        for corner in face {
            bytes.extend(
                CORNERS[usize::from(corner)]
                    .iter()
                    .flat_map(|x| x.to_le_bytes()),
            );
        }
        bytes.extend([0; 2]);
    }
    bytes
}

fn binary_ply() -> Vec<u8> {
    let mut bytes = b"ply\nformat binary_little_endian 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n\
                      element face 4\nproperty list uchar int vertex_indices\nend_header\n"
        .to_vec();
    bytes.extend(CORNERS.iter().flatten().flat_map(|x| x.to_le_bytes()));
    for face in FACES {
        bytes.push(3);
        bytes.extend(
            face.iter()
                .flat_map(|corner| u32::from(*corner).to_le_bytes()),
        );
    }
    bytes
}

/// Two ribs of six points with skin between them, a hole, a strap and lines.
fn lep_sim() -> Vec<u8> {
    let outline = [
        [900.0, 0.0],
        [500.0, -40.0],
        [100.0, -40.0],
        [0.0, 0.0],
        [100.0, 80.0],
        [500.0, 60.0],
    ];
    let mut nodes = Vec::new();
    for x in [-300.0, 300.0] {
        nodes.extend(outline.map(|[y, z]| format!("[{x:?}, {y:?}, {z:?}]")));
    }
    let quads = (0..6).map(|k| format!("[{k}, {}, {}, {}]", (k + 1) % 6, (k + 1) % 6 + 6, k + 6));
    format!(
        "{{\"version\": 1, \"unit\": \"mm\", \"nodes\": [{}], \"quads\": [{}], \"quadSurfaces\": [2, 2, 1, 0, 0, 0], \
         \"ribLoops\": [[0, 1, 2, 3, 4, 5], [6, 7, 8, 9, 10, 11]], \
         \"ribHoles\": [[[[-300.0, 300.0, 0.0], [-300.0, 400.0, 0.0], [-300.0, 350.0, 30.0]]], []], \
         \"straps\": [{{\"a\": [[-300.0, 500.0, 60.0], [300.0, 500.0, 60.0]], \"b\": [[-300.0, 500.0, -40.0], [300.0, 500.0, -40.0]]}}], \
         \"lines\": [{{\"a\": [-300.0, 100.0, -40.0], \"b\": [0.0, 200.0, -2000.0], \"plan\": 1}}, \
         {{\"a\": [300.0, 100.0, -40.0], \"b\": [0.0, 200.0, -2000.0], \"plan\": 2, \"brake\": 1}}]}}",
        nodes.join(", "),
        quads.collect::<Vec<_>>().join(", ")
    )
    .into_bytes()
}
