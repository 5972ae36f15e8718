//! What comes from others: their licences, where they come from, and who brings in what nobody maintains any more. The rules stand in
//! `deny.toml`, in the form of cargo-deny, which takes minutes to build and would have to be on line.

use std::collections::{BTreeMap, BTreeSet};

use cargo_metadata::{Metadata, MetadataCommand, Package};
use libtest_mimic::Trial;
use serde::Deserialize;
use spdx::{Expression, Licensee, ParseMode};

use crate::command_line::root;

pub fn trials() -> Vec<Trial> {
    // A machine that runs a packed test program has neither cargo nor the sources (benches/accelerator.sh).
    let is_packed = std::env::var_os("RIPSTOP_PROGRAM").is_some();
    let bodies: [(&str, fn()); 5] = [
        ("licences_are_allowed", licences),
        ("sources_are_the_registry_with_checksums", sources),
        ("banned_crates_stay_out", bans),
        ("unmaintained_crates_keep_their_routes", unmaintained),
        ("the_rules_notice_what_breaks_them", rules_bite),
    ];
    let trials = bodies.into_iter().map(|(name, body)| {
        let trial = Trial::test(format!("supply_chain::{name}"), move || {
            body();
            Ok(())
        });
        if is_packed {
            trial.with_ignored_flag(true).with_kind("no cargo here")
        } else {
            trial
        }
    });
    trials.collect()
}

/// The part of `deny.toml` that is held here.
#[derive(Debug, Deserialize)]
struct Rules {
    advisories: Advisories,
    licenses: Licences,
    bans: Bans,
    sources: Sources,
}

#[derive(Debug, Deserialize)]
struct Advisories {
    ignore: Vec<Advisory>,
}

#[derive(Debug, Deserialize)]
struct Advisory {
    id: String,
    reason: String,
}

#[derive(Debug, Deserialize)]
struct Licences {
    allow: Vec<String>,
}

#[derive(Debug, Deserialize)]
struct Bans {
    deny: Vec<Ban>,
}

#[derive(Debug, Deserialize)]
struct Ban {
    #[serde(rename = "crate")]
    name: String,
    /// The only crates that may depend on it; absent: none.
    wrappers: Option<BTreeSet<String>>,
    reason: String,
}

#[derive(Debug, Deserialize)]
#[serde(rename_all = "kebab-case")]
struct Sources {
    allow_registry: Vec<String>,
}

/// `Cargo.lock`: every crate on every system.
#[derive(Debug, Deserialize)]
struct Lock {
    package: Vec<Locked>,
}

#[derive(Debug, Deserialize)]
struct Locked {
    name: String,
    version: String,
    source: Option<String>,
    checksum: Option<String>,
    /// Name, and the version where there are several.
    #[serde(default)]
    dependencies: Vec<String>,
}

impl Lock {
    fn has(&self, name: &str) -> bool {
        self.package.iter().any(|package| package.name == name)
    }

    /// Who depends on a crate, in whichever version.
    fn dependents(&self, name: &str) -> BTreeSet<String> {
        let depends = |package: &&Locked| {
            let mut names = package.dependencies.iter();
            names.any(|dependency| dependency.split(' ').next() == Some(name))
        };
        let found = self.package.iter().filter(depends);
        found.map(|package| package.name.clone()).collect()
    }
}

fn read<T: serde::de::DeserializeOwned>(name: &str) -> T {
    let text = std::fs::read_to_string(root().join(name)).unwrap();
    toml::from_str(&text).unwrap_or_else(|error| panic!("{name}: {error}"))
}

/// Crates of all systems as cargo knows them. Where those of other systems have never been downloaded and there is no network: of this
/// system alone, and false.
fn metadata() -> (Metadata, bool) {
    let ask = |options: &[&str]| {
        MetadataCommand::new()
            .manifest_path(root().join("Cargo.toml"))
            .env("CARGO_NET_RETRY", "0")
            .env("CARGO_HTTP_TIMEOUT", "10")
            .other_options(options.iter().map(|o| (*o).to_owned()).collect::<Vec<_>>())
            .exec()
    };
    for options in [&["--locked", "--offline"][..], &["--locked"]] {
        if let Ok(all) = ask(options) {
            return (all, true);
        }
    }
    let host = format!("--filter-platform={}", host());
    match ask(&["--locked", "--offline", &host]) {
        Ok(own) => (own, false),
        Err(error) => {
            panic!("cargo cannot list the crates, run `cargo fetch --locked` once on line: {error}")
        }
    }
}

/// Name of this system, as rustc says it.
fn host() -> String {
    let rustc = std::env::var_os("RUSTC").unwrap_or_else(|| "rustc".into());
    let output = std::process::Command::new(rustc)
        .arg("-vV")
        .output()
        .unwrap();
    let text = String::from_utf8(output.stdout).unwrap();
    let host = text.lines().find_map(|line| line.strip_prefix("host: "));
    host.unwrap().to_owned()
}

/// The reason why a licence is not allowed; `None` if it is.
fn refused(licence: Option<&str>, allowed: &[Licensee]) -> Option<String> {
    let Some(licence) = licence else {
        return Some("names no licence".to_owned());
    };
    // Older crates write `MIT/Apache-2.0`.
    let expression = match Expression::parse_mode(licence, ParseMode::LAX) {
        Ok(expression) => expression,
        Err(error) => return Some(format!("`{licence}` cannot be read: {error}")),
    };
    let fits = expression.evaluate(|one| allowed.iter().any(|allowed| allowed.satisfies(one)));
    (!fits).then(|| format!("`{licence}` is not covered"))
}

fn allowed(rules: &Rules) -> Vec<Licensee> {
    let parse = |name: &String| Licensee::parse(name).unwrap();
    rules.licenses.allow.iter().map(parse).collect()
}

fn licences() {
    let rules: Rules = read("deny.toml");
    let allowed = allowed(&rules);
    let (metadata, is_whole) = metadata();
    if !is_whole {
        println!("licences of crates for other systems are not checked: no network");
    }
    let wrong = |package: &Package| {
        let why = refused(package.license.as_deref(), &allowed)?;
        Some(format!("{} {}: {why}", package.name, package.version))
    };
    let wrong: Vec<String> = metadata.packages.iter().filter_map(wrong).collect();
    assert!(
        wrong.is_empty(),
        "licences that deny.toml does not allow; take another crate, or add the licence to licenses.allow once its terms are met:\n{}",
        wrong.join("\n")
    );
    for (number, name) in rules.licenses.allow.iter().enumerate() {
        let mut others = allowed.clone();
        others.remove(number);
        let mut packages = metadata.packages.iter();
        assert!(
            !is_whole || packages.any(|p| refused(p.license.as_deref(), &others).is_some()),
            "no crate needs the licence {name} any more: remove it from licenses.allow in deny.toml"
        );
    }
}

/// Crates that do not come from an allowed registry with a checksum; the own one has no source.
fn unverified<'a>(lock: &'a Lock, rules: &Rules) -> Vec<&'a Locked> {
    let is_known = |source: &String| {
        let registry = source.strip_prefix("registry+");
        registry.is_some_and(|url| {
            rules
                .sources
                .allow_registry
                .iter()
                .any(|known| known == url)
        })
    };
    let others = lock.package.iter().filter(|p| p.name != "ripstop");
    others
        .filter(|p| !p.source.as_ref().is_some_and(is_known) || p.checksum.is_none())
        .collect()
}

fn sources() {
    let (rules, lock): (Rules, Lock) = (read("deny.toml"), read("Cargo.lock"));
    assert!(lock.package.len() > 100);
    let unverified = unverified(&lock, &rules);
    assert!(
        unverified.is_empty(),
        "these do not come from crates.io with a checksum; give a published version in Cargo.toml: {unverified:#?}"
    );
}

fn bans() {
    let (rules, lock): (Rules, Lock) = (read("deny.toml"), read("Cargo.lock"));
    for ban in rules.bans.deny.iter().filter(|ban| ban.wrappers.is_none()) {
        assert!(
            !lock.has(&ban.name),
            "{} is banned ({}), but {:?} bring it in: `cargo tree --target all -i {}`",
            ban.name,
            ban.reason,
            lock.dependents(&ban.name),
            ban.name
        );
    }
    for (name, versions) in several_versions(&lock) {
        println!("several versions of {name}: {}", versions.join(", "));
    }
}

/// Crates in several versions, and which dependents have which.
fn several_versions(lock: &Lock) -> BTreeMap<&str, Vec<String>> {
    let mut versions: BTreeMap<&str, Vec<String>> = BTreeMap::new();
    for package in &lock.package {
        let exact = format!("{} {}", package.name, package.version);
        let users = lock
            .package
            .iter()
            .filter(|p| p.dependencies.contains(&exact));
        let users: Vec<&str> = users.map(|user| user.name.as_str()).collect();
        let text = format!("{} ({})", package.version, users.join(", "));
        versions.entry(&package.name).or_default().push(text);
    }
    versions.retain(|_, versions| versions.len() > 1);
    versions
}

/// What does not hold of crates that nobody maintains: each has an advisory that is ignored, and those who bring it in are the ones named.
fn changed_routes(lock: &Lock, rules: &Rules) -> Vec<String> {
    let mut found = Vec::new();
    let known: Vec<&Ban> = rules
        .bans
        .deny
        .iter()
        .filter(|b| b.wrappers.is_some())
        .collect();
    for advisory in &rules.advisories.ignore {
        if !known.iter().any(|ban| ban.reason.contains(&advisory.id)) {
            found.push(format!(
                "advisory {} is ignored ({}), but no ban with `wrappers` names it: add one for its crate, or stop to ignore it",
                advisory.id, advisory.reason
            ));
        }
    }
    for ban in known {
        let (name, wrappers) = (&ban.name, ban.wrappers.as_ref().unwrap());
        let mut advisories = rules.advisories.ignore.iter();
        if !advisories.any(|advisory| ban.reason.contains(&advisory.id)) {
            found.push(format!(
                "the ban of {name} names no advisory that advisories.ignore has: name it in `reason`"
            ));
        }
        if !lock.has(name) {
            found.push(format!(
                "{name} is gone: remove its ban and its advisory from deny.toml"
            ));
            continue;
        }
        let now = lock.dependents(name);
        for new in now.difference(wrappers) {
            found.push(format!(
                "{new} brings in {name} ({}): drop {new}, or add it to the `wrappers` of {name} in deny.toml with a look at what it is used for",
                ban.reason
            ));
        }
        for gone in wrappers.difference(&now) {
            found.push(format!(
                "{gone} does not bring in {name} any more: remove it from the `wrappers` of {name} in deny.toml"
            ));
        }
    }
    found
}

fn unmaintained() {
    let changed = changed_routes(&read("Cargo.lock"), &read("deny.toml"));
    assert!(changed.is_empty(), "{}", changed.join("\n"));
}

/// A lock file with every fault, and the rules against it.
fn rules_bite() {
    let rules: Rules = read("deny.toml");
    let allowed = allowed(&rules);
    for (licence, is_fine) in [
        (Some("MIT"), true),
        (Some("GPL-3.0-only OR MIT"), true),
        (Some("MIT/Apache-2.0"), true),
        (Some("MIT AND GPL-3.0-only"), false),
        (Some("GPL-3.0-only"), false),
        (Some("as is"), false),
        (None, false),
    ] {
        assert_eq!(refused(licence, &allowed).is_none(), is_fine, "{licence:?}");
    }
    let registry = "registry+https://github.com/rust-lang/crates.io-index";
    let text = format!(
        "[[package]]\nname = \"ripstop\"\nversion = \"0.1.0\"\ndependencies = [\"paste 1.0.0\", \"fontdue\"]\n\
         [[package]]\nname = \"paste\"\nversion = \"1.0.0\"\nsource = \"{registry}\"\n\
         [[package]]\nname = \"paste\"\nversion = \"2.0.0\"\nsource = \"git+https://example.org/paste\"\nchecksum = \"0\"\n\
         [[package]]\nname = \"fontdue\"\nversion = \"1.0.0\"\nsource = \"{registry}\"\nchecksum = \"0\"\ndependencies = [\"paste 2.0.0\"]\n"
    );
    let lock: Lock = toml::from_str(&text).unwrap();
    let unverified: Vec<&str> = unverified(&lock, &rules)
        .iter()
        .map(|p| p.version.as_str())
        .collect();
    assert_eq!(unverified, ["1.0.0", "2.0.0"]);
    assert_eq!(
        several_versions(&lock)["paste"],
        ["1.0.0 (ripstop)", "2.0.0 (fontdue)"]
    );
    let changed = changed_routes(&lock, &rules).join("\n");
    for part in [
        "ripstop brings in paste",
        "fontdue brings in paste",
        "gemm-f64 does not bring in paste any more",
        "ttf-parser is gone",
    ] {
        assert!(changed.contains(part), "{part}: {changed}");
    }
}
