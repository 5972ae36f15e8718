//! One test body, one trial per engine.

use libtest_mimic::{Failed, Trial};
use ripstop::lattice::Real;

/// Where the air is computed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Engine {
    CpuF64,
    CpuF32,
    Gpu,
}

impl Engine {
    pub const fn name(self) -> &'static str {
        match self {
            Self::CpuF64 => "cpu_f64",
            Self::CpuF32 => "cpu_f32",
            Self::Gpu => "gpu",
        }
    }
}

/// A test body that is generic over the floating-point type of the CPU engine.
pub trait Body: Send + Copy + 'static {
    fn run<T: Real>(self, engine: Engine);
}

/// Trials of `body` on every engine.
pub fn on_every_engine(name: &str, body: impl Body) -> Vec<Trial> {
    [Engine::CpuF64, Engine::CpuF32, Engine::Gpu]
        .into_iter()
        .map(|engine| {
            let trial = Trial::test(format!("{name}::{}", engine.name()), move || match engine {
                Engine::CpuF64 => {
                    body.run::<f64>(engine);
                    Ok(())
                }
                Engine::CpuF32 => {
                    body.run::<f32>(engine);
                    Ok(())
                }
                Engine::Gpu => Err(Failed::from(
                    "RIPSTOP_REQUIRE_GPU=1, but this version has no GPU engine",
                )),
            });
            let skipped = engine == Engine::Gpu
                && std::env::var_os("RIPSTOP_REQUIRE_GPU").is_none_or(|v| v != "1");
            // A skip shows as 'ignored'; the kind says why.
            if skipped {
                trial
                    .with_ignored_flag(true)
                    .with_kind("no GPU engine in this version")
            } else {
                trial
            }
        })
        .collect()
}

/// A test that does not depend on the engine.
pub fn plain(name: &str, body: impl FnOnce() + Send + 'static) -> Vec<Trial> {
    vec![Trial::test(name, move || {
        body();
        Ok(())
    })]
}
