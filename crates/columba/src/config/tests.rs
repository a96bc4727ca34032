//! Tests of scenario files: what is refused, where, and in which words.

use super::*;
use crate::args::Cli;

mod contenders;
mod manual;
mod many;

/// A small file that is good; tests change one line of it. `radius_m` is on line 18.
const GOOD: &str = r#"[scenario]
name = "small"
duration_s = 2.0

[flock]
expected_speed_mps = 10.0
expected_altitude_m = 50.0

[[vehicle]]
x_m = 0.0
y_m = 0.0
altitude_m = 50.0
speed_mps = 10.0

[[obstacle]]
x_m = 70.0
y_m = 8.0
radius_m = 8.0
"#;

fn load_text(text: &str, over: &[Layer]) -> Result<Scenario, String> {
    parse(&Source::new("field.toml", text), over).map_err(|error| error.to_string())
}

/// What a command line lays over its file.
fn flags(arguments: &str) -> Vec<Layer> {
    let arguments = ["columba"].into_iter().chain(arguments.split(' '));
    Cli::read(arguments).unwrap_or_else(|error| panic!("{error}")).layers
}

fn refusal_of(text: &str) -> String {
    load_text(text, &[]).expect_err(text)
}

/// `GOOD` with a line replaced.
fn with(line: &str, by: &str) -> String {
    assert!(GOOD.contains(line), "{line}");
    GOOD.replacen(line, by, 1)
}

/// `GOOD` with something at its end, on line 19 and after.
fn and(more: &str) -> String {
    format!("{GOOD}{more}\n")
}

#[test]
fn the_small_file_and_the_built_in_one_are_good() {
    assert_eq!(load_text(GOOD, &[]).unwrap().starts.len(), 1);
    assert_eq!(load(None, &[]).unwrap().starts.len(), 5);
}

/// What is wrong, the line that the message names (0: none) and what it says.
#[test]
fn every_fault_is_told_by_line_key_value_and_what_would_be_right() {
    let vehicle = "[[vehicle]]\nx_m = 0.5\ny_m = 0\naltitude_m = 50\nspeed_mps = 10";
    let inside = "[[vehicle]]\nx_m = 70\ny_m = 9\naltitude_m = 50\nspeed_mps = 10";
    let no_vehicle = GOOD.replacen("[[vehicle]]\nx_m = 0.0\ny_m = 0.0\naltitude_m = 50.0\nspeed_mps = 10.0\n", "", 1);
    let table: &[(String, usize, &[&str])] = &[
        // Keys.
        (
            with("radius_m", "radus_m"),
            18,
            &["obstacle[1].radus_m: unknown key", "did you mean radius_m?", "[[obstacle]] has x_m, y_m, radius_m"],
        ),
        (
            with("[scenario]", "[scenari]"),
            1,
            &["scenari: unknown key", "did you mean scenario?", "a scenario file has preset, scenario"],
        ),
        (and("[law]\ngain = 1"), 20, &["law.gain: unknown key", "[law] has formation_gain"]),
        (
            with("duration_s = 2.0", "duration_s = 2.0\norigin = { lat = 3 }"),
            4,
            &["scenario.origin.lat: unknown key", "[scenario.origin] has latitude_deg"],
        ),
        (with("radius_m = 8.0", ""), 15, &["obstacle[1]: the key radius_m is missing"]),
        (
            with("[flock]\nexpected_speed_mps = 10.0\nexpected_altitude_m = 50.0", ""),
            1,
            &["the table [flock] is missing"],
        ),
        (
            with("radius_m = 8.0", "radius_m = 8.0\nradius_m = 9.0"),
            19,
            &["`radius_m = 9.0`: duplicate key", "must be written once"],
        ),
        // Types.
        (with("radius_m = 8.0", "radius_m = \"wide\""), 18, &["obstacle[1].radius_m = \"wide\": must be a number"]),
        (
            with("duration_s = 2.0", "duration_s = 2.0\nseed = -1"),
            4,
            &["scenario.seed = -1: must be a whole number, 0 or greater"],
        ),
        (with("duration_s = 2.0", "duration_s = 2.0\nseed = 1.5"), 4, &["scenario.seed = 1.5: must be a whole number"]),
        (with("\"small\"", "7"), 2, &["scenario.name = 7: must be a text in quotes"]),
        (and("[autopilot]\narmed = 1"), 20, &["autopilot.armed = 1: must be true or false"]),
        (and("[link]\nground_port = 70000"), 20, &["link.ground_port = 70000: must be a whole number from 0 to 65535"]),
        (
            format!("preset = \"litteral\"\n{GOOD}"),
            1,
            &["preset = \"litteral\": must be \"default\", \"paper\" or \"literal\"; did you mean \"literal\"?"],
        ),
        (
            with("duration_s = 2.0", "duration_s = 2.0\ncontrol_period_s = 0.01") + "[look_ahead]\nhorizon_s = 40\n",
            21,
            &["look_ahead.horizon_s = 40: must be at most 3000 control periods, 30 s"],
        ),
        (and("[optimizer]\nalgorithm = \"pso\""), 20, &["optimizer.algorithm = \"pso\": must be"]),
        // Tables that are none.
        (with("[[vehicle]]", "[vehicle]"), 9, &["vehicle: must be one table for each, written [[vehicle]]"]),
        (with("[scenario]", "[[scenario]]"), 1, &["scenario: must not be an array"]),
        (
            with("duration_s = 2.0", "duration_s = 2.0\norigin = [1, 2, 3]"),
            4,
            &["scenario.origin: must not be an array"],
        ),
        (and("[[vehicles]]\ncount = 3"), 19, &["vehicles: must not be an array"]),
        (format!("law = 3\n{GOOD}"), 1, &["law = 3: must be a table, written [law]"]),
        // Grammar.
        (with("[flock]", "[flock"), 5, &["`[flock`: unclosed table"]),
        (with("radius_m = 8.0", "radius_m ="), 18, &["`radius_m =`: must have a number"]),
        (with("radius_m = 8.0", "radius_m = wide"), 18, &["`radius_m = wide`: must have a number"]),
        (with("radius_m = 8.0", "radius_m"), 18, &["`radius_m`: key with no value"]),
        (with("radius_m = 8.0", "radius_m = 1e400"), 18, &["overflow", "must be a number that 64 bits can hold"]),
        (
            with("radius_m = 8.0", "radius_m = 99999999999999999999999"),
            18,
            &["overflow", "must be a number that 64 bits can hold"],
        ),
        // Ranges.
        (
            with("radius_m = 8.0", "radius_m = -8"),
            18,
            &["obstacle[1].radius_m = -8: must be a number greater than 0 and at most 10000"],
        ),
        (with("radius_m = 8.0", "radius_m = 0"), 18, &["obstacle[1].radius_m = 0: must be a number greater than 0"]),
        (
            with("radius_m = 8.0", "radius_m = nan"),
            18,
            &["obstacle[1].radius_m = nan: must be a number greater than 0"],
        ),
        (with("radius_m = 8.0", "radius_m = inf"), 18, &["obstacle[1].radius_m = inf: must be"]),
        (with("radius_m = 8.0", "radius_m = 1e300"), 18, &["obstacle[1].radius_m = 1e300: must be"]),
        (with("x_m = 0.0", "x_m = -1e9"), 10, &["vehicle[1].x_m = -1e9: must be a number from -100000 to 100000"]),
        (
            with("duration_s = 2.0", "duration_s = -2"),
            3,
            &["scenario.duration_s = -2: must be a number from 0.5", "86400"],
        ),
        (
            with("duration_s = 2.0", "duration_s = 0.4"),
            3,
            &["scenario.duration_s = 0.4: must be a number from 0.5, one scenario.control_period_s"],
        ),
        (with("duration_s = 2.0", "duration_s = nan"), 3, &["scenario.duration_s = nan: must be"]),
        (
            with("duration_s = 2.0", "duration_s = 2\ncontrol_period_s = 0.333"),
            4,
            &["scenario.control_period_s = 0.333: must be a multiple of dynamics.integration_step_s = 0.01"],
        ),
        (
            with("duration_s = 2.0", "duration_s = 2\ncontrol_period_s = 1e-10"),
            4,
            &["scenario.control_period_s = 1e-10: must be a number from 0.001"],
        ),
        (with("\"small\"", "\" \""), 2, &["scenario.name = \" \": must be a name"]),
        (
            and("[dynamics]\nintegration_step_s = 0"),
            20,
            &["dynamics.integration_step_s = 0: must be a number from 0.001 to 0.1"],
        ),
        (
            and("[dynamics]\nintegration_step_s = 0.0015"),
            20,
            &["dynamics.integration_step_s = 0.0015: must be whole milliseconds"],
        ),
        (
            and("[dynamics]\nintegration_step_s = 0.03"),
            1,
            &["scenario.control_period_s = 0.5 (by default): must be a multiple"],
        ),
        (
            and("[dynamics]\nspeed_min_mps = nan"),
            20,
            &["dynamics.speed_min_mps = nan: must be a number from 0.1 to 300"],
        ),
        (
            and("[optimizer.mslpio]\niterations = 500"),
            19,
            &["optimizer.mslpio.removed_per_iteration = 2 (by default): must be such that a pigeon is left"],
        ),
        (
            and("[optimizer.mpio]\nvelocity_limit = 0"),
            20,
            &["optimizer.mpio.velocity_limit = 0: must be above 0 and at most 1"],
        ),
        (
            and("[optimizer]\nnsga2 = { population = 51 }"),
            20,
            &["optimizer.nsga2.population = 51: must be even, from 2 to 1000000"],
        ),
        (
            with("[[obstacle]]\nx_m = 70.0\ny_m = 8.0\nradius_m = 8.0\n", "[obstacles]\ncount = 900\n"),
            16,
            &["obstacles.count = 900: must be at most about"],
        ),
        (and("[obstacles]\ncount = 2"), 19, &["[obstacles] stands beside [[obstacle]]: must be either"]),
        (and("[law]\nsafe_distance_m = 0"), 20, &["law.safe_distance_m = 0: must be a number greater than 0"]),
        (
            and("[look_ahead]\nneighbours_max = 0"),
            20,
            &["look_ahead.neighbours_max = 0: must be a whole number from 1 to 64"],
        ),
        (and("[link]\nhost = \"nowhere\""), 20, &["link.host = \"nowhere\": must be an IP address"]),
        (and("[link]\nloss = 1"), 20, &["link.loss = 1: must be a number from 0 to 0.95"]),
        (
            and("[link]\nvehicle_port = 14600\nground_port = 14600"),
            21,
            &["link.ground_port = 14600: must be none of the vehicles' ports, 14600 to 14600"],
        ),
        (and("[autopilot]\nattitude_hz = 100"), 20, &["autopilot.attitude_hz = 100: must be a number from 0 to 80"]),
        (and("[output]\nfolder = \"\""), 20, &["output.folder = \"\": must be a folder's name"]),
        (
            format!("law.safe_distance_m = -1\n{GOOD}"),
            1,
            &["law.safe_distance_m = -1: must be a number greater than 0"],
        ),
        (with("radius_m = 8.0", "\"radius_m\" = -8"), 18, &["obstacle[1].radius_m = -8: must be"]),
        (
            GOOD.replace('\n', "\r\n").replace("radius_m = 8.0", "radius_m = -8"),
            18,
            &["obstacle[1].radius_m = -8: must be"],
        ),
        (and("[weights]\nmin = 100"), 19, &["weights.max = 3 (by default): must be a number greater than 100"]),
        (
            with(
                "duration_s = 2.0",
                "duration_s = 86400\ncontrol_period_s = 0.001\n[dynamics]\nintegration_step_s = 0.001",
            ),
            3,
            &["scenario.duration_s = 86400: must be at most 20000: a flight keeps"],
        ),
        // What no single setting shows.
        (no_vehicle, 0, &["field.toml: the flock is empty: must have at least one [[vehicle]]"]),
        (and("[vehicles]\ncount = 3"), 19, &["[vehicles] stands beside [[vehicle]]: must be either"]),
        (
            and(vehicle),
            19,
            &["vehicle 2 at x_m = 0.5, y_m = 0: must be at least 1 m from vehicle 1, which starts 0.50 m away"],
        ),
        (and(inside), 19, &["vehicle 2 at x_m = 70, y_m = 9: must be outside obstacle 1, 7.00 m inside"]),
    ];
    for (text, line, words) in table {
        let message = refusal_of(text);
        let place = if *line == 0 { "field.toml: ".to_owned() } else { format!("field.toml:{line}: ") };
        assert!(message.starts_with(&place), "{message}\nshould be at {place}");
        assert_eq!(message.lines().count(), 1, "{message}");
        for word in *words {
            assert!(message.contains(word), "{message}\nshould say: {word}");
        }
    }
}

#[test]
fn a_speed_out_of_the_limits_is_told_for_the_vehicle_that_has_it() {
    let text = format!(
        "{}[dynamics]\nspeed_max_mps = 9.0\n",
        GOOD.replace("expected_speed_mps = 10.0", "expected_speed_mps = 8.0")
    );
    assert_eq!(refusal_of(&text), "field.toml:13: vehicle[1].speed_mps = 10.0: must be a number from 5 to 9");
}

#[test]
fn limits_that_leave_nothing_between_them_are_refused() {
    let message = refusal_of(&and("[dynamics]\nspeed_min_mps = 300"));
    assert!(
        message.contains("field.toml:19: dynamics.speed_max_mps = 15 (by default): must be a number greater than 300"),
        "{message}"
    );
}

#[test]
fn faults_are_told_all_at_once_in_the_order_of_their_lines() {
    let text = with("radius_m = 8.0", "radius_m = -1").replace("altitude_m = 50.0\nspeed", "altitude_m = 1e9\nspeed");
    let message = refusal_of(&text);
    let lines: Vec<&str> = message.lines().collect();
    assert_eq!(lines.len(), 2, "{message}");
    assert!(
        lines[0].starts_with("field.toml:12: vehicle[1].altitude_m = 1e9") && lines[1].starts_with("field.toml:18: "),
        "{message}"
    );
}

#[test]
fn of_very_many_faults_the_rest_is_counted() {
    let bad = "[[obstacle]]\nx_m = 0\ny_m = 500\nradius_m = -1\n".repeat(50);
    let message = refusal_of(&and(&bad));
    assert_eq!(message.lines().count(), 21);
    assert!(message.ends_with("field.toml: and 30 faults more"), "{message}");
}

#[test]
fn a_value_from_the_command_line_is_blamed_on_its_flag() {
    let message =
        |arguments: &str| load_text(&and("[link]\nvehicle_port = 14600"), &flags(arguments)).expect_err(arguments);
    for (arguments, told) in [
        ("run --duration 0.1", "--duration 0.1: must be a number from 0.5"),
        ("run --loss 2", "--loss 2: must be a number from 0 to 0.95"),
        ("run --loss x", "--loss x: must be a number"),
        ("run --seed -1", "--seed -1: must be a whole number, 0 or greater"),
        ("fly --ground-port 70000", "--ground-port 70000: must be a whole number from 0 to 65535"),
        ("vehicles --vehicle-port 65535 --count 9", "--vehicle-port 65535: must be at most 65527 for 9 vehicles"),
        ("run --ground-port 14600", "--ground-port 14600: must be none of the vehicles' ports"),
        ("vehicles --count 0", "--count 0: must be a whole number from 1 to 10000"),
        ("run --host nowhere", "--host nowhere: must be an IP address"),
        ("run --set law.formation_gain=-1", "--set law.formation_gain=-1: must be a number from 0 to 1000"),
        ("run --set law.gain=1", "--set law.gain=1: unknown key: [law] has formation_gain"),
        ("run --set laws.gain=1", "--set laws.gain=1: laws: unknown key: did you mean law?"),
        (
            "run --set scenario.origin={latitude_deg=99}",
            "--set scenario.origin={latitude_deg=99}: scenario.origin.latitude_deg = 99: must be a number from -85 to \
             85",
        ),
    ] {
        let message = message(arguments);
        assert!(message.starts_with(told), "{arguments}: {message}");
        assert_eq!(message.lines().count(), 1, "{message}");
    }
    // The obstacle stands where the pattern would put a vehicle.
    let inside = load_text(&with("x_m = 70.0", "x_m = 0.0"), &flags("vehicles --count 2")).expect_err("refused");
    assert!(inside.starts_with("--count 2: vehicle 2 at x_m = 0, y_m = 6: must be outside obstacle 1"), "{inside}");
}

#[test]
fn a_fault_of_the_file_stays_the_files_beside_flags() {
    let message = load_text(&with("radius_m = 8.0", "radius_m = -8"), &flags("run --duration 4 --loss 0.1"))
        .expect_err("refused");
    assert!(message.starts_with("field.toml:18: obstacle[1].radius_m = -8"), "{message}");
}

#[test]
fn a_fault_that_a_layer_makes_of_the_file_names_both() {
    let over = flags("run --set dynamics.speed_max_mps=9.5 --seed 3");
    let message = load_text(GOOD, &over).expect_err("refused");
    assert_eq!(
        message,
        "field.toml:6: with --set dynamics.speed_max_mps=9.5: flock.expected_speed_mps = 10.0: must be a number from 5 \
         to 9.5\n\
         field.toml:13: with --set dynamics.speed_max_mps=9.5: vehicle[1].speed_mps = 10.0: must be a number from 5 to \
         9.5"
    );
}

#[test]
fn a_port_is_traced_to_the_flag_the_line_or_the_default() {
    let of =
        |text: &str, arguments: &str| load_text(text, &flags(arguments)).unwrap().provenance.of("link.ground_port");
    let written = and("[link]\nground_port = 14550");
    assert_eq!(of(&written, "run --ground-port 9"), "--ground-port 9");
    assert_eq!(of(&written, "run --set link.ground_port=9"), "--set link.ground_port=9");
    assert_eq!(of(&written, "run"), "field.toml:20: link.ground_port = 14550");
    assert_eq!(of(GOOD, "run"), "link.ground_port (by default; --ground-port sets it)");
}

/// The order of precedence, whatever the order of writing: the preset, the file, --set, flags.
#[test]
fn layers_have_one_order_of_precedence() {
    let text = with("duration_s = 2.0", "duration_s = 2.0\nseed = 2");
    let seed = |arguments: &str| load_text(&text, &flags(arguments)).unwrap().seed;
    assert_eq!(seed("run"), 2);
    assert_eq!(seed("run --set scenario.seed=3"), 3);
    assert_eq!([seed("run --seed 4 --set scenario.seed=3"), seed("run --set scenario.seed=3 --seed 4")], [4, 4]);
    assert_eq!(seed("run --set scenario.seed=5 --set scenario.seed=6"), 6, "the last counts");
    assert_eq!(seed("run --seed 18446744073709551615"), u64::MAX);
    let horizon_s =
        |file: &str, arguments: &str| load_text(&and(file), &flags(arguments)).unwrap().controller.look_ahead.horizon_s;
    assert_eq!(horizon_s("", "run"), 3.0);
    assert_eq!(horizon_s("", "run --preset literal"), 1e-3);
    assert_eq!(
        horizon_s("[look_ahead]\nhorizon_s = 2.0", "run --preset literal"),
        2.0,
        "the preset is beneath the file"
    );
    for arguments in
        ["run --preset literal --set look_ahead.horizon_s=4", "run --set look_ahead.horizon_s=4 --preset literal"]
    {
        assert_eq!(horizon_s("[look_ahead]\nhorizon_s = 2.0", arguments), 4.0);
    }
}

#[test]
fn starts_by_a_pattern_and_one_by_one_take_each_others_place() {
    assert_eq!(load_text(GOOD, &flags("run --set vehicles.count=4")).unwrap().starts.len(), 4);
    assert_eq!(load_text(GOOD, &flags("run --set obstacles.count=3")).unwrap().obstacles.len(), 3);
}

#[test]
fn a_value_of_a_preset_is_told_as_the_presets() {
    let message = load_text(GOOD, &flags("run --preset paper --set weights.min=50")).expect_err("refused");
    assert_eq!(
        message,
        "field.toml: with --set weights.min=50: weights.max = 3.0 (by preset \"paper\"): must be a number greater than \
         50 and at most 100"
    );
}

/// Faults of every kind in one file: each is told, and nothing that follows from another.
#[test]
fn every_fault_of_a_file_is_told() {
    let text = "[scenario]\nduration_s = \"long\"\nseeed = 3\n\n[flock]\nexpected_speed_mps = 10.0\n\n[[vehicle]]\n\
                x_m = 0\n\
                y_m = 0\naltitude_m = 50\nspeed_mps = 99\n[[vehicle]]\nx_m = 40\ny_m = 0\naltitude_m = 50\n\
                speed_mps = 10\n\
                [[vehicle]]\nx_m = 40.5\ny_m = 0\naltitude_m = 50\nspeed_mps = 10\n[[obstacle]]\nx_m = 1\ny_m = true\n\
                [optimizer]\nmslpio = { velocity_limit = 7, social_coefficient = -1 }\n[link]\nhost = 3\nloss = 2\n\
                [law]\n\
                obstacle_rule = \"any\"\n[parameters]\nNO_SUCH = 1\n[lnk]\nx = 1\n";
    let message = refusal_of(text);
    let told: Vec<(usize, &str)> = message
        .lines()
        .map(|line| {
            let mut parts = line.strip_prefix("field.toml:").unwrap().splitn(2, ": ");
            (parts.next().unwrap().parse().unwrap(), parts.next().unwrap())
        })
        .collect();
    let expected = [
        (1, "scenario: the key name is missing"),
        (2, "scenario.duration_s = \"long\": must be a number"),
        (3, "scenario.seeed: unknown key"),
        (5, "flock: the key expected_altitude_m is missing"),
        (12, "vehicle[1].speed_mps = 99: must be a number from 5 to 15"),
        (23, "obstacle[1]: the key radius_m is missing"),
        (25, "obstacle[1].y_m = true: must be a number"),
        (27, "optimizer.mslpio.social_coefficient = -1: must be a number from 0 to 1000"),
        (27, "optimizer.mslpio.velocity_limit = 7: must be above 0"),
        (29, "link.host = 3: must be a text in quotes"),
        (30, "link.loss = 2: must be a number from 0 to 0.95"),
        (32, "law.obstacle_rule = \"any\": must be \"blocking\" or \"nearest\""),
        (35, "lnk: unknown key: did you mean link?"),
    ];
    let is_told = |(line, words): &(usize, &str)| {
        told.iter().any(|(told_line, told_words)| told_line == line && told_words.starts_with(words))
    };
    for fault in &expected {
        assert!(is_told(fault), "{fault:?} is not in\n{message}");
    }
    assert_eq!(told.len(), expected.len(), "{message}");
}

#[test]
fn faults_beside_a_start_in_anothers_place_are_told_with_it() {
    let vehicle = "[[vehicle]]\nx_m = 0.5\ny_m = 0\naltitude_m = 50\nspeed_mps = 10\n[law]\nsafe_distance_m = 0";
    let message = refusal_of(&and(vehicle));
    let lines: Vec<&str> = message.lines().collect();
    assert!(lines[0].starts_with("field.toml:19: vehicle 2 at x_m = 0.5, y_m = 0: must be at least 1 m"), "{message}");
    assert!(lines[1].starts_with("field.toml:25: law.safe_distance_m = 0: must be"), "{message}");
    assert_eq!(lines.len(), 2);
}

#[test]
fn several_lines_that_are_no_toml_are_told_with_the_faults_of_the_others() {
    let text =
        with("duration_s = 2.0", "duration_s = wide").replace("x_m = 70.0", "x_m 70.0").replace("[flock]", "[flock")
            + "[law]\nsafe_distance_m = 0\n";
    let message = refusal_of(&text);
    let lines: Vec<&str> = message.lines().collect();
    assert_eq!(lines.len(), 4, "{message}");
    for (line, told) in lines.iter().zip([
        "field.toml:3: `duration_s = wide`: must have a number",
        "field.toml:5: `[flock`: unclosed table",
        "field.toml:16: `x_m 70.0`: ",
        "field.toml:20: law.safe_distance_m = 0: must be",
    ]) {
        assert!(line.starts_with(told), "{message}");
    }
}

#[test]
fn a_preset_is_the_base_of_what_the_tables_write() {
    let literal = controller::ControllerSettings::literal();
    for law in ["[law]\nformation_gain = 0.3", "law.formation_gain = 0.3"] {
        let text = match law.strip_prefix("law.") {
            Some(_) => format!("preset = \"literal\"\n{law}\n{GOOD}"),
            None => format!("preset = \"literal\"\n{GOOD}{law}\n"),
        };
        let settings = load_text(&text, &[]).unwrap().controller;
        assert_eq!(settings.law, controller::LawSettings { formation_gain: 0.3, ..literal.law.clone() });
        assert_eq!((settings.weights, settings.look_ahead), (literal.weights.clone(), literal.look_ahead.clone()));
    }
    // A table that is written back to its default is not the preset's any more.
    let text = format!("preset = \"literal\"\n{GOOD}[law]\nobstacle_rule = \"blocking\"\n");
    let law = load_text(&text, &[]).unwrap().controller.law;
    assert_eq!(law.obstacle_rule, controller::ObstacleRule::Blocking);
    assert_eq!(law.obstacle_margin_m, literal.law.obstacle_margin_m);
}

#[test]
fn a_preset_of_the_command_line_stands_in_for_the_files() {
    let scenario = load_text(&format!("preset = \"literal\"\n{GOOD}"), &flags("run --preset paper")).unwrap();
    assert_eq!(scenario.preset, Preset::Paper);
    assert_eq!(scenario.controller, controller::ControllerSettings::paper());
}

#[test]
fn a_wrong_type_over_a_preset_is_told_by_line() {
    let message = refusal_of(&format!("preset = \"literal\"\n{GOOD}[law]\nformation_gain = \"much\"\n"));
    assert_eq!(message, "field.toml:21: law.formation_gain = \"much\": must be a number");
}

#[test]
fn patterns_place_as_many_as_asked_and_apart() {
    let no_vehicle = GOOD.replacen("[[vehicle]]\nx_m = 0.0\ny_m = 0.0\naltitude_m = 50.0\nspeed_mps = 10.0\n", "", 1);
    for (pattern, apart_m) in [("line", 12.0), ("grid", 12.0), ("wedge", 12.0), ("random", 6.0)] {
        for count in [1, 2, 7, 60] {
            let text = format!(
                "{no_vehicle}[vehicles]\ncount = {count}\npattern = \"{pattern}\"\nx_m = -500.0\ncourse_deg = 30.0\n"
            );
            let starts = load_text(&text, &[]).unwrap().starts;
            assert_eq!(starts.len(), count);
            let (ahead_x, ahead_y) = (libm::cos(30f64.to_radians()), libm::sin(30f64.to_radians()));
            for (index, a) in starts.iter().enumerate() {
                assert!((a.x_m + 500.0) * ahead_x + a.y_m * ahead_y <= 1e-9, "{pattern}: none before the front");
                for b in &starts[..index] {
                    let (dx, dy) = (a.x_m - b.x_m, a.y_m - b.y_m);
                    assert!((dx * dx + dy * dy).sqrt() > apart_m - 1e-6, "{pattern} of {count}");
                }
            }
        }
    }
}

#[test]
fn a_pattern_that_reaches_too_far_is_refused() {
    let no_vehicle = GOOD.replacen("[[vehicle]]\nx_m = 0.0\ny_m = 0.0\naltitude_m = 50.0\nspeed_mps = 10.0\n", "", 1);
    let message = refusal_of(&format!("{no_vehicle}[vehicles]\ncount = 1000\npattern = \"line\"\nspacing_m = 1000\n"));
    assert!(message.starts_with("field.toml:14: vehicle 1 at "), "{message}");
    assert!(message.contains("must be within 100000 m of the origin"), "{message}");
}

proptest::proptest! {
    /// Whatever a file holds, it is a scenario or a message; never a panic.
    #[test]
    fn no_text_is_more_than_refused(text in "[\\[\\]a-z_=\".0-9\n -]{0,200}") {
        let _ = load_text(&text, &[]);
        let _ = load_text(&and(&text), &[]);
    }

    /// Cutting a good file anywhere gives a scenario or one message with a line or none.
    #[test]
    fn no_truncated_file_is_more_than_refused(length in 0..PAPER.len()) {
        if let Some(text) = PAPER.get(..length)
            && let Err(message) = load_text(text, &[])
        {
            proptest::prop_assert!(message.starts_with("field.toml"), "{}", message);
        }
    }
}
