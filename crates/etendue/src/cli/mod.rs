//! The command line: one file per command.

mod args;
mod bench;
mod bench_scenes;
mod error;
mod info;
mod load;
mod merge;
mod output;
mod progress;
mod render;
mod tonemap;

use args::{Cli, Command};
use clap::Parser;
pub use error::CliError;
use std::process::ExitCode;

/// Runs the program: 0 done, 2 wrong usage, 1 anything else.
pub fn main() -> ExitCode {
    // clap itself ends the program with 2 for arguments that it does not understand, and 0 after --help.
    let cli = Cli::parse();
    let result = match cli.command {
        None => render::run(args::RenderArgs::builtin()),
        Some(Command::Render(a)) => render::run(*a),
        Some(Command::Merge(a)) => merge::run(&a),
        Some(Command::Tonemap(a)) => tonemap::run(&a),
        Some(Command::Info(a)) => info::run(&a),
        Some(Command::Bench(a)) => bench::run(&a),
    };
    match result {
        Ok(()) => ExitCode::SUCCESS,
        Err(e) => {
            let code = e.exit_code();
            // A closed pipe while reporting is nothing to report.
            let _ = std::io::Write::write_all(
                &mut std::io::stderr(),
                format!("{:?}\n", miette::Report::new(e)).as_bytes(),
            );
            ExitCode::from(code)
        }
    }
}

/// Prints to standard output; a reader that went away (`| head`) ends the program quietly.
pub(crate) fn say(text: &str) {
    use std::io::Write;
    if writeln!(std::io::stdout(), "{text}").is_err() {
        std::process::exit(0);
    }
}
