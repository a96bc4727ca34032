//! First phase: who is there, and which vehicle of the scenario each of them is.

use super::{Phase, preflight};
use crate::station::told::Weight;
use crate::station::{Station, number};
use std::time::Duration;

/// Further autopilots may still speak up for so long after the last new one.
const SETTLE: Duration = Duration::from_secs(2);

/// Waits until every vehicle of the scenario has sent a heartbeat.
#[derive(Default)]
pub struct Connect {
    /// How many are heard, and since when.
    heard: Option<(usize, Duration)>,
    began: Option<Duration>,
}

impl Connect {
    pub(super) fn step(mut self, station: &mut Station, now: Duration) -> Phase {
        let began = *self.began.get_or_insert(now);
        if let Some(stop) = station.stopped().cloned() {
            station.told.tell(now.as_secs_f64(), None, Weight::Fault, format!("{} before anybody was armed", stop.why));
            return Phase::Over(None);
        }
        let heard = station.vehicles.len();
        if self.heard.is_none_or(|(count, _)| count != heard) {
            self.heard = Some((heard, now));
        }
        let settled = self.heard.is_some_and(|(_, since)| now.saturating_sub(since) >= SETTLE);
        match choose(station, settled) {
            Ok(Some(ids)) => {
                assign(station, &ids);
                return self.check_kinds(station, now);
            }
            Ok(None) => {}
            Err(fault) => {
                station.told.tell(now.as_secs_f64(), None, Weight::Fault, fault);
                return Phase::Over(None);
            }
        }
        let waited = now.saturating_sub(began);
        if waited > station.settings.connect_patience {
            let fault = silent(station, waited);
            station.told.tell(now.as_secs_f64(), None, Weight::Fault, fault);
            return Phase::Over(None);
        }
        Phase::Connect(self)
    }

    /// Tells who is who; a kind that cannot be flown ends it here.
    fn check_kinds(self, station: &mut Station, now: Duration) -> Phase {
        let mut faults = Vec::new();
        for index in station.crew() {
            let vehicle = &station.vehicles[index];
            let number = number(index);
            match vehicle.flyable() {
                Some(Ok(driver)) => {
                    let text = format!("is system {}: {}", vehicle.id(), driver.kind().name());
                    station.told.tell(now.as_secs_f64(), Some(number), Weight::Note, text);
                }
                Some(Err(error)) => faults.push((number, format!("is system {}: {error}", vehicle.id()))),
                None => faults.push((number, format!("is system {}: no heartbeat", vehicle.id()))),
            }
        }
        if faults.is_empty() {
            return Phase::Preflight(preflight::Preflight::new(now));
        }
        for (number, fault) in faults {
            station.told.tell(now.as_secs_f64(), Some(number), Weight::Fault, fault);
        }
        Phase::Over(None)
    }
}

/// The system ids of the scenario's vehicles in their order, once they are known.
fn choose(station: &Station, settled: bool) -> Result<Option<Vec<u8>>, String> {
    let wanted = station.scenario.starts.len();
    let mut heard: Vec<u8> =
        station.vehicles.iter().filter(|vehicle| vehicle.flyable().is_some()).map(|vehicle| vehicle.id()).collect();
    heard.sort_unstable();
    if let Some(ids) = &station.settings.system_ids {
        return Ok(ids.iter().all(|id| heard.contains(id)).then(|| ids.clone()));
    }
    let in_order: Vec<u8> = (1..=wanted.min(255)).map(|id| id as u8).collect();
    if in_order.len() == wanted && in_order.iter().all(|id| heard.contains(id)) {
        return Ok(Some(in_order));
    }
    match heard.len() {
        count if !settled || count < wanted => Ok(None),
        count if count == wanted => Ok(Some(heard)),
        count => {
            let ids: Vec<String> = heard.iter().map(u8::to_string).collect();
            Err(format!(
                "{count} autopilots are heard, systems {}, and the scenario has {wanted} vehicles: name them in its \
                 order (--systems {})",
                ids.join(", "),
                ids[..wanted].join(",")
            ))
        }
    }
}

/// Puts the vehicles into the scenario's order.
fn assign(station: &mut Station, ids: &[u8]) {
    for vehicle in &mut station.vehicles {
        vehicle.take_slot(ids.iter().position(|id| *id == vehicle.id()));
    }
    station.vehicles.sort_by_key(|vehicle| vehicle.slot().unwrap_or(usize::MAX));
}

/// Who said nothing.
fn silent(station: &Station, waited: Duration) -> String {
    let heard: Vec<u8> = station.vehicles.iter().map(|vehicle| vehicle.id()).collect();
    let wanted = station.scenario.starts.len();
    let missing: Vec<String> = match &station.settings.system_ids {
        Some(ids) => ids
            .iter()
            .enumerate()
            .filter(|(_, id)| !heard.contains(id))
            .map(|(slot, id)| format!("{} (system {id})", slot + 1))
            .collect(),
        None if heard.is_empty() => (1..=wanted).map(|slot| slot.to_string()).collect(),
        None => {
            let heard: Vec<String> = heard.iter().map(u8::to_string).collect();
            return format!(
                "no telemetry on {} for {} s from {} of {wanted} vehicles; heard are systems {}",
                station.settings.links.join(", "),
                waited.as_secs(),
                wanted - heard.len().min(wanted),
                heard.join(", ")
            );
        }
    };
    let shown = missing.iter().take(8).cloned().collect::<Vec<_>>().join(", ");
    let more = if missing.len() > 8 { format!(" and {} more", missing.len() - 8) } else { String::new() };
    let plural = if missing.len() == 1 { "vehicle" } else { "vehicles" };
    let links = station.settings.links.join(", ");
    format!("no telemetry on {links} for {} s from {plural} {shown}{more}", waited.as_secs())
}
