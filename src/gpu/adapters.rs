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
    /// The one of which all this is known.
    Exactly(Box<AdapterInfo>),
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
            AdapterChoice::Exactly(info) => self == &**info,
        }
    }
}

/// The first of `adapters` that `choice` may take.
#[must_use]
pub fn chosen<'a>(adapters: &'a [AdapterInfo], choice: &AdapterChoice) -> Option<&'a AdapterInfo> {
    adapters.iter().find(|info| info.fits(choice))
}

/// All adapters that `choice` may take, the best first; never none.
pub(super) fn fitting(
    choice: &AdapterChoice,
) -> Result<Vec<(wgpu::Adapter, AdapterInfo)>, DeviceError> {
    let all = match choice {
        // Nobody has asked for a device by name.
        AdapterChoice::Hardware => quietly(found),
        AdapterChoice::Any | AdapterChoice::Named(_) | AdapterChoice::Exactly(_) => found(),
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
    let (fitting, unfit): (Vec<_>, Vec<_>) = (all.into_iter())
        .filter(|(_, info)| info.fits(choice))
        .partition(|(_, info)| info.shortcoming().is_none());
    if !fitting.is_empty() {
        // A program that plays the device takes a card's place only where there is none.
        let software = |(_, info): &(_, AdapterInfo)| info.kind == AdapterKind::Software;
        let (software, cards): (Vec<_>, Vec<_>) = fitting.into_iter().partition(software);
        return Ok(if cards.is_empty() { software } else { cards });
    }
    let short = (unfit.first()).and_then(|(_, info)| Some((info, info.shortcoming()?)));
    Err(DeviceError::NoAdapter(match (short, choice) {
        (Some((info, why)), _) => format!(
            "the adapter {} cannot run the engine: it {why}; take another (--adapter) or --engine cpu",
            info.name
        ),
        (None, AdapterChoice::Hardware) => format!(
            "no GPU; {listed}{}",
            if names.is_empty() {
                ""
            } else {
                "; --engine gpu and --adapter NAME take a software adapter too"
            }
        ),
        (None, AdapterChoice::Any) => format!("no usable adapter; {listed}"),
        (None, AdapterChoice::Exactly(info)) => {
            format!("the adapter {} is not there any more; {listed}", info.name)
        }
        (None, AdapterChoice::Named(text)) => {
            format!("no adapter is called \"{text}\"; {listed}; `ripstop devices` lists them")
        }
    }))
}

/// What opens of some adapters, tried in their order, and why those before it did not.
pub(super) fn first_that_opens<A, D>(
    adapters: Vec<A>,
    open: impl Fn(&A) -> Result<D, String>,
) -> Result<(A, D, Vec<String>), DeviceError> {
    let mut refused = Vec::new();
    for adapter in adapters {
        match open(&adapter) {
            Ok(device) => return Ok((adapter, device, refused)),
            Err(reason) => refused.push(reason),
        }
    }
    Err(DeviceError::Open(refused.join("; ")))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn opened(works: [bool; 3]) -> Result<(usize, usize), String> {
        let open = |&number: &usize| match works[number] {
            true => Ok(number),
            false => Err(format!("card {number}")),
        };
        match first_that_opens(vec![0, 1, 2], open) {
            Ok((adapter, device, refused)) => {
                assert_eq!(adapter, device);
                Ok((device, refused.len()))
            }
            Err(error) => Err(error.to_string()),
        }
    }

    /// An adapter that does not open is passed over for the next one; where none opens, all reasons are told.
    #[test]
    fn the_next_adapter_is_tried() {
        assert_eq!(opened([true, true, true]), Ok((0, 0)));
        assert_eq!(opened([false, true, true]), Ok((1, 1)));
        assert_eq!(opened([false, false, true]), Ok((2, 2)));
        let told = opened([false; 3]).unwrap_err();
        for number in 0..3 {
            assert!(told.contains(&format!("card {number}")), "{told}");
        }
    }
}
