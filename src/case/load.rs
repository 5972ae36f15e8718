//! From the text of a case to the checked one: variant and overrides applied, what is wrong marked in the text.

use std::path::Path;

use serde::de::DeserializeOwned;

use super::design::{self, Derived, Designed};
use super::error::CaseError;
use super::file::{File, Structure};
use super::mesh_examination::ExaminedMesh;
use super::near::{did_you_mean, nearest};
use super::problem::Problem;
use super::scene::{self, Scene};
use super::text::{absent_paths, apply_override, lookup, merge};
use super::usual::{self, Resolved};
use super::values::all_told;
use super::{bodies, grid_sequence, identity, locate, mesh, schema};

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
    /// The same without title, length, outputs and comparisons.
    pub physics_text: String,
    /// Variant taken, if any.
    pub variant: Option<String>,
    /// Overrides applied.
    pub overrides: Vec<String>,
    /// What it has for keys that it leaves out, and what follows from others for time step, cells and box.
    pub resolved: Resolved,
    /// What follows from its design, and is in its text; empty where it has none.
    pub derived: Vec<Derived>,
    /// The checked scene.
    pub scene: Scene,
    /// The same scene on the coarser grids that a run begins on, coarsest first; empty without `steady.grid_sequence`.
    pub coarser: Vec<Scene>,
    source: String,
}

impl Case {
    /// Overrides that act on the state.
    pub fn physical_overrides(&self) -> impl Iterator<Item = &str> {
        let overrides = self.overrides.iter().map(String::as_str);
        overrides.filter(|change| identity::acts_on_state(change))
    }

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
    let (_, meshes) = checked((&name, &source), folder, choices, |file| {
        let mut meshes = Vec::new();
        if let Some(Structure::Mesh(written)) = &file.structure {
            for read in mesh::examine_all(file, written, folder)? {
                meshes.push(read.examined);
            }
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
    let (applied, (scene, resolved, coarser)) = checked((name, source), folder, choices, |file| {
        let (scene, resolved) = usual::collected(|| scene::check(file, folder));
        let scene = scene?;
        let coarser = grid_sequence::check(file, &scene, folder)?;
        Ok((scene, resolved, coarser))
    })?;
    let file = &applied.file;
    Ok(Case {
        name: name.to_owned(),
        hash: identity::hash(&applied.text, file, folder),
        physics: identity::hash(&applied.physics, file, folder),
        physics_text: applied.physics,
        text: applied.text,
        derived: applied.derived,
        variant: choices.variant.clone(),
        overrides: applied.overrides,
        resolved,
        scene,
        coarser,
        source: source.to_owned(),
    })
}

/// A case with variant and overrides applied, and with what follows from its design.
struct Applied {
    text: String,
    /// The physics of the text alone.
    physics: String,
    derived: Vec<Derived>,
    /// As the command line gave them, each for the design that the case has.
    overrides: Vec<String>,
    file: File,
}

/// Reads the text of a case with variant and overrides applied, and checks it; what is wrong is marked in the text.
fn checked<T>(
    (name, source): (&str, &str),
    folder: &Path,
    choices: &Choices,
    check: impl FnOnce(&File) -> Result<T, Problem>,
) -> Result<(Applied, T), Box<CaseError>> {
    let mut table: toml::Table = toml::from_str(source).map_err(|error| {
        let at = error.span().map_or(0, |span| span.start);
        let comma = source.get(..at).is_some_and(|before| before.ends_with(','))
            || source.get(at..).is_some_and(|rest| rest.starts_with(','));
        let problem = Problem::new(
            "",
            format!("{name} is not valid TOML: {}", error.message()),
            if comma {
                "correct the marked place; numbers have a decimal point: 6.5, not 6,5"
            } else {
                "correct the marked place"
            },
        );
        CaseError::located(name, source, error.span(), "here", problem)
    })?;
    // What is absent from a design must not follow from it either.
    let design = design::table_of(&table);
    let is_design = design.is_some();
    let mut prefix = None;
    let mut absent = Vec::new();
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
                    "{}variants in this file: {names}; leave --variant out to run the case as written",
                    did_you_mean(variant, known.iter().map(String::as_str))
                ),
            ));
        };
        absent = absent_paths(&changes);
        merge(&mut table, changes, is_design);
        prefix = Some(format!("variants.{variant}."));
    }
    let mut overrides = Vec::new();
    for change in &choices.overrides {
        let change = of_design(change, design).map_err(|of| {
            CaseError::about_file(
                format!("{change} needs {of}, which {name} does not have"),
                "set keys of the tables that the case has, such as resolution.cells_per_diameter",
            )
        })?;
        apply_override(&mut table, &change, is_design)?;
        overrides.push(change);
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
        let overriding = overrides.iter().rev().find(|change| {
            let key = change.split('=').next().unwrap_or_default().trim();
            within(key, &problem.key) || within(&problem.key, key)
        });
        if let Some(change) = overriding {
            // What is wrong does not stand in the file.
            let message = format!("{} (from --set {change})", problem.message);
            return CaseError::about_file(message, &problem.help);
        }
        let nearest = design::TABLES
            .into_iter()
            .chain(["structure", "air", "version"]);
        let span = in_variant
            .or_else(|| locate::span_of(source, &problem.key))
            .or_else(|| {
                nearest
                    .into_iter()
                    .find_map(|key| locate::span_of(source, key))
            });
        let label = problem.key.clone();
        CaseError::located(name, source, span, &label, problem)
    };
    let in_file = |problem: Problem| {
        let message = format!("in {name}: {}", problem.message);
        locate(Problem { message, ..problem })
    };
    // Of a case that is no design nothing is left that says so.
    let unknown = |path: &Vec<String>| {
        let is_of_a_variant = path.len() > 2 && path[0] == "variants";
        !schema::knows(&path[if is_of_a_variant { 2 } else { 0 }..])
    };
    let mut all = absent.into_iter().chain(absent_paths(&table));
    if let Some(path) = all.find(unknown) {
        let path = path.join(".");
        return Err(in_file(Problem::new(
            path.as_str(),
            format!("{path} is to be absent, but there is no such key"),
            "correct the key, or leave it out (docs/case-files.md lists all keys)",
        )));
    }
    let several = |(mut first, others): (Problem, Vec<Problem>)| {
        if !others.is_empty() {
            first.message = format!("{} (and {} more)", first.message, others.len());
        }
        let others = others.into_iter().map(|problem| *in_file(problem));
        in_file(first).with_others(others.collect())
    };
    let mut derived = Vec::new();
    let written = design::take(&mut table).map_err(in_file)?;
    if let Some(written) = &written {
        let designed: Designed = read_all(written).map_err(several)?;
        let expanded = all_told(|| design::expand(&designed, written, &mut table, folder));
        derived = expanded.map_err(several)?;
    }
    let text = toml::to_string(&table).unwrap_or_default();
    let physics = toml::to_string(&identity::physics(&table)).unwrap_or_default();
    let file: File = read_all(&table).map_err(several)?;
    let result = all_told(|| check(&file)).map_err(|(first, others)| {
        let written = written.unwrap_or_default();
        let traced = |problem: Problem| design::traced(problem, &derived, &written);
        several((traced(first), others.into_iter().map(traced).collect()))
    })?;
    let applied = Applied {
        text,
        physics,
        derived,
        overrides,
        file,
    };
    Ok((applied, result))
}

/// An override, with the case's own design in the place of `design`; the table that is wanted where the case does not have it.
fn of_design(change: &str, own: Option<&str>) -> Result<String, String> {
    let within = |table: &str| {
        let rest = change.trim_start().strip_prefix(table)?;
        rest.starts_with('.').then_some(rest)
    };
    if let Some(rest) = within(design::ANY) {
        let own = own.ok_or("a design ([canopy], [wing] or [mesh])")?;
        return Ok(format!("{own}{rest}"));
    }
    let other = design::TABLES.into_iter().find(|t| within(t).is_some());
    match other.filter(|other| own != Some(other)) {
        Some(other) => Err(format!("[{other}]")),
        None => Ok(change.to_owned()),
    }
}

/// A value that could not be read.
struct Misread {
    /// Where it stands, with dots between keys; one dot for the whole.
    path: String,
    /// Why.
    message: String,
}

/// Reads a table. Through an erased reader: those of `toml` and of paths would else be compiled anew for every table of a case (5.6 % of this library's LLVM lines).
fn read_table<T: DeserializeOwned>(table: toml::Table) -> Result<T, Misread> {
    let mut track = serde_path_to_error::Track::new();
    let tracked = serde_path_to_error::Deserializer::new(table, &mut track);
    let mut erased = <dyn erased_serde::Deserializer>::erase(tracked);
    erased_serde::deserialize(&mut erased).map_err(|error| Misread {
        // Below its message `toml` says on each level in which table it stands, which the path does.
        message: error
            .to_string()
            .lines()
            .next()
            .unwrap_or_default()
            .to_owned(),
        path: track.path().to_string(),
    })
}

/// Most slips that are told at once.
const SLIPS: usize = 10;

/// Reads what is written. Slips in keys and values are told together: each is taken out, or for what was meant, so that what stands behind it is
/// read, too.
fn read_all<T: DeserializeOwned>(table: &toml::Table) -> Result<T, (Problem, Vec<Problem>)> {
    let mut rest = table.clone();
    let mut others: Vec<Problem> = Vec::new();
    let mut error = match read_table(rest.clone()) {
        Ok(file) => return Ok(file),
        Err(error) => error,
    };
    let first = misread(&error, &rest);
    let mut last = first.key.clone();
    while others.len() + 1 < SLIPS {
        let message = &error.message;
        let key = meant(message).filter(|_| message.starts_with("unknown field"));
        if !mend(&mut rest, &last, key) {
            break;
        }
        match read_table::<T>(rest.clone()) {
            Ok(_) => break,
            Err(next) => error = next,
        }
        let problem = misread(&error, &rest);
        // What is missing because it was taken out is no slip of its own.
        let is_within = |slip: &Problem| slip.key.starts_with(&problem.key);
        let follows = error.message.starts_with("missing field")
            || is_within(&first)
            || others.iter().any(is_within);
        if follows {
            break;
        }
        last.clone_from(&problem.key);
        others.push(problem);
    }
    Err((first, others))
}

/// Puts what stands under a dotted path under the name that was meant, if that is free, or away; false where nothing stands there.
fn mend(table: &mut toml::Table, path: &str, meant: Option<&str>) -> bool {
    if let Some((first, rest)) = path.split_once('.') {
        let inner = table.get_mut(first).and_then(toml::Value::as_table_mut);
        return inner.is_some_and(|inner| mend(inner, rest, meant));
    }
    let Some(value) = table.remove(path) else {
        return false;
    };
    if let Some(meant) = meant.filter(|name| !table.contains_key(*name)) {
        table.insert(meant.to_owned(), value);
    }
    true
}

/// What to do with a key that nobody knows.
const CORRECT: &str = "correct the key, or remove it; keys carry their unit, e.g. `speed_m_s`";

/// The known name that is nearest to an unknown key or word in a message, which lists what was expected.
fn meant(message: &str) -> Option<&str> {
    let unknown = ["unknown field `", "unknown word `"];
    let rest = unknown
        .iter()
        .find_map(|begin| message.strip_prefix(begin))?;
    let name = rest.split('`').next()?;
    nearest(name, message.split('`').skip(3).step_by(2))
}

/// What could not be read, in the words of the author of a case.
fn misread(error: &Misread, table: &toml::Table) -> Problem {
    let path = error.path.clone();
    // A word in place of a table is reported as if it were one.
    let above = path.rsplit_once('.').map(|(above, _)| above);
    let mut places = std::iter::once(&path[..]).chain(above);
    if let Some(problem) = places.find_map(|place| wrong_alternatives(place, table)) {
        return problem;
    }
    // Names of Rust types mean nothing to the author of a case.
    let message = error
        .message
        .replace("unknown variant `", "unknown word `")
        .replace("expected f64", "expected a number")
        .replace("expected u32", "expected a whole number")
        .replace("expected usize", "expected a whole number");
    if message.starts_with("wanted exactly 1 element") {
        let why = format!("{path} is a word, not a table");
        return Problem::new(path, why, "give one of its words, in quotation marks");
    }
    // An unknown key is reported at its table; add the key itself to mark its line.
    let unknown = message
        .strip_prefix("unknown field `")
        .and_then(|rest| rest.split('`').next());
    let key = match unknown {
        Some(field) if path == "." => field.to_owned(),
        Some(field) if !path.ends_with(field) => format!("{path}.{field}"),
        _ => path,
    };
    let meant = meant(&message).map_or_else(String::new, |name| format!("did you mean `{name}`? "));
    let help = if unknown.is_some() {
        CORRECT
    } else {
        "`ripstop explain KEY` tells what a key means, docs/case-files.md lists all; `ripstop new` lists complete cases"
    };
    Problem::new(key, message, format!("{meant}{help}"))
}

/// What is wrong under a path where exactly one of several keys belongs; `None` elsewhere, and where one is there.
fn wrong_alternatives(path: &str, table: &toml::Table) -> Option<Problem> {
    let known = schema::alternatives(path);
    let names = (!known.is_empty()).then(|| known.join(", "))?;
    let Some(written) = lookup(table, path)?.as_table() else {
        return Some(Problem::new(
            path,
            format!("{path} is a table with exactly one of {names}"),
            format!("write it as a table, such as [{path}.{}]", known[0]),
        ));
    };
    if let Some(unknown) = written.keys().find(|key| !known.contains(key)) {
        return Some(Problem::new(
            format!("{path}.{unknown}"),
            format!("unknown key `{unknown}`, expected exactly one of {names}"),
            format!(
                "{}{CORRECT}",
                did_you_mean(unknown, known.iter().map(String::as_str))
            ),
        ));
    }
    (written.len() != 1).then(|| {
        Problem::new(
            path,
            format!("[{path}] needs exactly one of {names}"),
            "keep or add just one of them; `\"absent\"` removes one in a variant, or with --set",
        )
    })
}
