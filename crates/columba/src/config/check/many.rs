//! What many vehicles need: places enough in their file, ports enough for them, parameters that each of them takes.

use super::COUNT_MAX;
use crate::config::Scenario;
use crate::config::fault::Faults;
use crate::config::file::{LinkTable, Pattern, PatternTable, PortsKey, ScenarioFile};
use crate::counted::counted;
use sim_vehicle::{NETWORK_VEHICLES_MAX, ParameterFault, VehicleSettings, port_index};
use std::collections::BTreeSet;

/// The parameter that no two vehicles of a network share.
const OWN_SYSTEM_ID: &str = "MAV_SYSID";

/// How many vehicles a pattern has, and whether its file has as many.
pub fn pattern_count(pattern: &PatternTable, faults: &mut Faults) {
    let is_file = pattern.pattern == Pattern::File;
    match (pattern.count, &pattern.file) {
        (_, None) if is_file => {
            let wanted = "must name the file of the pattern, as file = \"swarm.txt\"";
            faults.add_subject("vehicles", "the key file is missing", wanted);
        }
        (_, Some(_)) if !is_file => {
            faults.add_subject("vehicles.pattern", "[vehicles] names a file", "must have pattern = \"file\" beside it");
        }
        (None, None) => faults.add_subject(
            "vehicles",
            "vehicles.count: the key count is missing",
            format!("must be a whole number from 1 to {COUNT_MAX}"),
        ),
        (Some(count), Some(file)) if count > pattern.places.len() && count <= COUNT_MAX => {
            let wanted = format!("at most {}: {} starts no more vehicles", pattern.places.len(), file.display());
            faults.add("vehicles.count", count, wanted);
        }
        _ => {}
    }
    if pattern.count.is_some() || !is_file {
        faults.whole("vehicles.count", pattern.count.unwrap_or(1), 1, COUNT_MAX);
    }
}

/// One port for each vehicle or group, and one on the ground for each network.
pub fn ports(file: &ScenarioFile, faults: &mut Faults) {
    let (link, count) = (&file.link, file.count());
    faults.whole("link.vehicles_per_port", link.vehicles_per_port, 1, NETWORK_VEHICLES_MAX);
    // Counts that are at fault themselves have been told already.
    if !(1..=NETWORK_VEHICLES_MAX).contains(&link.vehicles_per_port) || !(1..=COUNT_MAX).contains(&count) {
        return;
    }
    if link.ports != PortsKey::Columba {
        autopilots_ports(link, count, faults);
        return;
    }
    let needed = port_index(count - 1, link.vehicles_per_port) + 1;
    let networks = count.div_ceil(NETWORK_VEHICLES_MAX);
    if let Some(port) = link.ground_port.filter(|&port| usize::from(port) + networks > 65_536) {
        let wanted = format!(
            "at most {} for {} of {NETWORK_VEHICLES_MAX} vehicles",
            65_536 - networks,
            counted(networks, "network")
        );
        faults.add("link.ground_port", port, wanted);
    }
    let Some(first) = link.vehicle_port.filter(|&port| port > 0) else { return };
    let (first, end) = (usize::from(first), usize::from(first) + needed);
    if end > 65_536 {
        faults.add(
            "link.vehicle_port",
            first,
            format!("at most {} for {}", 65_536 - needed, counted(count, "vehicle")),
        );
    }
    let overlaps = |port: usize| port > 0 && port < end && first < port + networks;
    if let Some(port) = link.ground_port.filter(|&port| overlaps(port.into())) {
        let ground =
            if networks > 1 { format!("; {networks} networks have a ground port each") } else { String::new() };
        let wanted = format!("none of the vehicles' ports, {first} to {}{ground}", end - 1);
        faults.add("link.ground_port", port, wanted);
    }
}

/// The ports of an autopilot are what they are, and each vehicle is alone on its own.
fn autopilots_ports(link: &LinkTable, count: usize, faults: &mut Faults) {
    const INSTANCE_MAX: usize = 5_000;
    faults.whole("link.instance", link.instance.into(), 0, INSTANCE_MAX);
    for (key, port) in [("link.vehicle_port", link.vehicle_port), ("link.ground_port", link.ground_port)] {
        if let Some(port) = port.filter(|&port| port > 0) {
            faults.add(key, port, "0 or left out: link.ports and link.instance say which ports there are");
        }
    }
    if link.vehicles_per_port > 1 {
        faults.add("link.vehicles_per_port", link.vehicles_per_port, "1: link.ports gives each vehicle its own ports");
    }
    let most = link.layout().vehicles_max();
    if count > most {
        let wanted = format!("must be at most {most}: these ports are enough for no more");
        faults.add_subject("link.ports", format!("{count} vehicles"), wanted);
    }
}

/// No list of parameters for an autopilot that nobody has built.
pub fn stock_parameters(file: &ScenarioFile, faults: &mut Faults) {
    let personality = file.autopilot.personality;
    if file.parameters.stock == Some(true) && !personality.has_stock_parameters() {
        let wanted = format!("false or left out: there is no real autopilot of the personality {personality}");
        faults.add("parameters.stock", true, wanted);
    }
}

/// Parameters that the vehicles have, with values that they take.
pub fn parameters(scenario: &Scenario, vehicles: &[VehicleSettings], faults: &mut Faults) {
    if scenario.parameters.is_empty() && scenario.parameter_files.is_empty() {
        return;
    }
    if let Some(value) = scenario.parameters.get(OWN_SYSTEM_ID).filter(|_| vehicles.len() > 1) {
        let key = format!("parameters.{OWN_SYSTEM_ID}");
        faults.add(key, value, "left out: it is each vehicle's own");
    }
    // Some ranges depend on how a vehicle starts.
    let mut told = BTreeSet::new();
    for settings in vehicles {
        for ParameterFault { name, value, wanted, place } in sim_vehicle::check_parameters(settings) {
            if !told.insert(name.clone()) {
                continue;
            }
            match place {
                Some(place) => faults.add_placed([(0, format!("{place}: {name} = {value}: must be {wanted}"))]),
                None => faults.add(format!("parameters.{name}"), value, wanted),
            }
        }
    }
}
