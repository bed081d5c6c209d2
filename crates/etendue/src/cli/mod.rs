//! The command line: one file per command.

mod args;
mod bake;
mod bake_args;
mod bake_files;
mod bake_probe;
mod bench;
mod bench_models;
mod bench_scenes;
mod check;
mod compare;
mod compare_args;
mod convert;
mod error;
mod find_models;
mod frames;
mod goal;
mod info;
mod lab;
mod lab_args;
mod lamp;
mod limit_args;
mod load;
mod loading;
mod material;
mod merge;
mod model_args;
mod motion_args;
mod new;
mod output;
mod progress;
mod realtime;
mod realtime_help;
mod render;
mod report;
mod resume;
mod scene_file;
mod sequence;
mod settings;
mod sheet;
mod sheet_args;
mod sheet_page;
mod shot;
mod sky_args;
mod stage;
mod target;
mod tonemap;
mod values;
mod work;

use args::{Cli, Command};
use clap::{CommandFactory, FromArgMatches};
pub use error::CliError;
use std::io::{ErrorKind, IsTerminal, Write};
use std::process::ExitCode;

/// Runs the program: 0 done, 2 wrong usage, 3 pictures that differ by more than is allowed or models that are found wanting, 1 anything else.
pub fn main() -> ExitCode {
    // clap itself ends the program with 2 for arguments that it does not understand, and 0 after --help.
    let matches = Cli::command().get_matches();
    let cli = Cli::from_arg_matches(&matches).unwrap_or_else(|e| e.exit());
    let given = matches.subcommand().map(|(_, m)| args::given(m)).unwrap_or_default();
    let result = match cli.command {
        None => render::run(args::RenderArgs::builtin()),
        Some(Command::Render(a)) => render::run(args::RenderArgs { given, ..*a }),
        Some(Command::Merge(a)) => merge::run(&args::MergeArgs { given, ..a }),
        Some(Command::Tonemap(a)) => tonemap::run(&a),
        Some(Command::Info(a)) => info::run(&a),
        Some(Command::Check(a)) => check::run(&a),
        Some(Command::Sheet(a)) => sheet::run(&a),
        Some(Command::Convert(a)) => convert::run(&a),
        Some(Command::New(a)) => new::run(&a),
        Some(Command::Schema) => {
            scene_file::print_schema();
            Ok(())
        }
        Some(Command::Bench(a)) => bench::run(&a),
        Some(Command::Lab(a)) => lab::run(&a),
        Some(Command::Bake(a)) => bake::run(&bake_args::BakeArgs { given, ..*a }),
        Some(Command::Compare(a)) => compare::run(&compare_args::CompareArgs { given, ..*a }),
    };
    match result {
        Ok(()) => ExitCode::SUCCESS,
        Err(e) => {
            let code = e.exit_code();
            show(e);
            ExitCode::from(code)
        }
    }
}

/// Prints an error to standard error: lines are wrapped for a terminal only, so that a program finds names in one piece.
fn show(e: CliError) {
    let hook = miette::set_hook(Box::new(|_| {
        let wrap = std::io::stderr().is_terminal();
        // Each message already contains its cause.
        let options =
            miette::MietteHandlerOpts::new().without_cause_chain().wrap_lines(wrap).break_words(false);
        Box::new(options.build())
    }));
    // It fails only if a hook was set before, which then does the work.
    drop(hook);
    note_line(format!("{:?}", miette::Report::new(e)).trim_end());
}

/// Prints a line to standard error; when nobody reads it any more, that is nothing to report.
pub(crate) fn note_line(text: &str) {
    let _ = writeln!(std::io::stderr(), "{text}");
}

/// Prints to standard output. A reader that went away (`| head`) ends the program quietly; a full disk is an error.
pub(crate) fn say(text: &str) {
    let Err(e) = writeln!(std::io::stdout(), "{text}") else { return };
    if e.kind() == ErrorKind::BrokenPipe {
        std::process::exit(0);
    }
    note_line(&format!("error: cannot write to standard output: {e}"));
    std::process::exit(1);
}
