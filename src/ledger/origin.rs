//! Where a run is computed: program, machine, time.

use std::sync::OnceLock;
use std::time::SystemTime;

use serde::{Deserialize, Serialize};

use super::stock::checksum;

/// The program.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Program {
    /// Its version.
    pub version: String,
    /// Commit that it was built from, where `RIPSTOP_COMMIT` told the compiler.
    pub commit: Option<String>,
    /// `release` or `debug`.
    pub build: String,
    /// Checksum (CRC-32) of the executable, which tells builds of one version apart; absent where it cannot be read.
    #[serde(default)]
    pub executable_crc32: Option<String>,
}

impl Program {
    /// This one.
    #[must_use]
    pub fn this() -> Self {
        let build = if cfg!(debug_assertions) {
            "debug"
        } else {
            "release"
        };
        Self {
            version: env!("CARGO_PKG_VERSION").to_owned(),
            commit: option_env!("RIPSTOP_COMMIT").map(str::to_owned),
            build: build.to_owned(),
            executable_crc32: executable_crc32().clone(),
        }
    }
}

/// Checksum of the file that runs, read once.
fn executable_crc32() -> &'static Option<String> {
    static CHECKSUM: OnceLock<Option<String>> = OnceLock::new();
    CHECKSUM.get_or_init(|| checksum(&std::env::current_exe().ok()?).ok())
}

impl std::fmt::Display for Program {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "version {}", self.version)?;
        if let Some(commit) = &self.commit {
            write!(f, " ({commit})")?;
        }
        write!(f, ", {} build", self.build)?;
        if let Some(checksum) = &self.executable_crc32 {
            write!(f, " {checksum}")?;
        }
        Ok(())
    }
}

/// The machine.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Machine {
    /// Its name; absent where the system does not tell.
    pub host: Option<String>,
    /// Operating system and architecture.
    pub system: String,
    /// Its processor; absent where the system does not tell.
    pub processor: Option<String>,
    /// CPU threads used.
    pub threads: usize,
}

impl Machine {
    /// This one.
    #[must_use]
    pub fn this() -> Self {
        let processor = sysinfo::System::new().ok().and_then(|mut system| {
            system.refresh_cpu_all();
            let brand = system.cpus().first()?.brand().trim().to_owned();
            (!brand.is_empty()).then_some(brand)
        });
        Self {
            host: host(),
            system: format!("{} {}", std::env::consts::OS, std::env::consts::ARCH),
            processor,
            threads: rayon::current_num_threads(),
        }
    }
}

impl std::fmt::Display for Machine {
    /// Processor and system: what decides how numbers are rounded.
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let processor = self.processor.as_deref().unwrap_or("a CPU without a name");
        write!(f, "{processor}, {}", self.system)
    }
}

/// Name of this host.
pub(super) fn host() -> Option<String> {
    sysinfo::System::host_name().ok()
}

/// The time now, UTC, to the second.
#[must_use]
pub fn now() -> String {
    humantime::format_rfc3339_seconds(SystemTime::now()).to_string()
}
