//! The operator's words to simulated vehicles: each goes to the vehicle's own port as a command by MAVLink, as any
//! ground station sends it, and the answer is the vehicle's own.

use crate::flight::vehicle_number;
use crate::flying::reachable;
use crate::station::operator::Verb;
use live_view::{Answer, Event, Feed, LiveView, Said, Weight};
use mavlink_bridge::dialect::{MavResult, Message};
use mavlink_bridge::kind::{AtEnd, AutopilotKind, Driver};
use mavlink_bridge::{Encoder, Frame, Target, result_name};
use sim_vehicle::{Host, Personality, VehicleSettings};
use std::collections::BTreeMap;
use std::convert::Infallible;
use std::io;
use std::net::SocketAddr;
use std::time::Duration;
use tokio::net::UdpSocket;
use tokio::sync::mpsc;
use tokio::time::{sleep_until, timeout_at};

/// What operators may say, of the verbs that `columba fly` has: these change a mode.
pub const VERBS: [&str; 6] = ["abort loiter", "abort return", "abort land", "loiter N", "return N", "land N"];
/// Neither a ground station, whose silence an autopilot would notice, nor a vehicle.
const OPERATOR: (u8, u8) = (254, 190);
/// A vehicle that does not answer is told again, so often and after so long: the link may lose datagrams.
const TRIES: u32 = 3;
const PATIENCE: Duration = Duration::from_millis(400);

/// Hears words on the page, and tells vehicles.
pub struct CraftOrders {
    /// The operator's end; none without a page.
    page: Option<(mpsc::Receiver<Said>, Feed)>,
    socket: UdpSocket,
    encoder: Encoder,
    vehicles: Vec<Ordered>,
    /// Flight time on the page when it was last looked at, s.
    at_s: f64,
}

/// A vehicle that can be told something.
struct Ordered {
    address: SocketAddr,
    target: Target,
    driver: Driver,
}

impl CraftOrders {
    /// Words on a page to the vehicles of a host.
    ///
    /// # Errors
    /// There is no port to tell them from.
    pub async fn of(host: &Host, view: Option<&mut LiveView>) -> io::Result<Self> {
        let page = view.and_then(|view| Some((view.take_words()?, view.feed())));
        let vehicles = host.vehicles().zip(host.addresses()).map(|(vehicle, address)| {
            let VehicleSettings { system_id, component_id, personality, .. } = *vehicle.settings();
            let kind = match personality {
                Personality::ArduPlane => AutopilotKind::ArduPlane,
                Personality::Px4 => AutopilotKind::Px4FixedWing,
                Personality::Generic => AutopilotKind::Columba,
            };
            let target = Target { system_id, component_id };
            Ordered { address: reachable(*address), target, driver: Driver::new(kind, None) }
        });
        let (socket, encoder) = (UdpSocket::bind(("127.0.0.1", 0)).await?, Encoder::new(OPERATOR.0, OPERATOR.1));
        Ok(Self { page, socket, encoder, vehicles: vehicles.collect(), at_s: 0.0 })
    }

    /// Obeys for as long as anybody may say something; never ends.
    pub async fn obey(mut self) -> Infallible {
        let mut datagram = [0; 2048];
        loop {
            let Some((words, feed)) = &mut self.page else { return std::future::pending().await };
            tokio::select! {
                said = words.recv() => match said {
                    Some(said) => {
                        let feed = feed.clone();
                        self.answer(said, &feed).await;
                    }
                    None => self.page = None,
                },
                // Telemetry, which a vehicle sends to everybody who speaks to it.
                _ = self.socket.recv_from(&mut datagram) => {}
            }
        }
    }

    async fn answer(&mut self, said: Said, feed: &Feed) {
        let answer = match said.text.parse::<Verb>() {
            Ok(Verb::Abort(Some(at_end))) => self.order((0..self.vehicles.len()).collect(), at_end, &said, feed).await,
            Ok(Verb::Drop(number, at_end)) if (1..=self.vehicles.len()).contains(&number) => {
                self.order(vec![number - 1], at_end, &said, feed).await
            }
            Ok(Verb::Drop(number, _)) => refused(format!("there is no vehicle {number}")),
            Ok(_) => refused(format!("simulated vehicles take {}", VERBS.join(", "))),
            Err(error) => refused(error),
        };
        // A page that is gone needs no answer.
        let _ = said.answer.send(answer);
    }

    /// Orders vehicles into the mode in which they are to end, and gathers what they answer.
    async fn order(&mut self, whose: Vec<usize>, at_end: AtEnd, said: &Said, feed: &Feed) -> Answer {
        feed.update(|frame| self.at_s = frame.time_s);
        let at_s = self.at_s;
        let text = format!("the operator says {} (on the page, {})", said.text, said.from);
        tracing::info!("{text}");
        let numbers =
            if whose.len() == 1 { whose.iter().map(|&index| vehicle_number(index)).collect() } else { vec![] };
        feed.tell(Event { at_s, vehicles: numbers, weight: Weight::Warning, text });
        let mut answers: BTreeMap<usize, MavResult> = BTreeMap::new();
        for _ in 0..TRIES {
            for &index in whose.iter().filter(|index| !answers.contains_key(index)).collect::<Vec<_>>() {
                let Ordered { address, target, driver } = &self.vehicles[index];
                let Some(mode) = driver.end_mode(at_end) else { continue };
                let mut datagram = Vec::new();
                self.encoder.encode(&driver.set_mode(*target, mode), &mut datagram);
                let _ = self.socket.send_to(&datagram, *address).await;
            }
            self.gather(&whose, &mut answers).await;
            if answers.len() == whose.len() {
                break;
            }
        }
        let accepted = answers.values().filter(|result| **result == MavResult::MAV_RESULT_ACCEPTED).count();
        let text = match (whose.len(), answers.values().next()) {
            (1, Some(MavResult::MAV_RESULT_ACCEPTED)) => "accepted".to_owned(),
            (1, Some(result)) => format!("refused: {}", result_name(*result)),
            (1, None) => "not answered".to_owned(),
            (all, _) => format!("{accepted} of {all} have accepted"),
        };
        Answer { is_done: accepted == whose.len(), text }
    }

    /// Takes answers for a while, or until all are there.
    async fn gather(&self, whose: &[usize], answers: &mut BTreeMap<usize, MavResult>) {
        let until = tokio::time::Instant::now() + PATIENCE;
        let mut datagram = [0; 2048];
        while answers.len() < whose.len() {
            let Ok(received) = timeout_at(until, self.socket.recv_from(&mut datagram)).await else { return };
            let Ok((length, from)) = received else {
                sleep_until(until).await;
                return;
            };
            let mut rest = &datagram[..length];
            while let Ok(frame) = Frame::parse(rest) {
                rest = &rest[frame.bytes.len()..];
                let Ok(Message::COMMAND_ACK(ack)) = frame.message() else { continue };
                let system = frame.header.system_id;
                let is_from = |index: &&usize| {
                    (self.vehicles[**index].target.system_id, self.vehicles[**index].address) == (system, from)
                };
                answers.extend(whose.iter().find(is_from).map(|index| (*index, ack.result)));
            }
        }
    }
}

fn refused(text: String) -> Answer {
    Answer { is_done: false, text }
}
