//! Many vehicles: swarm files, groups and networks, parameters.

use super::*;
use std::fs;

fn no_vehicle() -> String {
    GOOD.replacen("[[vehicle]]\nx_m = 0.0\ny_m = 0.0\naltitude_m = 50.0\nspeed_mps = 10.0\n", "", 1)
}

/// A scenario of so many vehicles with a table `[link]`.
fn many(count: usize, link: &str) -> String {
    format!("{}[vehicles]\ncount = {count}\n[link]\n{link}\n", no_vehicle())
}

/// ArduPilot's own example.
const SWARM: &str = "#instance=East,North,Up(Offset in meters),Absolute Heading\n1=20,20,0,90\n2=40,0,0,45\n\
                     3=-20,-20,0,225\n4=-80,0,20,0\n5=0,-100,-10,0\n";

/// What a scenario beside a swarm file becomes.
fn load_swarm(swarm: &str, table: &str, over: &[Layer]) -> Result<Scenario, String> {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("swarm.txt"), swarm).unwrap();
    let scenario = folder.path().join("field.toml");
    fs::write(&scenario, format!("{}{table}\n", no_vehicle())).unwrap();
    let place = format!("{}/", folder.path().display());
    load(Some(&scenario), over).map_err(|error| error.to_string().replace(&place, ""))
}

const BY_FILE: &str = "[vehicles]\npattern = \"file\"\nfile = \"swarm.txt\"";

#[test]
fn a_swarm_file_places_every_vehicle() {
    let scenario = load_swarm(SWARM, BY_FILE, &[]).unwrap();
    let place = |start: &flight_model::State| {
        (start.y_m, start.x_m, start.altitude_m, start.course_rad.to_degrees().round(), start.speed_mps)
    };
    let places: Vec<_> = scenario.starts.iter().map(place).collect();
    assert_eq!(
        places,
        [
            (20.0, 20.0, 50.0, 90.0, 10.0),
            (40.0, 0.0, 50.0, 45.0, 10.0),
            (-20.0, -20.0, 50.0, -135.0, 10.0),
            (-80.0, 0.0, 70.0, 0.0, 10.0),
            (0.0, -100.0, 40.0, 0.0, 10.0),
        ]
    );
    assert_eq!(load_swarm(SWARM, BY_FILE, &flags("vehicles --count 2")).unwrap().starts, scenario.starts[..2]);
    let moved = load_swarm("7 = 0, 0, 0, 0 # the only one", &format!("{BY_FILE}\nx_m = 5\ny_m = -3"), &[]);
    assert_eq!(place(&moved.unwrap().starts[0]), (-3.0, 5.0, 50.0, 0.0, 10.0));
}

#[test]
fn a_swarm_file_is_refused_by_line_column_and_value() {
    for (swarm, words) in [
        ("1=20,20,0,90\n2=40,0;0,45", "swarm.txt:2:6: north = 0;0: must be a number from -100000 to 100000"),
        ("1=20,20,0,90\n2=40,0,0,361", "swarm.txt:2:10: heading = 361: must be a number from -360 to 360"),
        ("1=1,nan,0,0", "swarm.txt:1:5: north = nan: must be a number"),
        ("1=1,2,3", "swarm.txt:1:8: heading is missing: must be instance=east,north,up,heading"),
        ("1=1,2,3,4,5", "swarm.txt:1:10: a fifth number"),
        ("one=1,2,3,4", "swarm.txt:1:1: instance `one`: must be a whole number"),
        ("here", "swarm.txt:1:1: `here`: must be instance=east,north,up,heading"),
        ("1=0,0,0,0\n\n1=9,9,0,0", "swarm.txt:3:1: instance 1 is in line 1 already: must be there once"),
        ("# nobody", "swarm.txt: holds no vehicle"),
        ("1=0,0,0,0\n2=0.5,0,0,0", "vehicle 2 at x_m = 0, y_m = 0.5: must be at least 1 m from vehicle 1"),
    ] {
        let message = load_swarm(swarm, BY_FILE, &[]).unwrap_err();
        assert!(message.contains(words), "{swarm:?}: {message}");
    }
    for (table, words) in [
        ("[vehicles]\npattern = \"file\"", "field.toml:14: the key file is missing: must name the file"),
        ("[vehicles]\ncount = 2\nfile = \"swarm.txt\"", "[vehicles] names a file: must have pattern = \"file\""),
        (
            "[vehicles]\ncount = 6\npattern = \"file\"\nfile = \"swarm.txt\"",
            "vehicles.count = 6: must be at most 5: swarm.txt starts no more vehicles",
        ),
        ("[vehicles]\npattern = \"file\"\nfile = \"absent.txt\"", "absent.txt: file not found: must be a swarm file"),
    ] {
        let message = load_swarm(SWARM, table, &[]).unwrap_err();
        assert!(message.contains(words), "{table}: {message}");
    }
}

#[test]
fn flags_stand_in_for_the_files_vehicles() {
    let folder = tempfile::tempdir().unwrap();
    let swarm = folder.path().join("swarm.txt");
    fs::write(&swarm, SWARM).unwrap();
    let by_swarm = |more: &str| flags(&format!("vehicles --swarm {}{more}", swarm.display()));
    assert_eq!(load_text(GOOD, &by_swarm("")).unwrap().starts.len(), 5);
    assert_eq!(load_text(GOOD, &by_swarm(" --count 3")).unwrap().starts.len(), 3);
    let message = load_text(GOOD, &by_swarm(" --count 6")).unwrap_err();
    assert!(message.starts_with("--count 6: must be at most 5: "), "{message}");
    assert!(
        load_text(GOOD, &flags("vehicles --count 4 --pattern line"))
            .unwrap()
            .starts
            .iter()
            .all(|start| start.x_m == 0.0)
    );
}

#[test]
fn ports_of_groups_and_networks_are_counted() {
    for (count, link, words) in [
        (251, "vehicle_port = 65300", "link.vehicle_port = 65300: must be at most 65285 for 251 vehicles"),
        (251, "ground_port = 65535", "link.ground_port = 65535: must be at most 65534 for 2 networks"),
        (
            251,
            "vehicle_port = 2000\nground_port = 1999",
            "must be none of the vehicles' ports, 2000 to 2250; 2 networks",
        ),
        (2, "vehicles_per_port = 251", "link.vehicles_per_port = 251: must be a whole number from 1 to 250"),
        (2, "vehicles_per_port = 0", "link.vehicles_per_port = 0: must be a whole number from 1 to 250"),
    ] {
        let message = refusal_of(&many(count, link));
        assert!(message.contains(words), "{link}: {message}");
    }
    for (count, link) in [
        (251, "vehicle_port = 65534\nvehicles_per_port = 250"),
        (10_000, "vehicle_port = 2000\nground_port = 1960\nvehicles_per_port = 250"),
        (3, "vehicle_port = 2000\nground_port = 2003"),
    ] {
        let scenario = load_text(&many(count, link), &[]);
        assert_eq!(scenario.unwrap_or_else(|error| panic!("{link}: {error}")).starts.len(), count);
    }
}

#[test]
fn vehicles_on_an_autopilots_ports_have_its_parameters() {
    let file = |link: &str, rest: &str| format!("{}[vehicles]\ncount = 2\n[link]\n{link}\n{rest}", no_vehicle());
    let has = |link: &str, rest: &str| load_text(&file(link, rest), &[]).unwrap().stock_parameters;
    assert!(!has("", ""));
    assert!(has("ports = \"ardupilot\"", "") && has("ports = \"px4\"", "\n[autopilot]\npersonality = \"px4\""));
    assert!(has("", "\n[parameters]\nstock = true"));
    assert!(!has("ports = \"ardupilot\"", "\n[parameters]\nstock = false"));
    assert!(!has("ports = \"ardupilot\"", "\n[autopilot]\npersonality = \"generic\""), "nobody has built one");
}

#[test]
fn parameters_are_refused_by_line_or_flag() {
    for (line, words) in [
        ("WP_RADIUS = 0", "parameters.WP_RADIUS = 0: must be a number from 1 to 32767"),
        ("WP_RADIUS = nan", "parameters.WP_RADIUS = nan: must be a finite number"),
        ("WP_RADIUS = \"wide\"", "parameters.WP_RADIUS = \"wide\": must be a number"),
        ("SYSID_THISMAV = 3", "parameters.SYSID_THISMAV = 3: must be MAV_SYSID, as it is called now"),
        ("STAT_RUNTIME = 3", "parameters.STAT_RUNTIME = 3: must be left out: it is only read"),
        ("THR_MIN = 3", "parameters.THR_MIN = 3: must be the name of a parameter that the vehicle has"),
        ("stock = 1", "parameters.stock = 1: must be true or false"),
        (
            "stock = true\n[autopilot]\npersonality = \"generic\"",
            "parameters.stock = true: must be false or left out: there is no real autopilot of the personality generic",
        ),
    ] {
        let message = refusal_of(&and(&format!("[parameters]\nRTL_RADIUS = 50\n{line}")));
        assert_eq!(message, format!("field.toml:21: {words}"));
    }
    let table = and("[parameters]\nRTL_RADIUS = 50");
    let message = load_text(&table, &flags("vehicles --param RTL_RADIUS=1000000")).unwrap_err();
    assert_eq!(message, "--param RTL_RADIUS=1000000: must be a number from -32767 to 32767");
    let scenario = load_text(&table, &flags("vehicles --param WP_RADIUS=20")).unwrap();
    assert_eq!(
        scenario.parameters.into_iter().collect::<Vec<_>>(),
        [("RTL_RADIUS".into(), 50.0), ("WP_RADIUS".into(), 20.0)]
    );
    let two = format!("{}[vehicles]\ncount = 2\n[parameters]\nMAV_SYSID = 3\n", no_vehicle());
    assert!(refusal_of(&two).contains("parameters.MAV_SYSID = 3: must be left out: it is each vehicle's own"));
}
