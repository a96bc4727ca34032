//! `columba completions` and `columba man`: what a shell and `man` know of the command line, made from the same
//! definitions as `--help`.

use super::Failure;
use crate::args::{Cli, CompletionsArgs, ManArgs};
use crate::config::nearest;
use anyhow::{Context, anyhow};
use std::io::Write;

/// The name of the program in completions and pages.
const PROGRAM: &str = "columba";

/// Prints the completions of a shell.
pub fn completions(args: &CompletionsArgs) -> Result<(), Failure> {
    let mut text = Vec::new();
    clap_complete::generate(args.shell, &mut Cli::full_command(), PROGRAM, &mut text);
    print(&text)
}

/// Prints the manual page of the program or of a subcommand.
pub fn man(args: &ManArgs) -> Result<(), Failure> {
    let mut program = Cli::full_command();
    program.build();
    let page = match &args.command {
        None => clap_mangen::Man::new(program),
        Some(name) => {
            let names: Vec<String> = program.get_subcommands().map(|command| command.get_name().to_owned()).collect();
            let found = program.find_subcommand(name).cloned();
            let command = found.ok_or_else(|| {
                let names: Vec<&str> = names.iter().map(String::as_str).collect();
                let meant = nearest(name, &names).map(|name| format!("; did you mean {name}?")).unwrap_or_default();
                anyhow!("{name}: must be a subcommand: {}{meant}", names.join(", "))
            })?;
            clap_mangen::Man::new(command).title(format!("{PROGRAM}-{name}"))
        }
    };
    let mut text = Vec::new();
    page.render(&mut text).context("cannot write the manual page")?;
    print(&text)
}

fn print(text: &[u8]) -> Result<(), Failure> {
    // A reader that has gone away wants no more.
    let _ = std::io::stdout().lock().write_all(text);
    Ok(())
}
