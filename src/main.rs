//! The `ripstop` program: everything is in the library, but for what happens where memory ends.

#[cfg(unix)]
mod out_of_memory {
    use std::alloc::{GlobalAlloc, Layout, System};

    use ripstop::cli::exit::OUTPUT_FAILED;

    /// The system's allocator, which ends the program with a message and an exit code of its own where there is no memory left.
    ///
    /// Without it, the standard library aborts: exit code 134, and no word of what to do (seen with `ulimit -v 300000`).
    pub struct Allocator;

    /// Allocates nothing itself. A checkpoint cannot be written from here: the state may be half changed.
    fn refused() -> ! {
        const MESSAGE: &str = "error: out of memory. Take fewer cells or nodes, raise the limit of memory (ulimit -v), or use another machine; \
                               a run that has a checkpoint goes on from it with --resume\n";
        // The program ends, whether anybody reads it or not.
        let _ = rustix::io::write(rustix::stdio::stderr(), MESSAGE.as_bytes());
        signal_hook::low_level::exit(OUTPUT_FAILED.into())
    }

    fn checked(memory: *mut u8) -> *mut u8 {
        if memory.is_null() {
            refused();
        }
        memory
    }

    #[allow(
        unsafe_code,
        reason = "stable Rust has no other place to speak where an allocation fails"
    )]
    // SAFETY: every call is handed to the system's allocator as it came, and its answer is given back unless it is null.
    unsafe impl GlobalAlloc for Allocator {
        unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
            checked(unsafe { System.alloc(layout) })
        }

        unsafe fn alloc_zeroed(&self, layout: Layout) -> *mut u8 {
            checked(unsafe { System.alloc_zeroed(layout) })
        }

        unsafe fn realloc(&self, memory: *mut u8, layout: Layout, size: usize) -> *mut u8 {
            checked(unsafe { System.realloc(memory, layout, size) })
        }

        unsafe fn dealloc(&self, memory: *mut u8, layout: Layout) {
            unsafe { System.dealloc(memory, layout) }
        }
    }
}

#[cfg(unix)]
#[global_allocator]
static ALLOCATOR: out_of_memory::Allocator = out_of_memory::Allocator;

fn main() -> std::process::ExitCode {
    ripstop::cli::main()
}
