//! The command line; see `etendue help`.
#![forbid(unsafe_code)]

fn main() -> std::process::ExitCode {
    etendue::cli::main()
}
