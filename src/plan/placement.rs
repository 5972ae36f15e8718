//! Who computes what: air and fabric are placed separately.

use crate::lattice::Storage;

/// Name of populations in 16 bits.
const F16_STORAGE: &str = "f16-storage";

/// Where the air is computed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum AirPlacement {
    /// CPU threads, in this precision.
    Cpu(Precision),
    /// A device: arithmetic in single precision, populations stored as given.
    Gpu(Storage),
}

impl AirPlacement {
    /// True if populations are kept in 16 bits.
    #[must_use]
    pub const fn is_in_sixteen_bits(self) -> bool {
        matches!(
            self,
            Self::Cpu(Precision::F16Storage) | Self::Gpu(Storage::F16)
        )
    }
}

/// Where the fabric is solved. This says where the minimiser has its vectors. On a device with block-Jacobi it decides there, too; with multigrid the host decides from trial to trial.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ClothPlacement {
    /// Host memory, in double precision.
    Host,
    /// Device memory, in single precision with positions in fixed point.
    Device,
}

/// Who computes what.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Placement {
    /// The air.
    pub air: AirPlacement,
    /// The fabric.
    pub cloth: ClothPlacement,
    /// Name of the device, if one takes part.
    pub device: Option<String>,
    /// True if the device's memory is the host's.
    pub shared_memory: bool,
}

impl From<Precision> for Placement {
    /// All on the CPU.
    fn from(precision: Precision) -> Self {
        Self {
            air: AirPlacement::Cpu(precision),
            cloth: ClothPlacement::Host,
            device: None,
            shared_memory: false,
        }
    }
}

impl Placement {
    /// Bytes of a population.
    #[must_use]
    pub const fn population_bytes(&self) -> u64 {
        match self.air {
            AirPlacement::Cpu(precision) => precision.bytes(),
            AirPlacement::Gpu(storage) => storage.bytes(),
        }
    }

    /// Bytes of a number that is kept beside the populations: on the CPU as it is computed, on a device as they are.
    #[must_use]
    pub const fn kept_bytes(&self) -> u64 {
        match self.air {
            AirPlacement::Cpu(Precision::F64) => 8,
            AirPlacement::Cpu(Precision::F32 | Precision::F16Storage) => 4,
            AirPlacement::Gpu(storage) => storage.bytes(),
        }
    }

    /// Precision of the air in a word.
    #[must_use]
    pub const fn precision_name(&self) -> &'static str {
        match self.air {
            AirPlacement::Cpu(precision) => precision.name(),
            AirPlacement::Gpu(Storage::F32) => "f32",
            AirPlacement::Gpu(Storage::F16) => F16_STORAGE,
        }
    }

    /// Engine of the air in a word.
    #[must_use]
    pub const fn engine(&self) -> &'static str {
        match self.air {
            AirPlacement::Cpu(_) => "cpu",
            AirPlacement::Gpu(_) => "gpu",
        }
    }

    /// True if the air is on a device.
    #[must_use]
    pub fn air_on_device(&self) -> bool {
        matches!(self.air, AirPlacement::Gpu(_))
    }

    /// True if the fabric is on a device.
    #[must_use]
    pub fn cloth_on_device(&self) -> bool {
        self.cloth == ClothPlacement::Device
    }
}

/// Floating-point type of the air.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
pub enum Precision {
    /// Double precision: the reference.
    F64,
    /// Single precision: fast, the default.
    F32,
    /// Single precision, but populations kept in 16 bits: half the memory and traffic, larger error.
    #[value(name = "f16-storage")]
    F16Storage,
}

impl Precision {
    /// Name in reports.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::F64 => "f64",
            Self::F32 => "f32",
            Self::F16Storage => F16_STORAGE,
        }
    }

    /// Bytes of a population.
    #[must_use]
    pub const fn bytes(self) -> u64 {
        match self {
            Self::F64 => 8,
            Self::F32 => 4,
            Self::F16Storage => 2,
        }
    }

    /// How a device stores populations for it; devices compute in single precision.
    #[must_use]
    pub const fn storage(self) -> Storage {
        match self {
            Self::F64 | Self::F32 => Storage::F32,
            Self::F16Storage => Storage::F16,
        }
    }
}
