//! Case files: TOML text → [`file::File`] (what is written) → [`scene::Scene`] (checked, SI, absent = `None`).

mod air;
mod bodies;
mod canopy;
mod comparison;
mod contact;
mod descent;
pub mod file;
mod file_bodies;
mod file_canopy;
mod file_comparison;
mod file_descent;
mod file_permeability;
mod file_plate;
mod file_specimens;
mod file_supports;
mod file_trim;
mod file_wing;
mod file_wing_design;
mod grid_sequence;
mod identity;
pub mod lep_sim;
pub mod locate;
mod mesh;
pub mod mesh_examination;
mod mesh_lines;
mod motion;
mod output;
mod payload_bodies;
mod permeability;
mod plate;
mod rigging;
mod rims;
pub mod scene;
mod shift;
mod specimens;
pub mod steady;
mod structure;
mod supports;
mod time;
mod trim;
mod usual;
mod values;
pub mod wing;
pub mod wing_design;
mod wing_lines;
mod wing_tunnel;

use std::path::Path;

use miette::{Diagnostic, NamedSource, SourceSpan};

pub use identity::{changed_outputs, changed_physics, number_in};
pub use mesh_examination::ExaminedMesh;
pub use scene::Scene;
pub use usual::Resolved;

use file::File;

/// Shipped cases, embedded so that an installed binary can print them: name, text.
pub const SHIPPED: [(&str, &str); 20] = [
    ("airbag", include_str!("../../cases/cloth/airbag.toml")),
    (
        "bias-extension",
        include_str!("../../cases/cloth/bias-extension.toml"),
    ),
    (
        "disk-gap-band",
        include_str!("../../cases/disk-gap-band.toml"),
    ),
    (
        "finite-mass-drop",
        include_str!("../../cases/finite-mass-drop.toml"),
    ),
    (
        "hemispherical-mesh",
        include_str!("../../cases/hemispherical-mesh.toml"),
    ),
    (
        "hencky-disc",
        include_str!("../../cases/cloth/hencky-disc.toml"),
    ),
    (
        "flat-circular-tunnel",
        include_str!("../../cases/flat-circular-tunnel.toml"),
    ),
    ("flag", include_str!("../../cases/flag.toml")),
    (
        "flexible-plate",
        include_str!("../../cases/flexible-plate.toml"),
    ),
    (
        "folded-gore",
        include_str!("../../cases/cloth/folded-gore.toml"),
    ),
    (
        "hanging-sheet",
        include_str!("../../cases/cloth/hanging-sheet.toml"),
    ),
    (
        "hanging-chain",
        include_str!("../../cases/cloth/hanging-chain.toml"),
    ),
    (
        "parafoil-brake",
        include_str!("../../cases/parafoil-brake.toml"),
    ),
    (
        "ram-air-parachute",
        include_str!("../../cases/ram-air-parachute.toml"),
    ),
    (
        "shaken-rope",
        include_str!("../../cases/cloth/shaken-rope.toml"),
    ),
    (
        "slotted-drop",
        include_str!("../../cases/slotted-drop.toml"),
    ),
    ("sphere", include_str!("../../cases/sphere.toml")),
    (
        "taylor-green",
        include_str!("../../cases/taylor-green.toml"),
    ),
    ("wing-27", include_str!("../../cases/wing-27.toml")),
    ("wing-school", include_str!("../../cases/wing-school.toml")),
];

/// Files that shipped cases name: the case, the path beside it, the text.
pub const SHIPPED_FILES: [(&str, &str, &str); 2] = [
    (
        "hemispherical-mesh",
        "meshes/hemisphere.obj",
        include_str!("../../cases/meshes/hemisphere.obj"),
    ),
    (
        "hemispherical-mesh",
        "meshes/hemisphere-lines.csv",
        include_str!("../../cases/meshes/hemisphere-lines.csv"),
    ),
];

/// What is wrong with a case, where, and what to do.
#[derive(Debug, thiserror::Error, Diagnostic)]
#[error("{message}")]
pub struct CaseError {
    message: String,
    #[help]
    help: Option<String>,
    #[source_code]
    source_code: Option<NamedSource<String>>,
    #[label("{label}")]
    span: Option<SourceSpan>,
    label: String,
}

impl CaseError {
    /// An error about a whole file.
    pub(crate) fn about_file(message: String, help: &str) -> Box<Self> {
        Box::new(Self {
            message,
            help: Some(help.to_owned()),
            source_code: None,
            span: None,
            label: String::new(),
        })
    }

    fn located(
        name: &str,
        source: &str,
        span: Option<std::ops::Range<usize>>,
        label: &str,
        problem: Problem,
    ) -> Box<Self> {
        Box::new(Self {
            message: problem.message,
            help: Some(problem.help),
            source_code: Some(NamedSource::new(name, source.to_owned())),
            span: span.map(Into::into),
            label: label.to_owned(),
        })
    }
}

/// A finding about one key, before it is located in the file.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Problem {
    /// Dotted path of the key.
    pub key: String,
    /// What is wrong, with the value.
    pub message: String,
    /// What is allowed and what to do.
    pub help: String,
}

impl Problem {
    /// A finding about `key`.
    pub fn new(
        key: impl Into<String>,
        message: impl Into<String>,
        help: impl Into<String>,
    ) -> Self {
        Self {
            key: key.into(),
            message: message.into(),
            help: help.into(),
        }
    }
}

/// What was asked for on the command line.
#[derive(Debug, Clone, Default)]
pub struct Choices {
    /// Name of a variant in the file.
    pub variant: Option<String>,
    /// `key.path=value` overrides.
    pub overrides: Vec<String>,
}

/// A checked case with the text it came from.
#[derive(Debug, Clone)]
pub struct Case {
    /// File name as given.
    pub name: String,
    /// CRC-32, in hexadecimal, of the text with variant and overrides applied and of the files that it names.
    pub hash: String,
    /// The same of what acts on the state alone: without title, length, outputs and comparisons.
    pub physics: String,
    /// The case as it is run, with variant and overrides applied.
    pub text: String,
    /// Variant taken, if any.
    pub variant: Option<String>,
    /// Overrides applied.
    pub overrides: Vec<String>,
    /// What it has for keys that it leaves out, and what follows from others for time step, cells and box.
    pub resolved: Resolved,
    /// The checked scene.
    pub scene: Scene,
    /// The same scene on the coarser grids that a run begins on, coarsest first; empty without `steady.grid_sequence`.
    pub coarser: Vec<Scene>,
    source: String,
}

impl Case {
    /// An error about one key of this case, marked in its text.
    #[must_use]
    pub fn error(&self, problem: Problem) -> Box<CaseError> {
        let span = locate::span_of(&self.source, &problem.key);
        let label = problem.key.clone();
        CaseError::located(&self.name, &self.source, span, &label, problem)
    }
}

/// Reads and checks a case file.
pub fn load(path: &Path, choices: &Choices) -> Result<Case, Box<CaseError>> {
    let (name, source) = read(path)?;
    parse(&name, &source, folder_of(path), choices)
}

/// Reads and examines the meshes of a case file, whether they would be refused or not.
pub fn examine_meshes(path: &Path, choices: &Choices) -> Result<Vec<ExaminedMesh>, Box<CaseError>> {
    let (name, source) = read(path)?;
    let folder = folder_of(path);
    let (_, _, _, meshes) = checked(&name, &source, choices, |file| {
        let mut meshes = Vec::new();
        if let Some(written) = file.structure.as_ref().and_then(|s| s.mesh.as_ref()) {
            meshes.push(mesh::examine(file, written, folder)?.examined);
        }
        let cell_size_m = file.resolution.as_ref().and_then(|r| r.cell_size_m);
        for (body, table) in &file.bodies {
            if let Some(written) = &table.mesh {
                let key = format!("bodies.{body}.mesh");
                meshes.push(bodies::read_mesh(&key, written, folder, cell_size_m)?.1);
            }
        }
        Ok(meshes)
    })?;
    Ok(meshes)
}

/// Name and text of a case file.
fn read(path: &Path) -> Result<(String, String), Box<CaseError>> {
    let name = path.display().to_string();
    let source = std::fs::read_to_string(path).map_err(|error| {
        CaseError::about_file(
            format!("cannot read the case file {name}: {error}"),
            "give the path of a TOML case file; `ripstop new flat-circular-tunnel > case.toml` writes one to start from",
        )
    })?;
    Ok((name, source))
}

fn folder_of(path: &Path) -> &Path {
    path.parent().unwrap_or_else(|| Path::new("."))
}

/// Checks the text of a case; mesh files are looked up relative to `folder`.
pub fn parse(
    name: &str,
    source: &str,
    folder: &Path,
    choices: &Choices,
) -> Result<Case, Box<CaseError>> {
    let (text, physics, file, (scene, resolved, coarser)) =
        checked(name, source, choices, |file| {
            let (scene, resolved) = usual::collected(|| scene::check(file, folder));
            let scene = scene?;
            let coarser = grid_sequence::check(file, &scene, folder)?;
            Ok((scene, resolved, coarser))
        })?;
    Ok(Case {
        name: name.to_owned(),
        hash: identity::hash(&text, &file, folder),
        physics: identity::hash(&physics, &file, folder),
        text,
        variant: choices.variant.clone(),
        overrides: choices.overrides.clone(),
        resolved,
        scene,
        coarser,
        source: source.to_owned(),
    })
}

/// Reads the text of a case with variant and overrides applied, and checks it; what is wrong is marked in the text. Returns the text as
/// applied, the physics of it alone, what is written in it, and what the check returned.
fn checked<T>(
    name: &str,
    source: &str,
    choices: &Choices,
    check: impl FnOnce(&File) -> Result<T, Problem>,
) -> Result<(String, String, File, T), Box<CaseError>> {
    let mut table: toml::Table = toml::from_str(source).map_err(|error| {
        let problem = Problem::new(
            "",
            format!("{name} is not valid TOML: {}", error.message()),
            "correct the marked place",
        );
        CaseError::located(name, source, error.span(), "here", problem)
    })?;
    let mut prefix = None;
    if let Some(variant) = &choices.variant {
        let known: Vec<String> = table
            .get("variants")
            .and_then(|v| v.as_table())
            .map(|v| v.keys().cloned().collect())
            .unwrap_or_default();
        let changes = table
            .get("variants")
            .and_then(|v| v.get(variant))
            .and_then(|v| v.as_table())
            .cloned();
        let Some(changes) = changes else {
            let names = if known.is_empty() {
                "none".to_owned()
            } else {
                known.join(", ")
            };
            return Err(CaseError::about_file(
                format!("{name} has no variant `{variant}`"),
                &format!(
                    "variants in this file: {names}; leave --variant out to run the case as written"
                ),
            ));
        };
        merge(&mut table, changes);
        prefix = Some(format!("variants.{variant}."));
    }
    for change in &choices.overrides {
        apply_override(&mut table, change)?;
    }
    let locate = |problem: Problem| {
        let in_variant = prefix.as_ref().and_then(|prefix| {
            let path = format!("{prefix}{}", problem.key);
            let exists = lookup(&toml::from_str(source).ok()?, &path).is_some();
            exists.then(|| locate::span_of(source, &path)).flatten()
        });
        let within = |inner: &str, outer: &str| {
            inner
                .strip_prefix(outer)
                .is_some_and(|rest| rest.is_empty() || rest.starts_with('.'))
        };
        let overriding = choices.overrides.iter().find(|change| {
            let key = change.split('=').next().unwrap_or_default().trim();
            within(key, &problem.key) || within(&problem.key, key)
        });
        if let Some(change) = overriding {
            // What is wrong does not stand in the file.
            let message = format!("{} (from --set {change})", problem.message);
            return CaseError::about_file(message, &problem.help);
        }
        let nearest = ["structure", "air", "version"];
        let span = in_variant
            .or_else(|| locate::span_of(source, &problem.key))
            .or_else(|| nearest.iter().find_map(|key| locate::span_of(source, key)));
        let label = problem.key.clone();
        CaseError::located(name, source, span, &label, problem)
    };
    let text = toml::to_string(&table).unwrap_or_default();
    let physics = toml::to_string(&identity::physics(&table)).unwrap_or_default();
    let file: File = serde_path_to_error::deserialize(table).map_err(|error| {
        let path = error.path().to_string();
        let message = plain_words(error.inner().message());
        // An unknown key is reported at its table; add the key itself to mark its line.
        let unknown = message
            .strip_prefix("unknown field `")
            .and_then(|rest| rest.split('`').next());
        let key = match unknown {
            Some(field) if path == "." => field.to_owned(),
            Some(field) if !path.ends_with(field) => format!("{path}.{field}"),
            _ => path,
        };
        let help = if unknown.is_some() {
            "correct the key, or remove it; keys carry their unit, e.g. `speed_m_s`"
        } else {
            "docs/case-files.md lists all keys; `ripstop new flat-circular-tunnel` prints a complete case"
        };
        locate(Problem::new(key, format!("in {name}: {message}"), help))
    })?;
    let in_file = |problem: Problem| {
        let message = format!("in {name}: {}", problem.message);
        locate(Problem { message, ..problem })
    };
    let result = check(&file).map_err(in_file)?;
    Ok((text, physics, file, result))
}

/// Names of Rust types mean nothing to the author of a case.
fn plain_words(message: &str) -> String {
    message
        .replace("expected f64", "expected a number")
        .replace("expected u32", "expected a whole number")
        .replace("expected usize", "expected a whole number")
}

fn lookup<'a>(table: &'a toml::Table, path: &str) -> Option<&'a toml::Value> {
    let (first, rest) = path
        .split_once('.')
        .map_or((path, None), |(first, rest)| (first, Some(rest)));
    let value = table.get(first)?;
    match rest {
        None => Some(value),
        Some(rest) => lookup(value.as_table()?, rest),
    }
}

/// Overwrites `base` with `changes`, table by table; what is "absent" in `changes` is removed.
fn merge(base: &mut toml::Table, changes: toml::Table) {
    for (key, change) in changes {
        match (base.get_mut(&key), change) {
            (Some(toml::Value::Table(inner)), toml::Value::Table(change)) => merge(inner, change),
            (_, toml::Value::String(text)) if text == ABSENT => {
                base.remove(&key);
            }
            (_, change) => {
                base.insert(key, change);
            }
        }
    }
}

/// Value of an override or in a variant that removes the key or table from the case.
pub const ABSENT: &str = "absent";

/// Applies one `key.path=value`.
fn apply_override(table: &mut toml::Table, change: &str) -> Result<(), Box<CaseError>> {
    let refuse = |why: &str| {
        CaseError::about_file(
            format!("--set {change}: {why}"),
            "write --set key.path=value, e.g. --set air.wind_tunnel.speed_m_s=20",
        )
    };
    let (path, text) = change
        .split_once('=')
        .ok_or_else(|| refuse("there is no `=`"))?;
    let value = match toml::from_str::<toml::Table>(&format!("value = {text}")) {
        Ok(parsed) if parsed.len() != 1 => return Err(refuse("give one value")),
        Ok(mut parsed) => parsed
            .remove("value")
            .ok_or_else(|| refuse("there is no value"))?,
        // Bare words are strings.
        Err(_) => toml::Value::String(text.trim().to_owned()),
    };
    let mut parts: Vec<&str> = path.trim().split('.').collect();
    let last = parts
        .pop()
        .filter(|part| !part.is_empty())
        .ok_or_else(|| refuse("there is no key"))?;
    let mut target = table;
    for part in parts {
        let entry = target
            .entry(part)
            .or_insert_with(|| toml::Value::Table(toml::Table::new()));
        target = entry
            .as_table_mut()
            .ok_or_else(|| refuse(&format!("`{part}` is not a table")))?;
    }
    if text.trim() == ABSENT {
        return match target.remove(last) {
            Some(_) => Ok(()),
            None => Err(refuse("the case has no such key to remove")),
        };
    }
    target.insert(last.to_owned(), value);
    Ok(())
}
