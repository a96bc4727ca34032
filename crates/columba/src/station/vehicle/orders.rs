//! What a vehicle was told, and what it answered: orders by their purpose, and setpoints.

use flight_model::{Setpoint, wrap_pi};
use mavlink_bridge::dialect::{COMMAND_ACK_DATA, MavCmd, Message};
use mavlink_bridge::kind::SpeedDemand;
use mavlink_bridge::result_name;
use std::collections::BTreeMap;
use std::time::Duration;

/// An order that is not followed is given again after this,
const ORDER_AGAIN: Duration = Duration::from_millis(1000);
/// if the vehicle has told its mode so long after the order: what was heard before may be of the past, and a pilot may
/// have changed the mode since.
const ORDER_SETTLES: Duration = Duration::from_millis(500);
/// From a vehicle that tells nothing, nothing newer is to be had: it is given the order again after this.
const ORDER_AGAIN_UNHEARD: Duration = Duration::from_secs(3);
/// A setpoint that is the same is sent again after this, where the autopilot does not ask for more.
const SAME_AGAIN: Duration = Duration::from_secs(1);
/// A setpoint that differs goes out no sooner than this after the last.
const CHANGED_AGAIN: Duration = Duration::from_millis(200);
/// A command of a setpoint that is not answered is sent again after this.
const ANSWER_PATIENCE: Duration = Duration::from_millis(350);
/// It is sent so often in all.
const TRIES: u32 = 3;

/// A command that was sent.
#[derive(Clone, Debug)]
struct Sent {
    message: Message,
    at: Duration,
    tries: u32,
    answer: Option<String>,
}

impl Sent {
    fn new(message: Message, at: Duration) -> Self {
        Self { message, at, tries: 1, answer: None }
    }

    /// When it is due again.
    fn again_at(&self, heard: ModeHeard) -> Duration {
        let is_heard = heard.last.is_some_and(|last| last >= self.at + ORDER_SETTLES);
        heard.all_at.max(self.at + if is_heard { ORDER_AGAIN } else { ORDER_AGAIN_UNHEARD })
    }
}

/// What was heard of a vehicle's mode. It tells what became of an order, and whether a pilot has the vehicle.
#[derive(Clone, Copy, Debug, Default)]
pub struct ModeHeard {
    /// When the vehicle last told its mode.
    pub last: Option<Duration>,
    /// By then all that vehicles told is read: while the machine catches up after a stall, that is in the future.
    pub all_at: Duration,
}

/// A command of a setpoint that was not accepted.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Refusal {
    /// What was refused, in words.
    pub what: &'static str,
    /// The answer.
    pub answer: String,
    /// How often in a row.
    pub times: u32,
}

/// All that one vehicle was told.
#[derive(Debug, Default)]
pub struct Orders {
    given: BTreeMap<&'static str, Sent>,
    /// The last setpoint, and when it was last sent.
    setpoint: Option<(Setpoint, Duration)>,
    /// The commands of the last setpoint that are not answered.
    unanswered: [Option<Sent>; 3],
    /// How often in a row each command of a setpoint was refused: one that follows the course may refuse every speed.
    refusals: [u32; 3],
    speed_demand: SpeedDemand,
}

impl Orders {
    /// Takes note of an order that is to be given for a purpose now; whether it is due. The same order is due again
    /// while it is not followed, as far as was heard.
    pub fn give(&mut self, purpose: &'static str, message: &Message, heard: ModeHeard, now: Duration) -> bool {
        match self.given.get_mut(purpose).filter(|sent| sent.message == *message) {
            Some(sent) if now < sent.again_at(heard) => false,
            Some(sent) => {
                (sent.at, sent.tries) = (now, sent.tries + 1);
                true
            }
            None => {
                self.given.insert(purpose, Sent::new(message.clone(), now));
                true
            }
        }
    }

    /// Forgets an order that was followed.
    pub fn forget(&mut self, purpose: &str) {
        self.given.remove(purpose);
    }

    /// What was answered to an order.
    pub fn answer(&self, purpose: &str) -> Option<&str> {
        self.given.get(purpose)?.answer.as_deref()
    }

    /// Takes an answer.
    pub fn hear(&mut self, data: &COMMAND_ACK_DATA) {
        let answer = result_name(data.result);
        let all = self.given.values_mut().chain(self.unanswered.iter_mut().flatten());
        for sent in all.filter(|sent| command(&sent.message) == Some(data.command)) {
            sent.answer = Some(answer.clone());
        }
    }

    /// The setpoint that was sent last.
    pub fn setpoint(&self) -> Option<Setpoint> {
        self.setpoint.map(|(setpoint, _)| setpoint)
    }

    /// The airspeed that the autopilot asks of itself at present, by what it was told, m/s.
    pub fn speed_demand_mps(&self, now: Duration) -> Option<f64> {
        self.speed_demand.at(now)
    }

    /// Whether no setpoint was sent for so long.
    pub fn has_rested(&self, now: Duration, rest: Duration) -> bool {
        self.setpoint.is_none_or(|(_, at)| now.saturating_sub(at) >= rest)
    }

    /// Whether a setpoint is to be sent: it differs from the last one, or is to be repeated. `repeat_every` is what the
    /// autopilot asks for, if anything.
    pub fn is_due(&self, setpoint: &Setpoint, repeat_every: Option<Duration>, now: Duration) -> bool {
        let differs = self.setpoint.is_none_or(|(last, _)| {
            (last.speed_mps - setpoint.speed_mps).abs() > 0.05
                || wrap_pi(last.course_rad - setpoint.course_rad).abs() > 0.008
                || (last.altitude_m - setpoint.altitude_m).abs() > 0.2
        });
        let again = repeat_every.unwrap_or(if differs { CHANGED_AGAIN } else { SAME_AGAIN });
        self.has_rested(now, again)
    }

    /// Takes note of a setpoint that is sent now; `messages` where the autopilot acknowledges them.
    pub fn sent(&mut self, setpoint: &Setpoint, messages: &[Message], now: Duration) {
        self.setpoint = Some((*setpoint, now));
        self.speed_demand.tell(messages, now);
        for (unanswered, message) in self.unanswered.iter_mut().zip(messages) {
            *unanswered = command(message).map(|_| Sent::new(message.clone(), now));
        }
    }

    /// The commands of the last setpoint that are to be sent again, and the last of them that was refused.
    pub fn watch(&mut self, now: Duration) -> (Vec<Message>, Option<Refusal>) {
        let (mut again, mut refused) = (Vec::new(), None);
        for (unanswered, times) in self.unanswered.iter_mut().zip(&mut self.refusals) {
            let Some(sent) = unanswered else { continue };
            match sent.answer.take() {
                None if sent.tries < TRIES && now.saturating_sub(sent.at) >= ANSWER_PATIENCE => {
                    (sent.at, sent.tries) = (now, sent.tries + 1);
                    again.push(sent.message.clone());
                }
                None => {}
                Some(answer) => {
                    *times = if answer == "ACCEPTED" { 0 } else { *times + 1 };
                    if *times > 0 {
                        refused = Some(Refusal { what: name(&sent.message), answer, times: *times });
                    }
                    *unanswered = None;
                }
            }
        }
        (again, refused)
    }
}

/// The command of a message; none where the message is none.
fn command(message: &Message) -> Option<MavCmd> {
    match message {
        Message::COMMAND_LONG(data) => Some(data.command),
        Message::COMMAND_INT(data) => Some(data.command),
        _ => None,
    }
}

fn name(message: &Message) -> &'static str {
    match command(message) {
        Some(MavCmd::MAV_CMD_GUIDED_CHANGE_SPEED | MavCmd::MAV_CMD_DO_CHANGE_SPEED) => "the speed",
        Some(MavCmd::MAV_CMD_GUIDED_CHANGE_HEADING) => "the course",
        Some(MavCmd::MAV_CMD_GUIDED_CHANGE_ALTITUDE | MavCmd::MAV_CMD_DO_CHANGE_ALTITUDE) => "the altitude",
        _ => "a setpoint",
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use mavlink_bridge::dialect::{COMMAND_LONG_DATA, MavResult};

    fn order(command: MavCmd) -> Message {
        Message::COMMAND_LONG(COMMAND_LONG_DATA { command, ..COMMAND_LONG_DATA::DEFAULT })
    }

    fn answer(command: MavCmd, result: MavResult) -> COMMAND_ACK_DATA {
        COMMAND_ACK_DATA { command, result, ..COMMAND_ACK_DATA::DEFAULT }
    }

    #[test]
    fn an_order_is_given_again_while_it_is_not_followed() {
        let (arm, land) = (order(MavCmd::MAV_CMD_COMPONENT_ARM_DISARM), order(MavCmd::MAV_CMD_NAV_LAND));
        let mut orders = Orders::default();
        let at = Duration::from_millis;
        let give = |orders: &mut Orders, order: &Message, now_ms: u64| {
            let heard = ModeHeard { last: Some(at(now_ms - now_ms.min(100))), ..ModeHeard::default() };
            orders.give("launch", order, heard, at(now_ms))
        };
        assert!(give(&mut orders, &arm, 0));
        assert!(!give(&mut orders, &arm, 900));
        orders.hear(&answer(MavCmd::MAV_CMD_COMPONENT_ARM_DISARM, MavResult::MAV_RESULT_DENIED));
        assert!(give(&mut orders, &arm, 1000));
        assert_eq!(orders.answer("launch"), Some("DENIED"));
        assert!(give(&mut orders, &land, 1001), "another order");
        assert_eq!(orders.answer("launch"), None);
        orders.forget("launch");
        assert!(give(&mut orders, &land, 1002));
    }

    #[test]
    fn an_order_is_not_given_again_by_what_was_heard_before_it() {
        let hold = order(MavCmd::MAV_CMD_DO_SET_MODE);
        let mut orders = Orders::default();
        let at = Duration::from_millis;
        let heard = |last_ms: Option<u64>| ModeHeard { last: last_ms.map(at), ..ModeHeard::default() };
        assert!(orders.give("hold", &hold, heard(None), at(0)));
        for (last_ms, now_ms) in [(None, 2000), (Some(0), 2000), (Some(400), 2900)] {
            assert!(!orders.give("hold", &hold, heard(last_ms), at(now_ms)), "a pilot may have changed the mode since");
        }
        let stalled = ModeHeard { all_at: at(3000), ..heard(Some(600)) };
        assert!(!orders.give("hold", &hold, stalled, at(2900)), "what was told meanwhile is not read yet");
        assert!(orders.give("hold", &hold, heard(Some(600)), at(2900)));
        assert!(!orders.give("hold", &hold, heard(Some(600)), at(5800)));
        assert!(orders.give("hold", &hold, heard(Some(600)), at(5900)), "it tells nothing: the order may be lost");
    }

    #[test]
    fn a_setpoint_goes_out_when_it_changes_and_once_a_second_else() {
        let setpoint = Setpoint { speed_mps: 20.0, course_rad: 3.138, altitude_m: 100.0 };
        let other = Setpoint { course_rad: -3.10, ..setpoint };
        let at = Duration::from_millis;
        let mut orders = Orders::default();
        assert!(orders.is_due(&setpoint, None, at(0)));
        orders.sent(&setpoint, &[], at(0));
        assert!(!orders.is_due(&Setpoint { course_rad: -3.1385, ..setpoint }, None, at(999)), "the same course");
        assert!(!orders.is_due(&other, None, at(199)) && orders.is_due(&other, None, at(200)));
        assert!(orders.is_due(&setpoint, None, at(1000)));
        assert!(orders.is_due(&setpoint, Some(at(50)), at(50)));
    }

    #[test]
    fn each_command_of_a_setpoint_is_sent_three_times_and_its_refusals_are_counted() {
        let setpoint = Setpoint { speed_mps: 20.0, course_rad: 0.0, altitude_m: 100.0 };
        let (speed, course) = (MavCmd::MAV_CMD_GUIDED_CHANGE_SPEED, MavCmd::MAV_CMD_GUIDED_CHANGE_HEADING);
        let at = Duration::from_millis;
        let mut orders = Orders::default();
        orders.sent(&setpoint, &[order(speed), order(course)], at(0));
        assert_eq!(orders.watch(at(100)), (vec![], None));
        orders.hear(&answer(course, MavResult::MAV_RESULT_ACCEPTED));
        assert_eq!(orders.watch(at(350)), (vec![order(speed)], None));
        assert_eq!(orders.watch(at(700)), (vec![order(speed)], None));
        assert_eq!(orders.watch(at(9000)), (vec![], None));
        for times in 1..4 {
            orders.sent(&setpoint, &[order(speed), order(course)], at(9000));
            orders.hear(&answer(speed, MavResult::MAV_RESULT_FAILED));
            let refusal = Refusal { what: "the speed", answer: "FAILED".to_owned(), times };
            assert_eq!(orders.watch(at(9001)), (vec![], Some(refusal)));
        }
    }
}
