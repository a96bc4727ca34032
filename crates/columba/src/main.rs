//! The program: reads its arguments, runs a command, and answers with an exit status.

use columba::args::{Cli, Command};
use columba::commands::{self, Failure};
use std::process::ExitCode;

fn main() -> ExitCode {
    let cli = Cli::read(std::env::args_os()).unwrap_or_else(|error| error.exit());
    commands::start_tracing();
    let result = match &cli.command {
        Command::Run(args) => commands::run(&cli, args),
        Command::Vehicles(args) => commands::vehicles(&cli, args),
        Command::Fly(args) => commands::fly(&cli, args),
        Command::Identify(args) => commands::identify(&cli, args),
        Command::Recover(args) => commands::recover(&cli, args),
        Command::Compare(args) => commands::compare(&cli, args),
        Command::Share(args) => commands::share(&cli, args),
        Command::View(args) => commands::view(&cli, args),
        Command::Check(args) => commands::check(&cli, args),
        Command::Suites(args) => commands::suites(&cli, args),
        Command::Completions(args) => commands::completions(args),
        Command::Man(args) => commands::man(args),
    };
    match result {
        Ok(()) => ExitCode::SUCCESS,
        Err(Failure::Flight(what)) => {
            eprintln!("columba: {what}");
            ExitCode::from(1)
        }
        Err(Failure::Usage(error)) => {
            // Several faults are several lines, each of which stands alone.
            for line in format!("{error:#}").lines() {
                eprintln!("columba: {line}");
            }
            ExitCode::from(2)
        }
    }
}
