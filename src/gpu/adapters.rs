//! The adapters of this machine, and which one a run takes.

use super::error::DeviceError;
use super::quiet::quietly;

/// What kind of processor an adapter is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum AdapterKind {
    /// A graphics card with its own memory.
    Discrete,
    /// A graphics processor that shares the host's memory.
    Integrated,
    /// A share of a graphics card in a virtual machine.
    Virtual,
    /// Not told by the driver.
    Unknown,
    /// A program on the CPU that plays the device: correct, slow.
    Software,
}

impl AdapterKind {
    /// Name in reports.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Discrete => "discrete GPU",
            Self::Integrated => "integrated GPU",
            Self::Virtual => "virtual GPU",
            Self::Unknown => "unknown kind",
            Self::Software => "software",
        }
    }
}

/// One adapter, as `ripstop devices` lists it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct AdapterInfo {
    /// Name given by the driver.
    pub name: String,
    /// What kind of processor it is.
    pub kind: AdapterKind,
    /// Interface (Vulkan, Metal, Direct3D 12).
    pub backend: String,
    /// Driver with its version.
    pub driver: String,
    /// Largest buffer [bytes].
    pub buffer_limit_bytes: u64,
    /// Largest buffer that a shader can be given whole [bytes].
    pub binding_limit_bytes: u64,
    /// Storage buffers that one shader can be given.
    pub storage_buffer_limit: u32,
}

/// Which adapter to take.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum AdapterChoice {
    /// The best real GPU; software never.
    Hardware,
    /// The best real GPU, or else software.
    Any,
    /// One whose name contains this text, whatever the case of its letters.
    Named(String),
}

/// Storage buffers that the widest stage, `interpolate` at the touched cells, is given; a test counts them.
pub const STORAGE_BUFFERS_NEEDED: u32 = 23;

fn instance() -> wgpu::Instance {
    // Validation layers and other switches follow wgpu's environment variables (WGPU_VALIDATION=1).
    let mut descriptor = wgpu::InstanceDescriptor::new_without_display_handle();
    descriptor.backends = wgpu::Backends::PRIMARY;
    descriptor.flags = wgpu::InstanceFlags::empty().with_env();
    wgpu::Instance::new(descriptor)
}

fn found() -> Vec<(wgpu::Adapter, AdapterInfo)> {
    let mut found: Vec<_> =
        pollster::block_on(instance().enumerate_adapters(wgpu::Backends::all()))
            .into_iter()
            .map(|adapter| {
                let info = describe(&adapter);
                (adapter, info)
            })
            .collect();
    found.sort_by_key(|(_, info)| info.kind);
    found
}

fn describe(adapter: &wgpu::Adapter) -> AdapterInfo {
    let info = adapter.get_info();
    let limits = adapter.limits();
    AdapterInfo {
        kind: match info.device_type {
            wgpu::DeviceType::DiscreteGpu => AdapterKind::Discrete,
            wgpu::DeviceType::IntegratedGpu => AdapterKind::Integrated,
            wgpu::DeviceType::VirtualGpu => AdapterKind::Virtual,
            wgpu::DeviceType::Cpu => AdapterKind::Software,
            wgpu::DeviceType::Other => AdapterKind::Unknown,
        },
        backend: format!("{:?}", info.backend),
        driver: format!("{} {}", info.driver, info.driver_info)
            .trim()
            .to_owned(),
        name: info.name,
        buffer_limit_bytes: limits.max_buffer_size,
        binding_limit_bytes: limits.max_storage_buffer_binding_size,
        storage_buffer_limit: limits.max_storage_buffers_per_shader_stage,
    }
}

/// All adapters, best first.
#[must_use]
pub fn adapters() -> Vec<AdapterInfo> {
    found().into_iter().map(|(_, info)| info).collect()
}

/// True if there is a real GPU; what drivers say while they are asked is kept from standard error.
#[must_use]
pub fn has_gpu() -> bool {
    let found = quietly(found);
    (found.iter()).any(|(_, info)| info.fits(&AdapterChoice::Hardware))
}

impl AdapterInfo {
    /// Why the engine cannot run on this adapter; `None` if it can.
    #[must_use]
    pub fn shortcoming(&self) -> Option<String> {
        (self.storage_buffer_limit < STORAGE_BUFFERS_NEEDED).then(|| {
            format!(
                "offers {} storage buffers per shader, {STORAGE_BUFFERS_NEEDED} are needed",
                self.storage_buffer_limit
            )
        })
    }

    /// True if `choice` may take this adapter.
    #[must_use]
    pub fn fits(&self, choice: &AdapterChoice) -> bool {
        match choice {
            AdapterChoice::Hardware => {
                self.kind != AdapterKind::Software && self.shortcoming().is_none()
            }
            AdapterChoice::Any => self.shortcoming().is_none(),
            AdapterChoice::Named(text) => self.name.to_lowercase().contains(&text.to_lowercase()),
        }
    }
}

/// The first of `adapters` that `choice` may take.
#[must_use]
pub fn chosen<'a>(adapters: &'a [AdapterInfo], choice: &AdapterChoice) -> Option<&'a AdapterInfo> {
    adapters.iter().find(|info| info.fits(choice))
}

pub(super) fn take(choice: &AdapterChoice) -> Result<(wgpu::Adapter, AdapterInfo), DeviceError> {
    let all = match choice {
        // Nobody has asked for a device by name.
        AdapterChoice::Hardware => quietly(found),
        AdapterChoice::Any | AdapterChoice::Named(_) => found(),
    };
    let names: Vec<String> = all
        .iter()
        .map(|(_, info)| format!("{} ({})", info.name, info.kind.name()))
        .collect();
    let listed = if names.is_empty() {
        "this machine has no adapter at all (on Linux, install a Vulkan driver and libvulkan1)"
            .to_owned()
    } else {
        format!("found: {}", names.join(", "))
    };
    let taken = all.into_iter().find(|(_, info)| info.fits(choice));
    let Some((adapter, info)) = taken else {
        return Err(DeviceError::NoAdapter(match choice {
            AdapterChoice::Hardware => format!(
                "no GPU; {listed}{}",
                if names.is_empty() {
                    ""
                } else {
                    "; --engine gpu and --adapter NAME take a software adapter too"
                }
            ),
            AdapterChoice::Any => format!("no usable adapter; {listed}"),
            AdapterChoice::Named(text) => {
                format!("no adapter is called \"{text}\"; {listed}; `ripstop devices` lists them")
            }
        }));
    };
    if let Some(why) = info.shortcoming() {
        return Err(DeviceError::NoAdapter(format!(
            "the adapter {} cannot run the engine: it {why}; take another (--adapter) or --engine cpu",
            info.name
        )));
    }
    Ok((adapter, info))
}
