//! The `ripstop` program: everything is in the library.

fn main() -> std::process::ExitCode {
    ripstop::cli::main()
}
