//! Silence while drivers are asked for what nobody asked of them: Mesa's tell on standard error that there is no display, even where the CPU
//! computes everything.

#[cfg(unix)]
use std::{
    fs::File,
    os::fd::{AsFd, OwnedFd},
    sync::{Mutex, PoisonError},
};

/// One at a time: who begins second would take silence for standard error.
#[cfg(unix)]
static ONE: Mutex<()> = Mutex::new(());

/// Standard error as it was, to which it returns.
#[cfg(unix)]
struct Silence(OwnedFd);

#[cfg(unix)]
impl Silence {
    /// `None` where standard error cannot be turned away.
    fn begin() -> Option<Self> {
        let before = std::io::stderr().as_fd().try_clone_to_owned().ok()?;
        let nowhere = File::options().write(true).open("/dev/null").ok()?;
        rustix::stdio::dup2_stderr(&nowhere).ok()?;
        Some(Self(before))
    }
}

#[cfg(unix)]
impl Drop for Silence {
    fn drop(&mut self) {
        // Without it nothing more would be heard, but files tell the same.
        let _ = rustix::stdio::dup2_stderr(&self.0);
    }
}

/// The result of `work`, during which nothing is written to standard error, by no thread.
#[cfg(unix)]
pub(super) fn quietly<T>(work: impl FnOnce() -> T) -> T {
    let _one = ONE.lock().unwrap_or_else(PoisonError::into_inner);
    let _silence = Silence::begin();
    work()
}

/// The result of `work`: other systems' drivers keep silent.
#[cfg(not(unix))]
pub(super) fn quietly<T>(work: impl FnOnce() -> T) -> T {
    work()
}
