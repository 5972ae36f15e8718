//! What can go wrong with a device. Nothing in this room panics.

/// A device that is missing, too small, or gone.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum DeviceError {
    /// No adapter fits the request.
    #[error("{0}")]
    NoAdapter(String),
    /// The adapter refused to open.
    #[error("the device {name} could not be opened: {why}")]
    Open {
        /// The adapter.
        name: String,
        /// The driver's reason.
        why: String,
    },
    /// Something is larger than the device allows.
    #[error("{what} needs {needed}, but {device} allows {limit} ({limit_name}); {remedy}")]
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
    /// The device has no memory left.
    #[error(
        "the device is out of memory ({what}); use larger cells, a smaller tunnel, or --engine cpu"
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
