//! The long texts of `--help`: examples, and what a command leaves behind. An example is a line of its own, its
//! explanation the next one, so that both can be read in a narrow terminal. A test runs the examples through the
//! command line.

/// Of the program.
pub const PROGRAM: &str = "\
Exit status: 0 flown without collision, 1 the flight failed (the reason is printed), 2 the arguments or a file are \
wrong.

RUST_LOG=debug prints what the links, the pre-flight and each tick do; RUST_LOG=trace prints every setpoint that is \
sent again.";

/// Of `columba run`.
pub const RUN: &str = "\
Examples:
  columba run
      the paper's flight, in lockstep over UDP; the report is in runs/paper/
  columba run --speed 1
      the same in real time: vehicles on UDP 14600 and up
  columba run field.toml --seed 7 -o out
      your own field
  columba run --set look_ahead.horizon_s=1.5 --set link.delay_ms=80
      any keys of the scenario file
  columba run --transport memory
      without sockets, and so faster: the same flight
  columba run --loss 0.2
      over a bad link: it takes longer, and is the same flight

Exit status: 0 flown without collision, 1 the flight failed (the reason is printed), 2 the arguments or a file are \
wrong.";

/// Of `columba vehicles`.
pub const VEHICLES: &str = "\
Examples:
  columba vehicles
      the five of the paper, from UDP 14600 up, telemetry to 14550
  columba vehicles --count 20
      twenty in a grid
  columba vehicles --vehicle-port 0 --json
      any free ports, and the table of them for a script
  columba vehicles --count 200 --per-port 200
      two hundred behind one port, told apart by their system ids
  columba vehicles --swarm swarminit.txt
      starts as ArduPilot's sim_vehicle.py --swarm reads them
  columba vehicles --param WP_LOITER_RAD=80 --param FS_GCS_ENABL=1
      other parameters than the defaults
  columba vehicles --defaults plane.parm
      the parameters of a real autopilot, from a file that a ground station saved
  columba vehicles --host 0.0.0.0
      for clients on other machines, too

A vehicle answers every client that sends to its port: MAVProxy, pymavlink, your own controller. Ctrl-C ends the \
program.";

/// Of `columba fly`.
pub const FLY: &str = "\
Examples:
  columba vehicles & columba fly
      in real time; the vehicles send their telemetry to UDP 14550
  columba vehicles --lockstep & columba fly --lockstep
      in simulated time, as fast as possible
  columba fly field.toml --link udpin:127.0.0.1:14550
      real autopilots, from the ground to the ground; docs/real-autopilots.md
  columba fly field.toml --link tcp:127.0.0.1:5760 --link tcp:127.0.0.1:5770 --dry-run
      which autopilots are there, and what is missing; no command is sent

On the terminal, during the flight: pause, resume, abort, drop N, take N, status. Ctrl-C ends the flight as --at-end \
says.

Exit status: 0 flown without collision, 1 the flight failed (the reason is printed), 2 the arguments or a file are \
wrong.";

/// Of `columba identify`.
pub const IDENTIFY: &str = "\
Examples:
  columba vehicles --count 1 & columba identify
      a simulated plane, from rest at 20 m/s and 100 m; the airframe file is in runs/identify/
  columba identify --link udpin:127.0.0.1:14550 --origin home
      a real plane, from the ground on
  columba identify field.toml --link udpin:127.0.0.1:14550
      the vehicles of your own scenario, at its expected speed, course and altitude, without its obstacles
  columba identify --tlog flight.tlog
      from a log of commands and positions; the airframe files are written beside it

It takes about five minutes and 1.5 km at 20 m/s. A scenario names the file: airframe = \"airframe-1.toml\".

Exit status: 0 speed, course and altitude of every vehicle are known, 1 one is not (which is printed, and why), 2 the \
arguments or a file are wrong.";

/// Of `columba view`.
pub const VIEW: &str = "\
Examples:
  columba view
      whoever sends telemetry to UDP 14550
  columba view --link tcp:127.0.0.1:5760 --link udpin:127.0.0.1:14560
      two links on one page
  columba view --plans --link tcp:127.0.0.1:5760
      Draws missions, fences, rally points and homes too: asks each autopilot once.
  columba view --silent --link udpin:0.0.0.0:14550
      from other machines too, and nothing is sent to them
  columba view runs/paper/flight.tlog
      plays a log back, with pause, speed, scrub and step
  columba view one.tlog two.tlog --view 8080
      two logs together, on a port of your choice

The program prints the address of the page and runs until Ctrl-C.";

/// Of `columba share`.
pub const SHARE: &str = "\
Examples:
  columba share runs/paper
      runs/paper/moving.png for a README or a talk, and runs/paper/still.png
  columba share runs/paper --width 480 --seconds 5
      smaller and shorter";

/// Of `columba compare`.
pub const COMPARE: &str = "\
Examples:
  columba compare
      MSLPIO, MPIO and NSGA-II over 100 flights each; the report is compare/paper/report.html
  columba compare --seeds 101..1000 --optimizers mslpio,mpio,nsga2,slpio
      other seeds, and a fourth optimiser
  columba compare config/paper.toml mine.toml --set look_ahead.horizon_s=1.5
      two scenarios, each with a shorter look-ahead
  columba compare --contenders settings.toml --seeds 20 --out short
      settings of your own against each other

A file of contenders has a table [[contender]] for each, with a name and any tables of a scenario file, which override \
those
of the scenario:
  [[contender]]
  name = \"shorter look-ahead\"
  look_ahead.horizon_s = 1.5
  optimizer.algorithm = \"nsga2\"

The folder holds every flight as soon as it is flown: the same command, started again, goes on where it was interrupted.
docs/compare.md describes every file and figure.

Exit status: 0 every flight is flown (a collision is a result here and no failure), 1 interrupted, 2 the arguments or \
a file
are wrong.";

/// Of `columba check`.
pub const CHECK: &str = "\
Examples:
  columba check field.toml
  columba check config/*.toml contenders.toml

Every fault of a file is told, one a line: file, line, key, value and what would be right. docs/scenario.md describes \
every key.
Contenders are checked over the paper's flight.

Exit status: 0 all files are good, 2 one is not.";

/// Of `columba suites`.
pub const SUITES: &str = "\
Examples:
  columba suites
      everything, 31 seeds, 25000 evaluations: about 10 s; in runs/suites/
  columba suites --problems zdt1,dtlz2 --optimizers mslpio,nsga2 --seeds 5
      two problems, two optimisers
  columba suites --dimensions 3 --population 50 --generations 13
      the budget of one decision in a flight: 650 evaluations of 3 variables

Every optimiser evaluates population x generations candidates and ends with a front of at most one population. With \
the same
seeds all files have the same bytes, with any number of threads, except timings.parquet, which is wall time (--threads 1
measures best).

Exit status: 0 done, 2 the arguments are wrong.";

/// Of `columba completions`.
pub const COMPLETIONS: &str = "\
Examples:
  columba completions bash > ~/.local/share/bash-completion/completions/columba
  columba completions zsh > ~/.zfunc/_columba
  columba completions fish > ~/.config/fish/completions/columba.fish";

/// Of `columba man`.
pub const MAN: &str = "\
Examples:
  columba man > columba.1 && man ./columba.1
  columba man run > columba-run.1";

#[cfg(test)]
mod tests {
    use super::*;
    use crate::args::Cli;

    /// Every example is a command line that the program takes.
    #[test]
    fn the_examples_are_command_lines() {
        let mut examples = 0;
        for text in [RUN, VEHICLES, FLY, IDENTIFY, VIEW, SHARE, COMPARE, CHECK, SUITES, COMPLETIONS, MAN] {
            for line in text.lines().filter(|line| line.starts_with("  columba ")) {
                // What the shell does with a command is not the program's.
                let command = line.split(" > ").next().unwrap();
                for command in command.split(" & ") {
                    Cli::read(command.split_whitespace()).unwrap_or_else(|error| panic!("{command}: {error}"));
                    examples += 1;
                }
            }
        }
        assert!(examples > 25, "{examples}");
    }
}
