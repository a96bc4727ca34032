//! `columba share`: pictures of a flight for others.

use super::{Failure, print_line};
use crate::args::{Cli, ShareArgs};
use crate::record::RunFolder;
use crate::share::Replay;
use anyhow::Context;

/// Draws a moving and a still picture of a run into its folder.
pub fn share(cli: &Cli, args: &ShareArgs) -> Result<(), Failure> {
    let path = args.folder.join("report.html");
    let report = std::fs::read_to_string(&path).with_context(|| format!("cannot read {}", path.display()))?;
    let replay = Replay::read(&report).with_context(|| path.display().to_string())?;
    let folder = RunFolder::create(&args.folder)?;
    for (name, picture) in
        [("moving.png", replay.moving(args.width, args.seconds)?), ("still.png", replay.still(args.width)?)]
    {
        folder.write(name, &picture)?;
        if !cli.quiet {
            print_line(format_args!("{} ({} kB)", args.folder.join(name).display(), picture.len().div_ceil(1000)));
        }
    }
    Ok(())
}
