//! What phases share: orders and setpoints that go out when they are due, and modes that others change.

use super::told::Weight;
use super::vehicle::orders::Refusal;
use super::{LOST_S, Outgoing, STALE_S, Station, number};
use flight_model::{Setpoint, State};
use mavlink_bridge::dialect::Message;
use mavlink_bridge::kind::{Situation, request_message};
use std::time::Duration;

/// A speed that is outside the vehicle's own limits by more than this is told, m/s.
const SPEED_OUTSIDE_MPS: f64 = 1.0;
/// After so many refusals in a row a vehicle is told to refuse.
const REFUSALS_TOLD: u32 = 3;
/// Words of a vehicle that are no older than this may say why it refuses.
const REASON_GIVEN: Duration = Duration::from_secs(3);

impl Station {
    /// Sends messages to a vehicle by its freshest way.
    pub fn send(&mut self, index: usize, messages: Vec<Message>) {
        if let Some(route) = self.vehicles.get(index).and_then(|vehicle| vehicle.routes().freshest())
            && !messages.is_empty()
        {
            self.outbox.push(Outgoing { route, messages });
        }
    }

    /// Gives an order for a purpose, and again while it is not followed; never in a dry run. After a stall of the
    /// machine none is given again before it is heard what became of it: a pilot may have the vehicle.
    pub fn order(&mut self, index: usize, purpose: &'static str, message: Message, now: Duration) {
        if self.settings.dry_run {
            return;
        }
        let Some(vehicle) = self.vehicles.get_mut(index) else { return };
        if vehicle.is_due(purpose, &message, self.catching_up_until, now) {
            self.send(index, vec![message]);
        }
    }

    /// Where a vehicle is now: its last position, moved on at its velocity; none when that is stale.
    pub fn state_now(&self, index: usize, now: Duration) -> Option<State> {
        let now_s = now.as_secs_f64();
        let (state, age_s) = self.vehicles.get(index)?.track().carried_to(now_s, STALE_S)?;
        (age_s <= STALE_S).then_some(state)
    }

    /// The speed to be sent for a setpoint, with wind and thin air, and the nearest one that the vehicle takes, m/s.
    fn speeds_to_send_mps(&self, index: usize, setpoint: &Setpoint) -> (f64, f64) {
        let Some(vehicle) = self.vehicles.get(index) else { return (setpoint.speed_mps, setpoint.speed_mps) };
        let asked_mps = vehicle.present().speed_to_send_mps(setpoint);
        let limits = vehicle.limits().unwrap_or_default();
        match (limits.speed_min_mps, limits.speed_max_mps) {
            (Some(least), Some(greatest)) if limits.speeds_are_air && least <= greatest => {
                (asked_mps, asked_mps.clamp(least, greatest))
            }
            _ => (asked_mps, asked_mps),
        }
    }

    /// The messages that ask a vehicle for a setpoint, by its kind's encoder.
    pub fn encode(&self, index: usize, setpoint: &Setpoint, now: Duration) -> Option<Vec<Message>> {
        let vehicle = self.vehicles.get(index)?;
        let (_, speed_mps) = self.speeds_to_send_mps(index, setpoint);
        let situation = Situation {
            state: self.state_now(index, now)?,
            frame: &self.frame,
            local_origin_amsl_m: vehicle.heard().local_origin_amsl_m,
            dynamics: vehicle.present().dynamics(),
            airspeed_excess_mps: speed_mps - setpoint.speed_mps,
            speed_demand_mps: vehicle.orders().speed_demand_mps(now),
            drift_mps: vehicle.drift_mps(),
            now,
        };
        match vehicle.driver()?.setpoint(vehicle.target(), setpoint, &situation) {
            Ok(messages) => Some(messages),
            Err(error) => {
                tracing::debug!(system = vehicle.id(), %error, "setpoint not sent");
                None
            }
        }
    }

    /// Sends a setpoint if it differs from the last one, or is to be repeated.
    pub fn steer(&mut self, index: usize, setpoint: &Setpoint, now: Duration) {
        let Some(vehicle) = self.vehicles.get(index) else { return };
        let Some(driver) = vehicle.driver() else { return };
        if vehicle.orders().is_due(setpoint, driver.repeat_every(), now) {
            self.steer_now(index, setpoint, now);
        }
    }

    /// Sends a setpoint.
    pub fn steer_now(&mut self, index: usize, setpoint: &Setpoint, now: Duration) {
        if self.settings.dry_run || !self.vehicles.get(index).is_some_and(|vehicle| vehicle.is_ours()) {
            return;
        }
        let Some(messages) = self.encode(index, setpoint, now) else { return };
        let (asked_mps, airspeed_mps) = self.speeds_to_send_mps(index, setpoint);
        if (asked_mps - airspeed_mps).abs() > SPEED_OUTSIDE_MPS {
            let text = format!(
                "is asked for {airspeed_mps:.1} m/s of airspeed instead of {asked_mps:.1}: its own limits are narrower \
                 now"
            );
            self.tell_once(index, "narrower", Weight::Warning, text, now);
        }
        self.vehicles[index].steered(setpoint, &messages, now);
        self.send(index, messages);
    }

    /// Sends again what was not answered, and tells what was refused.
    pub fn watch_answers(&mut self, index: usize, now: Duration) {
        let Some(vehicle) = self.vehicles.get_mut(index) else { return };
        let (mut again, refused) = vehicle.watch_answers(now);
        if let Some(Refusal { what, answer, times }) = refused {
            // Its mode may have changed: the next heartbeat would tell in a while, this one does now.
            again.push(request_message(vehicle.target(), 0));
            if times >= REFUSALS_TOLD {
                let words = vehicle.heard().words_since(now.saturating_sub(REASON_GIVEN));
                let words = words.map(|words| format!(" ({words})")).unwrap_or_default();
                let text = format!("refuses {what} in {}: {answer}{words}", vehicle.mode_name());
                self.tell_once(index, &format!("refuses {what}"), Weight::Fault, text, now);
            }
        }
        self.send(index, again);
    }

    /// Looks at modes and at what is heard. Whose mode others have changed is released: named, commanded no more, and
    /// from now on a neighbour to be avoided. While the flight is paused, a vehicle may hold.
    pub fn watch_modes(&mut self, may_hold: bool, now: Duration) {
        for index in self.crew() {
            let vehicle = &self.vehicles[index];
            let is_entered = vehicle.is_ours() && vehicle.custody().has_entered();
            let may_hold = may_hold || vehicle.custody().may_hold();
            let is_as_told = vehicle.follows() || (may_hold && vehicle.holds());
            if is_entered && !is_as_told {
                self.release_for_its_mode(index, now);
            } else if is_entered && !vehicle.heard().armed {
                self.release(index, "was disarmed: it is flown no more".to_owned(), now);
            }
            self.watch_age(index, now);
        }
    }

    /// Others have brought a vehicle into a mode that is not ours.
    pub fn release_for_its_mode(&mut self, index: usize, now: Duration) {
        let vehicle = &self.vehicles[index];
        let why = if vehicle.heard().critical { "by a failsafe, it says" } else { "by others" };
        let text = format!("was brought into {} {why}: it is flown no more", vehicle.mode_name());
        self.release(index, text, now);
    }

    fn release(&mut self, index: usize, text: String, now: Duration) {
        self.vehicles[index].custody_mut().release(text.as_str());
        self.told.tell(now.as_secs_f64(), Some(number(index)), Weight::Fault, text);
    }

    fn watch_age(&mut self, index: usize, now: Duration) {
        let (now_s, number) = (now.as_secs_f64(), Some(number(index)));
        let Some(age_s) = self.vehicles[index].age_s(now_s) else { return };
        if !self.vehicles[index].custody().has_entered() || now < self.catching_up_until {
            return;
        }
        if age_s > LOST_S {
            let text = format!("is lost: nothing of its position for {:.0} s", LOST_S);
            self.told.once(now_s, number, "lost", Weight::Fault, text);
        } else if age_s > STALE_S {
            let text = format!("is stale: its last position is {age_s:.1} s old");
            self.told.once(now_s, number, "stale", Weight::Warning, text);
        } else if age_s < 0.5 {
            self.told.forget(number, "stale");
        }
    }
}
