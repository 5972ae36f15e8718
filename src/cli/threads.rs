//! The threads that compute.

use std::error::Error;

use super::exit;
use super::failure::Failure;

/// Starts the threads that compute, once; 0 takes all cores. Started by the first who needs them, they would end the program with a panic
/// where memory ends.
pub(super) fn start(count: usize) -> Result<(), Failure> {
    let built = rayon::ThreadPoolBuilder::new()
        .num_threads(count)
        .build_global();
    // Without a source there are threads already, as from the second run of a sweep on.
    let refused = built.as_ref().err().and_then(Error::source);
    refused.map_or(Ok(()), |why| {
        Err(Failure::Other(
            exit::OUTPUT_FAILED,
            format!(
                "out of memory: no threads can be started ({why}); raise the limit of memory (ulimit -v) or of processes (ulimit -u), or take fewer (--threads)"
            ),
        ))
    })
}
