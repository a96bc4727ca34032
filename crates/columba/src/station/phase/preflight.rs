//! Second phase: what each vehicle still needs before it may be armed; then one frame for all, and the limits compared.

use super::{Phase, arm_takeoff, handover, limits};
use crate::station::told::Weight;
use crate::station::vehicle::Vehicle;
use crate::station::vehicle::requests::RATE_WINDOW_S;
use crate::station::vehicle::track::distance_m;
use crate::station::{STALE_S, Station, frames, number};
use mavlink_bridge::kind::AutopilotKind;
use std::time::Duration;

/// The table of what is missing is looked at so often.
const LOOK: Duration = Duration::from_millis(100);
/// What is missing is told when it has been missing for so long, and has changed.
const TELL: Duration = Duration::from_secs(5);

/// Waits until all are ready.
pub struct Preflight {
    began: Duration,
    looked: Option<Duration>,
    told: Duration,
    has_frame: bool,
}

impl Preflight {
    pub(super) fn new(now: Duration) -> Self {
        Self { began: now, looked: None, told: now, has_frame: false }
    }

    pub(super) fn step(mut self, station: &mut Station, now: Duration) -> Phase {
        if let Some(stop) = station.stopped().cloned() {
            station.told.tell(now.as_secs_f64(), None, Weight::Fault, format!("{} before anybody was armed", stop.why));
            return Phase::Over(None);
        }
        if self.looked.is_some_and(|looked| now.saturating_sub(looked) < LOOK) {
            return Phase::Preflight(self);
        }
        self.looked = Some(now);
        // On the ground a place is known for good once the autopilot has set its home there.
        let is_placed = |vehicle: &Vehicle| {
            vehicle.heard().place().is_some() && (vehicle.heard().home.is_some() || !vehicle.on_ground())
        };
        if !self.has_frame && station.vehicles[station.crew()].iter().all(is_placed) {
            match self.take_frame(station, now) {
                Ok(()) => self.has_frame = true,
                Err(fault) => return refuse(station, now, vec![fault]),
            }
        }
        let doubled = station.vehicles.iter().any(|vehicle| vehicle.routes().is_doubled());
        let missing = missing(station, now);
        if self.has_frame && (doubled || missing.iter().all(Vec::is_empty)) {
            return self.check(station, now);
        }
        let waited = now.saturating_sub(self.began);
        if now.saturating_sub(self.told) >= TELL {
            self.told = now;
            for (slot, needs) in missing.iter().enumerate().filter(|(_, needs)| !needs.is_empty()) {
                let text = format!("waits for {}", needs.join(", "));
                station.told.once(now.as_secs_f64(), Some(number(slot)), &text.clone(), Weight::Note, text);
            }
        }
        if waited > station.settings.ready_patience {
            let mut faults = Vec::new();
            for (slot, needs) in missing.into_iter().enumerate().filter(|(_, needs)| !needs.is_empty()) {
                faults.push(format!(
                    "vehicle {} is not ready after {} s: {}",
                    number(slot),
                    waited.as_secs(),
                    needs.join(", ")
                ));
            }
            return refuse(station, now, faults);
        }
        Phase::Preflight(self)
    }

    fn take_frame(&self, station: &mut Station, now: Duration) -> Result<(), String> {
        let (scenario, settings) = (&station.scenario.frame, &station.settings);
        let (frame, note) = frames::choose(scenario, settings.origin_is_named, settings.origin, &station.vehicles)?;
        station.set_frame(frame);
        if let Some(note) = note {
            station.told.tell(now.as_secs_f64(), None, Weight::Note, note);
        }
        Ok(())
    }

    /// Contradictions and limits; then the first command.
    fn check(self, station: &mut Station, now: Duration) -> Phase {
        let mut faults =
            frames::contradictions(&station.frame, station.scenario.expected.altitude_m, &station.vehicles);
        let mut limits = station.scenario.dynamics.limits;
        let own = station.vehicles.iter().filter_map(|vehicle| Some((number(vehicle.slot()?), vehicle.limits()?)));
        let compared = limits::compare(&station.scenario.expected, &mut limits, own);
        station.limits = limits;
        for index in station.crew() {
            let dynamics = station.scenario.dynamics_of(index);
            station.vehicles[index].flies_by(dynamics, station.scenario.expected.speed_mps);
        }
        faults.extend(compared.faults);
        for note in compared.notes {
            station.told.once(now.as_secs_f64(), None, &note.clone(), Weight::Note, note);
        }
        for index in station.crew() {
            let vehicle = &station.vehicles[index];
            if let Some(version) = vehicle.version() {
                let text = format!("version {version}");
                station.told.once(now.as_secs_f64(), Some(number(index)), "version", Weight::Note, text);
            }
        }
        if !faults.is_empty() {
            return refuse(station, now, faults);
        }
        let separation_m = separation_m(station);
        let text = match separation_m {
            Some(separation_m) => format!("all are ready; the nearest two are {separation_m:.1} m apart"),
            None => "ready".to_owned(),
        };
        station.told.tell(now.as_secs_f64(), None, Weight::Note, text);
        if station.settings.dry_run {
            station.told.tell(now.as_secs_f64(), None, Weight::Note, "a dry run: nobody is commanded");
            return Phase::Over(None);
        }
        // Who flies already is taken over where the flock is; from anywhere else all gather first.
        let expected_m = station.scenario.expected.altitude_m;
        let flies_with_the_flock = |vehicle: &Vehicle| {
            let altitude_m = vehicle.track().last().map_or(f64::NAN, |sample| sample.state.altitude_m);
            !vehicle.on_ground()
                && (vehicle.follows() || !vehicle.heard().armed)
                && (altitude_m - expected_m).abs() < 6.0
        };
        if !station.vehicles[station.crew()].iter().all(flies_with_the_flock) {
            Phase::TakeOff(arm_takeoff::TakeOff::new(station, now))
        } else {
            Phase::HandOver(handover::HandOver::new(now))
        }
    }
}

fn refuse(station: &mut Station, now: Duration, faults: Vec<String>) -> Phase {
    for fault in faults {
        station.told.tell(now.as_secs_f64(), None, Weight::Fault, fault);
    }
    Phase::Over(None)
}

/// Least distance between two vehicles, m.
fn separation_m(station: &Station) -> Option<f64> {
    let states: Vec<_> = station.vehicles[station.crew()].iter().filter_map(|vehicle| vehicle.track().last()).collect();
    let pairs =
        states.iter().enumerate().flat_map(|(index, a)| states[..index].iter().map(move |b| (a.state, b.state)));
    pairs.map(|(a, b)| distance_m(&a, &b)).min_by(f64::total_cmp)
}

/// What each vehicle of the scenario still needs, in words.
pub fn missing(station: &Station, now: Duration) -> Vec<Vec<String>> {
    station.crew().map(|index| needs(&station.vehicles[index], station.position_hz(index), now)).collect()
}

fn needs(vehicle: &Vehicle, position_hz: f64, now: Duration) -> Vec<String> {
    let now_s = now.as_secs_f64();
    let mut needs = Vec::new();
    let Some(driver) = vehicle.driver() else { return vec!["a heartbeat".to_owned()] };
    let heard = vehicle.heard();
    let flies = !vehicle.on_ground();
    if vehicle.version().is_none() && vehicle.times_asked() < 4 {
        needs.push("its version".to_owned());
    }
    match vehicle.age_s(now_s) {
        None => needs.push("a position".to_owned()),
        Some(age_s) if age_s > STALE_S => needs.push(format!("a position (the last is {age_s:.1} s old)")),
        // One that flies already cannot wait.
        Some(_) if !flies => {
            if !vehicle.comes_at(position_hz, now_s) {
                let rate = vehicle.track().rate_hz(now_s, RATE_WINDOW_S);
                let comes = rate.map_or_else(|| "too few yet".to_owned(), |rate| format!("{rate:.1} come"));
                needs.push(format!("positions at {position_hz:.0} Hz ({comes})"));
            }
        }
        Some(_) => {}
    }
    if heard.home.is_none() && !flies {
        needs.push("its home".to_owned());
    }
    let needs_origin = matches!(driver.kind(), AutopilotKind::Px4Multicopter | AutopilotKind::Columba);
    if needs_origin && heard.local_origin_amsl_m.is_none() {
        needs.push("its local origin".to_owned());
    }
    if vehicle.limits().is_none() {
        needs.push("its parameters".to_owned());
    }
    if heard.prearm_ok == Some(false) && !heard.armed {
        let words = heard.words_since(now.saturating_sub(Duration::from_secs(35)));
        needs.push(
            words.map_or_else(|| "its pre-arm checks".to_owned(), |words| format!("its pre-arm checks ({words})")),
        );
    }
    needs
}
