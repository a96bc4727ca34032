//! Flags that stand in for keys of the scenario file: one row for each, and `--set` for every key.
//!
//! What the command line says lies over the file: first `--set`, in the order in which it was written, then these
//! flags.

use super::Preset;
use super::file::{Pattern, PortsKey};
use super::layer::Layer;
use clap::builder::{OsStringValueParser, PossibleValue, PossibleValuesParser};
use clap::parser::ValueSource;
use clap::{Arg, ArgAction, ArgMatches, Command, ValueEnum};
use optimizer::Algorithm;
use sim_vehicle::Personality;
use std::ffi::OsStr;

/// A flag and the key that it sets.
struct Flag {
    /// Without its dashes.
    name: &'static str,
    /// Its letter, if it has one.
    short: Option<char>,
    /// The key of the scenario file; the table that names a key, with [`Kind::Entry`].
    key: &'static str,
    kind: Kind,
    /// What help calls its value.
    value: &'static str,
    help: &'static str,
    /// The subcommands that have it.
    commands: &'static [&'static str],
    /// What else it sets, as TOML.
    also: &'static str,
    /// Keys of the file that it takes away.
    removes: &'static [&'static str],
    /// A flag without which this one means nothing.
    requires: Option<&'static str>,
    /// Flags that contradict it.
    conflicts: &'static [&'static str],
}

/// What a flag's value is.
enum Kind {
    /// A number.
    Number,
    /// A text, such as a path.
    Text,
    /// One of these.
    Choice(fn() -> Vec<PossibleValue>),
    /// None: the flag itself says `true`.
    Switch,
    /// A path; may be given several times, and adds to what lies beneath.
    Files,
    /// `NAME=VALUE`, an entry of a table; may be given several times.
    Entry,
}

/// The row that others differ from.
const FLAG: Flag = Flag {
    name: "",
    short: None,
    key: "",
    kind: Kind::Number,
    value: "N",
    help: "",
    commands: &[],
    also: "",
    removes: &[],
    requires: None,
    conflicts: &[],
};

const RUN: &str = "run";
const FLY: &str = "fly";
const IDENTIFY: &str = "identify";
const VEHICLES: &str = "vehicles";
const COMPARE: &str = "compare";

/// Every flag that stands in for a key. Where two set the same key, the lower row counts.
const FLAGS: &[Flag] = &[
    Flag {
        name: "preset",
        key: "preset",
        kind: Kind::Choice(preset_names),
        value: "NAME",
        help: "Which reading of the paper to start from; keys that the file sets change it",
        commands: &[RUN, FLY, IDENTIFY, COMPARE],
        ..FLAG
    },
    Flag {
        name: "seed",
        key: "scenario.seed",
        help: "Seed of every random number",
        commands: &[RUN, FLY, IDENTIFY, VEHICLES],
        ..FLAG
    },
    Flag {
        name: "optimizer",
        key: "optimizer.algorithm",
        kind: Kind::Choice(algorithm_keys),
        value: "NAME",
        help: "The optimiser that picks the weights",
        commands: &[RUN, FLY, IDENTIFY],
        ..FLAG
    },
    Flag {
        name: "duration",
        key: "scenario.duration_s",
        value: "S",
        help: "Flight time in seconds; the last control period is flown whole",
        commands: &[RUN, FLY, IDENTIFY],
        ..FLAG
    },
    Flag {
        name: "out",
        short: Some('o'),
        key: "output.folder",
        kind: Kind::Text,
        value: "FOLDER",
        help: "Folder of the run, new or empty; default: runs/ and the scenario's name, with a number if that is not \
               empty",
        commands: &[RUN, FLY, IDENTIFY],
        ..FLAG
    },
    Flag {
        name: "swarm",
        key: "vehicles.file",
        kind: Kind::Text,
        value: "FILE",
        help: "Starts from a file with a line instance=east,north,up,heading for each vehicle, as ArduPilot's \
               swarminit.txt; with --count only the first N",
        commands: &[VEHICLES],
        also: "vehicles.pattern = \"file\"",
        removes: &["vehicles.count"],
        ..FLAG
    },
    Flag {
        name: "count",
        key: "vehicles.count",
        help: "Number of vehicles in a grid (or in the file's own pattern), instead of the file's vehicles",
        commands: &[VEHICLES],
        ..FLAG
    },
    Flag {
        name: "pattern",
        key: "vehicles.pattern",
        kind: Kind::Choice(pattern_names),
        value: "NAME",
        help: "How the vehicles are laid out",
        commands: &[VEHICLES],
        removes: &["vehicles.file"],
        requires: Some("count"),
        conflicts: &["swarm"],
        ..FLAG
    },
    Flag {
        name: "airframe",
        key: "airframe",
        kind: Kind::Text,
        value: "NAME|FILE",
        help: "What the vehicles fly like: plane (the stock plane of the simulated autopilot), paper (5 to 15 m/s), or \
               a file with a table [airframe]. Default: paper with a scenario, in lockstep and for the paper's five; \
               plane otherwise",
        commands: &[VEHICLES],
        ..FLAG
    },
    Flag {
        name: "defaults",
        key: "parameters.files",
        kind: Kind::Files,
        value: "FILE",
        help: "Parameter file of ArduPilot, PX4 or a ground station: the vehicles start with its values. Parameters \
               that they do not use are kept for clients. May be given several times; the last value of a name counts",
        commands: &[VEHICLES],
        ..FLAG
    },
    Flag {
        name: "stock-parameters",
        key: "parameters.stock",
        kind: Kind::Switch,
        help: "Clients find all parameters of the real autopilot; those that the vehicles do not use change nothing. \
               So it is with an autopilot's --ports",
        commands: &[VEHICLES],
        ..FLAG
    },
    Flag {
        name: "param",
        key: "parameters",
        kind: Kind::Entry,
        value: "NAME=VALUE",
        help: "Sets a parameter of every vehicle at the start, as WP_LOITER_RAD=80; may be given several times",
        commands: &[VEHICLES],
        ..FLAG
    },
    Flag {
        name: "personality",
        key: "autopilot.personality",
        kind: Kind::Choice(personality_names),
        value: "AUTOPILOT",
        help: "The autopilot that the vehicles simulate",
        commands: &[VEHICLES],
        ..FLAG
    },
    Flag {
        name: "on-ground",
        key: "autopilot.on_ground",
        kind: Kind::Switch,
        help: "Vehicles start on the ground, disarmed and in MANUAL, instead of in the air",
        commands: &[VEHICLES],
        conflicts: &["lockstep"],
        ..FLAG
    },
    Flag {
        name: "host",
        key: "link.host",
        kind: Kind::Text,
        value: "ADDRESS",
        help: "IP address of this machine to which all sockets bind; 0.0.0.0 is all of them, for clients on other \
               machines",
        commands: &[RUN, FLY, IDENTIFY, VEHICLES],
        ..FLAG
    },
    Flag {
        name: "vehicle-port",
        key: "link.vehicle_port",
        value: "PORT",
        help: "First UDP port of the vehicles; 0: any free ports. Default: 14600 in real time, any free ports in \
               lockstep",
        commands: &[RUN],
        ..FLAG
    },
    Flag {
        name: "vehicle-port",
        key: "link.vehicle_port",
        value: "PORT",
        help: "First UDP port of the vehicles; each further vehicle has the next. 0: any free ports. Default: 14600",
        commands: &[VEHICLES],
        ..FLAG
    },
    Flag {
        name: "vehicle-port",
        key: "link.vehicle_port",
        value: "PORT",
        help: "First UDP port of the vehicles: the controller greets them there, instead of waiting for their \
               telemetry",
        commands: &[FLY, IDENTIFY],
        ..FLAG
    },
    Flag {
        name: "per-port",
        key: "link.vehicles_per_port",
        help: "Number of vehicles on each port, told apart by their system ids. Default: 1",
        commands: &[VEHICLES],
        ..FLAG
    },
    Flag {
        name: "ground-port",
        key: "link.ground_port",
        value: "PORT",
        help: "UDP port of the controller; 0: any free port. Default: 14550 for fly, any free port for run",
        commands: &[RUN, FLY, IDENTIFY],
        ..FLAG
    },
    Flag {
        name: "ground-port",
        key: "link.ground_port",
        value: "PORT",
        help: "UDP port to which telemetry is sent, the next one for each further network of 250 vehicles; 0: none, \
               only clients that connect get telemetry. Default: 14550",
        commands: &[VEHICLES],
        ..FLAG
    },
    Flag {
        name: "ports",
        key: "link.ports",
        kind: Kind::Choice(port_names),
        value: "LAYOUT",
        help: "Ports that the vehicles have: columba (UDP 14600 and up), ardupilot (TCP 5760 + 10 i, telemetry to UDP \
               14550 + 10 i), px4 (UDP 14580 + i to 14540 + i, and 18570 + i to 14550)",
        commands: &[VEHICLES],
        ..FLAG
    },
    Flag {
        name: "instance",
        key: "link.instance",
        help: "With an autopilot's ports, the instance i of the first vehicle, as ArduPilot's -I and PX4's -i. \
               Default: 0",
        commands: &[VEHICLES],
        ..FLAG
    },
    Flag {
        name: "multicast",
        key: "link.multicast",
        kind: Kind::Switch,
        help: "Vehicles are members of the multicast group 239.255.145.50:14550 too, as with ArduPilot's and \
               pymavlink's mcast:",
        commands: &[VEHICLES],
        conflicts: &["lockstep"],
        ..FLAG
    },
    Flag {
        name: "patience",
        key: "ground.patience_s",
        value: "S",
        help: "Seconds to wait before the flight for vehicles without telemetry. Default: 15, in lockstep 20",
        commands: &[RUN],
        ..FLAG
    },
    Flag {
        name: "loss",
        key: "link.loss",
        value: "SHARE",
        help: "Share of datagrams lost each way, 0 to 0.95",
        commands: &[RUN, FLY, IDENTIFY, VEHICLES],
        ..FLAG
    },
];

/// What help calls the flags of this file.
const HEADING: &str = "Scenario settings (override the file)";

fn preset_names() -> Vec<PossibleValue> {
    names::<Preset>()
}

fn pattern_names() -> Vec<PossibleValue> {
    names::<Pattern>()
}

fn algorithm_keys() -> Vec<PossibleValue> {
    Algorithm::ALL.iter().map(|algorithm| PossibleValue::new(algorithm.key())).collect()
}

fn personality_names() -> Vec<PossibleValue> {
    Personality::ALL.into_iter().map(|personality| PossibleValue::new(personality.name())).collect()
}

fn port_names() -> Vec<PossibleValue> {
    names::<PortsKey>()
}

fn names<T: ValueEnum>() -> Vec<PossibleValue> {
    T::value_variants().iter().filter_map(ValueEnum::to_possible_value).collect()
}

/// The program's command line with these flags, and `--set`, in every subcommand that has them.
pub fn add_to(command: Command) -> Command {
    command.mut_subcommands(|subcommand| {
        let name = subcommand.get_name().to_owned();
        let flags: Vec<Arg> =
            FLAGS.iter().filter(|flag| flag.commands.contains(&name.as_str())).map(Flag::arg).collect();
        if flags.is_empty() { subcommand } else { subcommand.args(flags).arg(set()) }
    })
}

fn set() -> Arg {
    Arg::new("set")
        .long("set")
        .value_name("KEY=VALUE")
        .action(ArgAction::Append)
        .value_parser(|text: &str| setting(text).map(|_| text.to_owned()))
        .help_heading(HEADING)
        .help(
            "Sets any key of docs/scenario.md, as look_ahead.horizon_s=1.5; may be given several times, the last \
               counts",
        )
}

/// What a subcommand's arguments lay over the scenario, the lowest layer first.
pub fn layers(command: &str, matches: &ArgMatches) -> Vec<Layer> {
    let settings = matches.try_get_many::<String>("set").ok().flatten().into_iter().flatten();
    let settings = settings.filter_map(|text| setting(text).ok());
    // A flag of the same name may mean something else to another subcommand, as --out of a comparison.
    let given = |flag: &&Flag| {
        flag.commands.contains(&command)
            && matches.try_contains_id(flag.name).unwrap_or(false)
            && matches.value_source(flag.name) == Some(ValueSource::CommandLine)
    };
    settings.chain(FLAGS.iter().filter(given).flat_map(|flag| flag.layers(matches))).collect()
}

/// The flag that sets a key, for messages.
pub fn of_key(key: &str) -> Option<String> {
    FLAGS.iter().find(|flag| flag.key == key).map(|flag| format!("--{}", flag.name))
}

/// The layer of `--set KEY=VALUE`, as in `look_ahead.horizon_s=0.5`. A value that is no TOML is a text.
///
/// # Errors
/// It has no key or no value.
pub fn setting(text: &str) -> Result<Layer, String> {
    let wanted = || "must be KEY=VALUE with a key of docs/scenario.md, such as look_ahead.horizon_s=1.5".to_owned();
    let (key, value) = text.split_once('=').ok_or_else(wanted)?;
    let (key, value) = (key.trim(), value.trim());
    let is_key = !key.is_empty() && key.chars().all(|c| c.is_ascii_alphanumeric() || "._-".contains(c));
    if !is_key || value.is_empty() {
        return Err(wanted());
    }
    let flag = format!("--set {text}");
    Layer::of_flag(&flag, key, &format!("{key} = {value}"))
        .or_else(|_| Layer::of_flag(&flag, key, &format!("{key} = {}", quoted(value))))
        .map_err(|_| wanted())
}

fn quoted(text: &str) -> String {
    toml_edit::Value::from(text).to_string()
}

impl Flag {
    fn arg(&self) -> Arg {
        let arg = Arg::new(self.name)
            .long(self.name)
            .help(format!("{} [{}]", self.help, self.key))
            .help_heading(HEADING)
            .conflicts_with_all(self.conflicts);
        let arg = match self.short {
            Some(short) => arg.short(short),
            None => arg,
        };
        let arg = match self.requires {
            Some(other) => arg.requires(other),
            None => arg,
        };
        match &self.kind {
            Kind::Switch => arg.action(ArgAction::SetTrue),
            Kind::Choice(names) => arg.value_name(self.value).value_parser(PossibleValuesParser::new(names())),
            Kind::Number => {
                arg.value_name(self.value).value_parser(OsStringValueParser::new()).allow_negative_numbers(true)
            }
            Kind::Text => arg.value_name(self.value).value_parser(OsStringValueParser::new()),
            Kind::Files => {
                arg.value_name(self.value).value_parser(OsStringValueParser::new()).action(ArgAction::Append)
            }
            Kind::Entry => arg.value_name(self.value).value_parser(entry).action(ArgAction::Append),
        }
    }

    /// The layer of each value that it was given.
    fn layers(&self, matches: &ArgMatches) -> Vec<Layer> {
        match self.kind {
            Kind::Switch => {
                let text = format!("--{}", self.name);
                self.layer(&text, self.key, "true").into_iter().collect()
            }
            _ => matches.get_raw(self.name).into_iter().flatten().filter_map(|value| self.layer_of(value)).collect(),
        }
    }

    fn layer_of(&self, raw: &OsStr) -> Option<Layer> {
        let value = raw.to_string_lossy();
        let text = format!("--{} {value}", self.name);
        let layer = match self.kind {
            Kind::Entry => {
                let (name, value) = value.split_once('=')?;
                self.layer(&text, &format!("{}.{}", self.key, name.trim()), &number(value.trim()))
            }
            Kind::Files => self.layer(&text, self.key, &format!("[{}]", quoted(&value))),
            Kind::Number => self.layer(&text, self.key, &number(value.trim())),
            _ => self.layer(&text, self.key, &quoted(&value)),
        };
        layer.map(|layer| layer.with_raw(raw.to_owned()))
    }

    fn layer(&self, text: &str, key: &str, value: &str) -> Option<Layer> {
        let toml = format!("{key} = {value}\n{}", self.also);
        Layer::of_flag(text, key, &toml).ok().map(|layer| layer.removing(self.removes))
    }
}

/// A number as TOML has it. What is none becomes a text, and is refused as one.
fn number(text: &str) -> String {
    let is_number = text.parse::<toml_edit::Value>().is_ok_and(|value| value.is_integer() || value.is_float());
    if is_number { text.to_owned() } else { quoted(text) }
}

/// The form of `NAME=VALUE`; the program says which names and values there are.
fn entry(text: &str) -> Result<String, String> {
    let is_name = |name: &str| !name.is_empty() && name.chars().all(|c| c.is_ascii_alphanumeric() || "_-".contains(c));
    let parts =
        text.split_once('=').filter(|(name, value)| is_name(name.trim()) && value.trim().parse::<f64>().is_ok());
    parts.map(|_| text.to_owned()).ok_or_else(|| "must be NAME=VALUE, the value a number".to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    const MANUAL: &str = include_str!("../../../../docs/scenario.md");

    #[test]
    fn the_folder_of_a_comparison_is_no_layer_of_its_flights() {
        let layers = |line: &str| {
            let words = line.split(' ').map(std::ffi::OsString::from);
            crate::args::Cli::read(words).unwrap().layers.iter().map(Layer::toml).collect::<String>()
        };
        assert!(layers("columba run --out here").contains("output.folder"));
        assert_eq!(layers("columba compare --out here"), "");
        assert!(layers("columba compare --out here --set law.formation_gain=0.21").contains("formation_gain"));
    }

    /// A flag whose key is none would be refused by every scenario.
    #[test]
    fn every_flag_sets_a_key_of_the_manual() {
        for flag in FLAGS {
            let (table, key) = flag.key.rsplit_once('.').unwrap_or(("", flag.key));
            let section = match table {
                "" => "## Top of the file".to_owned(),
                table => format!("## [{table}]\n"),
            };
            // A table of its own entries has no row for them.
            let (section, key) =
                if flag.key == "parameters" { ("## [parameters]\n".to_owned(), "files") } else { (section, key) };
            let rest = MANUAL.split(&section).nth(1).unwrap_or_else(|| panic!("{section}"));
            let text = rest.split("\n## ").next().unwrap();
            assert!(text.contains(&format!("`{key}`")), "--{}: {}", flag.name, flag.key);
        }
    }
}
