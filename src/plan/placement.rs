//! Who computes what: air and fabric are placed separately.

use super::Precision;

/// Where the air is computed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum AirPlacement {
    /// CPU threads, in this precision.
    Cpu(Precision),
    /// A device, in single precision.
    Gpu,
}

/// Where the fabric is solved. L-BFGS itself always runs on the host; this says where its vectors are.
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
    /// Floating-point type of the air.
    #[must_use]
    pub const fn precision(&self) -> Precision {
        match self.air {
            AirPlacement::Cpu(precision) => precision,
            AirPlacement::Gpu => Precision::F32,
        }
    }

    /// True if the air is on a device.
    #[must_use]
    pub fn air_on_device(&self) -> bool {
        self.air == AirPlacement::Gpu
    }

    /// True if the fabric is on a device.
    #[must_use]
    pub fn cloth_on_device(&self) -> bool {
        self.cloth == ClothPlacement::Device
    }
}
