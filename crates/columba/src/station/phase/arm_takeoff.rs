//! Third phase: all are armed and take off together. Who is in the air climbs to a height of its own at once, and is on
//! its way to its lane while the others follow. There it circles until all have taken off.

use super::gather::Gather;
use super::{Phase, gather_phase, handover};
use crate::station::told::Weight;
use crate::station::{LOST_S, Station, number};
use flight_model::State;
use mavlink_bridge::kind::{AutopilotKind, Launch};
use std::time::Duration;

/// Arms, and waits until all fly.
pub struct TakeOff {
    began: Duration,
    gather: Gather,
    flying: Vec<bool>,
    /// The mode in which each was seen to take off.
    launch_modes: Vec<Option<u32>>,
}

impl TakeOff {
    pub(super) fn new(station: &Station, now: Duration) -> Self {
        let scenario = &station.scenario;
        let hovers = |index: usize| station.vehicles[index].driver().is_some_and(|driver| driver.kind().hovers());
        let mut gather = Gather::new(&scenario.starts, scenario.expected, &scenario.obstacles, &station.limits)
            .with_hovering(hovers);
        gather.hold(true);
        let count = scenario.starts.len();
        Self { began: now, gather, flying: vec![false; count], launch_modes: vec![None; count] }
    }

    pub(super) fn step(mut self, station: &mut Station, now: Duration) -> Phase {
        if station.stopped().is_some() {
            return Phase::end(None, now);
        }
        station.watch_modes(false, now);
        for index in station.crew() {
            if !station.vehicles[index].is_ours() {
                self.gather.leave(index);
                continue;
            }
            if !self.flying[index] {
                self.launch(station, index, now);
            }
        }
        let flying: Vec<usize> = (0..self.flying.len()).filter(|&index| self.flying[index]).collect();
        gather_phase::steer(&mut self.gather, station, &flying, now);
        let ours = station.crew().filter(|&index| station.vehicles[index].is_ours());
        let waiting: Vec<usize> = ours.filter(|&index| !self.flying[index]).collect();
        if waiting.is_empty() && station.settings.steps.is_some() && station.crew().len() == 1 {
            // One vehicle flies its steps from where it is.
            return Phase::HandOver(handover::HandOver::new(now));
        }
        if waiting.is_empty() {
            self.gather.hold(false);
            return Phase::Gather(gather_phase::GatherPhase::new(self.gather, now));
        }
        if now.saturating_sub(self.began) > station.settings.ready_patience {
            for index in waiting {
                let vehicle = &station.vehicles[index];
                let answer = vehicle.orders().answer("launch").unwrap_or("no answer");
                let words = vehicle.heard().words_since(self.began);
                let words = words.map(|words| format!(", {words}")).unwrap_or_default();
                // Where a vehicle is that is not heard, nobody knows.
                let silent_s = vehicle.age_s(now.as_secs_f64()).filter(|age_s| *age_s > LOST_S);
                let what = match silent_s {
                    Some(silent_s) => {
                        format!("is lost: nothing of its position for {silent_s:.0} s, and was not seen to fly")
                    }
                    None if vehicle.heard().armed => "did not leave the ground".to_owned(),
                    None => "was not armed".to_owned(),
                };
                let text = format!("{what} in {} s: {answer}{words}", station.settings.ready_patience.as_secs());
                station.told.tell(now.as_secs_f64(), Some(number(index)), Weight::Fault, text);
            }
            station.stop("not all took off", false);
            return Phase::end(None, now);
        }
        Phase::TakeOff(self)
    }

    fn launch(&mut self, station: &mut Station, index: usize, now: Duration) {
        let vehicle = &station.vehicles[index];
        let Some(driver) = vehicle.driver().cloned() else { return };
        let (target, seen) = (vehicle.target(), vehicle.seen());
        // Only a pilot, or a failsafe, ends a take-off in another mode.
        let is_as_told = vehicle.follows() || (driver.holds_after_take_off() && vehicle.holds());
        if self.launch_modes[index].is_some_and(|mode| mode != seen.custom_mode) && !is_as_told {
            station.release_for_its_mode(index, now);
            return;
        }
        let height_m = self.height_m(station, index);
        // A PX4 follows only once a stream of setpoints runs; an ArduCopter would break off its take-off for one.
        if seen.armed
            && !seen.on_ground
            && driver.kind() == AutopilotKind::Px4Multicopter
            && let Some(state) = station.state_now(index, now)
        {
            let setpoint = State { altitude_m: self.gather.layer_m(index), speed_mps: 0.0, ..state }.hold();
            station.steer(index, &setpoint, now);
        }
        match driver.launch(target, &seen, height_m) {
            Launch::Send(message) => {
                station.order(index, "launch", message, now);
                let vehicle = &station.vehicles[index];
                if let Some(answer) = vehicle.orders().answer("launch").filter(|answer| *answer != "ACCEPTED") {
                    let words = vehicle.heard().words_since(self.began);
                    let words = words.map(|words| format!(" ({words})")).unwrap_or_default();
                    let text = format!("does not take off yet: {answer}{words}");
                    station.tell_once(index, &text.clone(), Weight::Note, text, now);
                }
            }
            Launch::Wait => {
                self.launch_modes[index].get_or_insert(seen.custom_mode);
            }
            Launch::Flying => {
                self.flying[index] = true;
                let vehicle = &mut station.vehicles[index];
                vehicle.custody_mut().enter();
                vehicle.has_followed("launch");
                let text = format!("is in the air, in {}", vehicle.mode_name());
                station.tell_once(index, "airborne", Weight::Note, text, now);
            }
        }
    }

    /// Height above home that the take-off itself climbs to, m.
    fn height_m(&self, station: &Station, index: usize) -> f64 {
        let vehicle = &station.vehicles[index];
        let is_copter = vehicle.driver().is_some_and(|driver| driver.kind() == AutopilotKind::ArduCopter);
        let own = vehicle.limits().and_then(|limits| limits.takeoff_height_m).unwrap_or(50.0);
        let home_amsl_m =
            vehicle.heard().home.map_or(station.frame.origin().altitude_amsl_m, |home| home.altitude_amsl_m);
        let layer_m = station.frame.origin().altitude_amsl_m + self.gather.layer_m(index) - home_amsl_m;
        if is_copter { layer_m.max(3.0) } else { own }
    }
}
