//! What can go wrong with a device. Nothing in this room panics.

/// A device that is missing, too small, or gone.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum DeviceError {
    /// No adapter fits the request.
    #[error("{0}")]
    NoAdapter(String),
    /// No adapter opens: each with the driver's reason.
    #[error("no device opens: {0}")]
    Open(String),
    /// Something is larger than the device allows.
    #[error(
        "{what} needs {}, but {device} allows {} ({limit_name}); {remedy}",
        in_its_unit(*needed, limit_name), in_its_unit(*limit, limit_name)
    )]
    Limit {
        /// What is too large.
        what: String,
        /// Its size.
        needed: u64,
        /// The device's limit.
        limit: u64,
        /// The limit's name in wgpu.
        limit_name: &'static str,
        /// The device.
        device: String,
        /// What to do.
        remedy: &'static str,
    },
    /// Something that the device cannot do.
    #[error("{device} cannot {what}; {remedy}")]
    Feature {
        /// What it lacks, as a verb.
        what: &'static str,
        /// The device.
        device: String,
        /// What to do.
        remedy: &'static str,
    },
    /// The device has no memory left.
    #[error(
        "the device is out of memory ({what}); make the case coarser or smaller, or compute it on the CPU (--engine cpu, --cloth host)"
    )]
    OutOfMemory {
        /// What was being allocated or computed.
        what: String,
    },
    /// The device is gone: unplugged, reset by its driver, or destroyed.
    #[error(
        "the device was lost ({0}); what was written, the last checkpoint included, is kept: --resume continues from it"
    )]
    Lost(String),
    /// A shader or pipeline was refused.
    #[error("the device refused the pipeline `{name}`: {why}")]
    Pipeline {
        /// The pipeline.
        name: String,
        /// The driver's or validator's reason.
        why: String,
    },
    /// The device refused a command.
    #[error("the device refused a command: {0}")]
    Command(String),
}

/// Bytes are many; other limits are counts.
fn in_its_unit(value: u64, limit_name: &str) -> String {
    if limit_name.contains("size") {
        format!("{:.1} MB", value as f64 / 1e6)
    } else {
        value.to_string()
    }
}

impl DeviceError {
    /// Sorts an error of wgpu.
    pub(super) fn from_wgpu(error: &wgpu::Error, doing: &str) -> Self {
        match error {
            wgpu::Error::OutOfMemory { .. } => Self::OutOfMemory {
                what: doing.to_owned(),
            },
            wgpu::Error::Validation { description, .. }
            | wgpu::Error::Internal { description, .. } => {
                Self::Command(format!("{doing}: {description}"))
            }
        }
    }
}
