//! What phases share: setpoints that go out when they are due, and modes that others change.

use super::told::Weight;
use super::{STALE_S, Station};
use flight_model::{Setpoint, wrap_pi};
use mavlink_bridge::dialect::Message;
use mavlink_bridge::kind::request_message;
use std::time::Duration;

/// A setpoint that is the same is sent again after this, where the autopilot does not ask for more.
const SAME_AGAIN: Duration = Duration::from_secs(1);
/// A setpoint that differs goes out no sooner than this after the last.
const CHANGED_AGAIN: Duration = Duration::from_millis(200);
/// A setpoint that is not answered is sent again after this.
const ANSWER_PATIENCE: Duration = Duration::from_millis(350);
/// A speed that is outside the vehicle's own limits by more than this is told, m/s.
const SPEED_OUTSIDE_MPS: f64 = 1.0;
/// After so many refusals in a row a vehicle is told to refuse.
const REFUSALS_TOLD: u32 = 3;

/// Purposes under which setpoints are kept until they are answered.
const SETPOINT_PURPOSES: [&str; 3] = ["setpoint 1", "setpoint 2", "setpoint 3"];

impl Station {
    /// Sends a setpoint if it differs from the last one, or is to be repeated.
    pub fn steer(&mut self, index: usize, setpoint: &Setpoint, now: Duration) {
        let Some(vehicle) = self.vehicles.get(index) else { return };
        let Some(driver) = vehicle.driver() else { return };
        let since = vehicle.setpoint_sent.map(|sent| now.saturating_sub(sent));
        let differs = vehicle.setpoint.is_none_or(|last| {
            (last.speed_mps - setpoint.speed_mps).abs() > 0.05
                || wrap_pi(last.course_rad - setpoint.course_rad).abs() > 0.008
                || (last.altitude_m - setpoint.altitude_m).abs() > 0.2
        });
        let again = match driver.repeat_every() {
            Some(every) => every,
            None if differs => CHANGED_AGAIN,
            None => SAME_AGAIN,
        };
        if since.is_none_or(|since| since >= again) {
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
        let vehicle = &mut self.vehicles[index];
        vehicle.present.command(now.as_secs_f64(), setpoint);
        vehicle.setpoint = Some(*setpoint);
        vehicle.setpoint_sent = Some(now);
        if vehicle.driver().is_some_and(|driver| driver.acknowledges_setpoints()) {
            for (purpose, message) in SETPOINT_PURPOSES.iter().zip(&messages) {
                let command = match message {
                    Message::COMMAND_LONG(data) => data.command as u32,
                    Message::COMMAND_INT(data) => data.command as u32,
                    _ => continue,
                };
                let order =
                    super::vehicle::Order { command, sent: now, tries: 1, answer: None, message: message.clone() };
                vehicle.orders.insert(purpose, order);
            }
        }
        self.send(index, messages);
    }

    /// Sends again what was not answered, and tells what was refused.
    pub fn watch_answers(&mut self, index: usize, now: Duration) {
        let Some(vehicle) = self.vehicles.get_mut(index) else { return };
        let (mut again, mut refused) = (Vec::new(), None);
        for (number, purpose) in SETPOINT_PURPOSES.into_iter().enumerate() {
            let Some(order) = vehicle.orders.get_mut(purpose) else { continue };
            match order.answer.take() {
                None if order.tries < 3 && now.saturating_sub(order.sent) >= ANSWER_PATIENCE => {
                    (order.sent, order.tries) = (now, order.tries + 1);
                    again.push(order.message.clone());
                }
                None => {}
                Some(answer) => {
                    // Each kind of command on its own: one that follows the course may refuse every speed.
                    if answer == "ACCEPTED" {
                        vehicle.refusals[number] = 0;
                    } else {
                        vehicle.refusals[number] += 1;
                        refused = Some((name(&order.message), answer, vehicle.refusals[number]));
                    }
                    vehicle.orders.remove(purpose);
                }
            }
        }
        if let Some(setpoint) = vehicle.setpoint.filter(|_| !again.is_empty()) {
            vehicle.present.command(now.as_secs_f64(), &setpoint);
        }
        let (target, mode) = (vehicle.target, vehicle.mode_name());
        let words = vehicle.words_since(now.saturating_sub(Duration::from_secs(3))).map(str::to_owned);
        if let Some((what, answer, refusals)) = refused {
            // Its mode may have changed: the next heartbeat would tell in a while, this one does now.
            again.push(request_message(target, 0));
            if refusals >= REFUSALS_TOLD {
                let words = words.map(|words| format!(" ({words})")).unwrap_or_default();
                let text = format!("refuses {what} in {mode}: {answer}{words}");
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
            let is_as_told = vehicle.follows() || ((may_hold || vehicle.paused) && vehicle.holds());
            if vehicle.is_ours() && vehicle.entered && !is_as_told {
                let mode = vehicle.mode_name();
                let why = if vehicle.critical { "by a failsafe, it says" } else { "by others" };
                let text = format!("was brought into {mode} {why}: it is flown no more");
                self.release(index, text, now);
            } else if vehicle.is_ours() && vehicle.entered && !vehicle.armed {
                self.release(index, "was disarmed: it is flown no more".to_owned(), now);
            }
            self.watch_age(index, now);
        }
    }

    fn release(&mut self, index: usize, text: String, now: Duration) {
        self.vehicles[index].released = Some(text.clone());
        self.told.tell(now.as_secs_f64(), Some(super::number(index)), Weight::Fault, text);
    }

    fn watch_age(&mut self, index: usize, now: Duration) {
        let (now_s, number) = (now.as_secs_f64(), Some(super::number(index)));
        let Some(age_s) = self.vehicles[index].age_s(now_s) else { return };
        if !self.vehicles[index].entered || now < self.catching_up_until {
            return;
        }
        if age_s > super::LOST_S {
            let text = format!("is lost: nothing of its position for {:.0} s", super::LOST_S);
            self.told.once(now_s, number, "lost", Weight::Fault, text);
        } else if age_s > STALE_S {
            let text = format!("is stale: its last position is {age_s:.1} s old");
            self.told.once(now_s, number, "stale", Weight::Warning, text);
        } else if age_s < 0.5 {
            self.told.forget(number, "stale");
        }
    }
}

fn name(message: &Message) -> &'static str {
    use mavlink_bridge::dialect::MavCmd;
    let command = match message {
        Message::COMMAND_LONG(data) => data.command,
        Message::COMMAND_INT(data) => data.command,
        _ => return "a setpoint",
    };
    match command {
        MavCmd::MAV_CMD_GUIDED_CHANGE_SPEED | MavCmd::MAV_CMD_DO_CHANGE_SPEED => "the speed",
        MavCmd::MAV_CMD_GUIDED_CHANGE_HEADING => "the course",
        MavCmd::MAV_CMD_GUIDED_CHANGE_ALTITUDE | MavCmd::MAV_CMD_DO_CHANGE_ALTITUDE => "the altitude",
        _ => "a setpoint",
    }
}
