//! Autopilots of any make, as a listener knows them: by what they say on a link, or said in a log.

use super::heard_plans::HeardPlans;
use super::plans::{Outlines, Plans, Reference, outlines};
use crate::station::vehicle::{Vehicle, place};
use flight_model::{Geodetic, LocalFrame, State};
use live_view::{Event, Outline, VehicleNow, Weight, Wind};
use mavlink_bridge::dialect::{GLOBAL_POSITION_INT_DATA, MavSeverity, Message, STATUSTEXT_DATA};
use mavlink_bridge::{Frame, Header, Incoming, is_autopilot, state_from_local_position};
use std::sync::Arc;
use std::time::{Duration, Instant};

/// Ids of the messages that say where an autopilot is and in which state, what wind it feels and which plans it has, of
/// all that [`Flock::hear`] takes.
pub const SHOWN: [u32; 13] = [0, 32, 33, 39, 44, 45, 73, 168, 231, 242, 245, 253, 436];
/// Those that are of the mission protocol: MISSION_ITEM, MISSION_COUNT, MISSION_CLEAR_ALL, MISSION_ITEM_INT.
const PLAN_IDS: [u32; 4] = [39, 44, 45, 73];
/// WIND of ArduPilot's own dialect (<https://mavlink.io/en/messages/ardupilotmega.html#WIND>).
const WIND: u32 = 168;
/// What nobody has said for so long is no wind any more.
const WIND_HELD: Duration = Duration::from_secs(30);

/// One autopilot, and by which way it is heard.
pub struct Heard<W> {
    /// Its number: its system id, or 1000 and more beyond that where another has that already.
    pub number: u32,
    /// The way.
    pub way: W,
    /// What the station's own ears make of its messages.
    pub vehicle: Vehicle,
    /// Where it is, in the frame of all.
    pub state: Option<State>,
    /// When that was, on the listener's clock.
    pub placed: Option<Duration>,
    /// When anything of it last came.
    pub last: Duration,
    has_global: bool,
    /// North and east of where the wind blows to, m/s, and when that was said.
    wind_mps: Option<([f64; 2], Duration)>,
}

/// All autopilots that were heard, in the order in which they were.
pub struct Flock<W> {
    /// The autopilots.
    pub all: Vec<Heard<W>>,
    /// The frame of all: its origin is the first place that was heard of.
    pub frame: Option<LocalFrame>,
    /// What autopilots said in words, and nobody has taken yet.
    pub events: Vec<(Duration, Event)>,
    /// Their missions, fences and rally points.
    pub plans: HeardPlans,
    outlines: Outlines,
    /// Whether ways and clocks are followed, which tell at what rate positions come: a log needs neither.
    follows_ways: bool,
}

impl<W: Copy + PartialEq> Flock<W> {
    /// Nobody was heard; `follows_ways` on a link, whose positions may have to be asked for.
    pub fn new(follows_ways: bool) -> Self {
        Self {
            all: Vec::new(),
            frame: None,
            events: Vec::new(),
            plans: HeardPlans::default(),
            outlines: Outlines::default(),
            follows_ways,
        }
    }

    /// Takes a frame that came by a way, at a time on the listener's clock; gives the index of the autopilot that said
    /// it. Other ids than [`SHOWN`] may be left out.
    pub fn hear_frame(&mut self, frame: &Frame<'_>, way: W, now: Duration) -> Option<usize> {
        if PLAN_IDS.contains(&frame.header.message_id) {
            let all = &self.all;
            let is_vehicle = |system: u8| all.iter().any(|one| one.vehicle.id() == system);
            let changed = self.plans.hear(&Incoming::decode(frame).ok()?, is_vehicle);
            changed.into_iter().for_each(|system| self.outline(system));
            return None;
        }
        if frame.header.message_id == WIND {
            let known = self.all.iter().position(|one| one.vehicle.id() == frame.header.system_id && one.way == way)?;
            self.all[known].wind_mps = wind_mps(frame.payload()).map(|wind_mps| (wind_mps, now));
            return Some(known);
        }
        self.hear(&frame.header, &frame.message().ok()?, way, now)
    }

    /// The lines of all plans, if any has changed since this was last asked.
    pub fn take_outlines(&mut self) -> Option<Vec<Outline>> {
        self.outlines.take_changed()
    }

    /// The mean of the wind that the vehicles have told lately.
    pub fn wind(&self, now: Duration) -> Option<Wind> {
        let is_held = |at: Duration| now.saturating_sub(at) <= WIND_HELD;
        let told: Vec<[f64; 2]> = self
            .all
            .iter()
            .filter_map(|one| one.wind_mps)
            .filter(|(_, at)| is_held(*at))
            .map(|(wind, _)| wind)
            .collect();
        if told.is_empty() {
            return None;
        }
        let [north, east] = [0, 1].map(|axis| told.iter().map(|wind| wind[axis]).sum::<f64>() / told.len() as f64);
        // From where it blows.
        let from_deg = libm::atan2(-east, -north).to_degrees().rem_euclid(360.0);
        Some(Wind { speed_mps: libm::hypot(north, east), from_deg })
    }

    /// Draws the plans of a system anew.
    fn outline(&mut self, system: u8) {
        let Some(frame) = self.frame else { return };
        let [mission, fence, rally] = self.plans.of(system);
        for one in self.all.iter().filter(|one| one.vehicle.id() == system) {
            let home_m = one.vehicle.heard().home.map(|home| Reference::local_m(&frame, &home));
            let number = one.number;
            self.outlines
                .set(number, outlines(number, Reference { frame: &frame, home_m }, &Plans { mission, fence, rally }));
        }
    }

    /// Whether a system tells its global position, so that its local one is not needed.
    pub fn has_global(&self, system_id: u8) -> bool {
        self.all.iter().any(|one| one.has_global && one.vehicle.id() == system_id)
    }

    /// Takes a message that came by a way, at a time on the listener's clock; gives the index of who said it.
    fn hear(&mut self, header: &Header, message: &Message, way: W, now: Duration) -> Option<usize> {
        let known = self.all.iter().position(|one| one.vehicle.id() == header.system_id && one.way == way);
        let index = match (known, message) {
            (Some(index), _) => index,
            (None, Message::HEARTBEAT(heartbeat)) if is_autopilot(heartbeat) => {
                let vehicle = Vehicle::new(header.system_id, header.component_id);
                let is_taken = |number| self.all.iter().any(|one| one.number == number);
                self.all.push(Heard {
                    number: free_number(u32::from(header.system_id), is_taken),
                    way,
                    vehicle,
                    state: None,
                    placed: None,
                    last: now,
                    has_global: false,
                    wind_mps: None,
                });
                self.all.len() - 1
            }
            _ => return None,
        };
        let one = &mut self.all[index];
        // A camera, a gimbal, a companion computer.
        if header.component_id != one.vehicle.target().component_id {
            return None;
        }
        one.last = now;
        match message {
            Message::WIND_COV(data) => {
                let wind = [f64::from(data.wind_x), f64::from(data.wind_y)];
                one.wind_mps = Some((wind, now)).filter(|_| wind.iter().all(|part| part.is_finite()));
            }
            Message::GLOBAL_POSITION_INT(data) if place::is_known(data) => {
                let is_first = self.frame.is_none();
                let frame = *self.frame.get_or_insert_with(|| LocalFrame::new(origin(data)));
                one.has_global = true;
                one.state = Some(place::state(data, &frame));
                one.placed = Some(now);
                if self.follows_ways {
                    one.vehicle.hear(message, now, &frame);
                } else {
                    one.vehicle.hear_without_clock(message, now);
                }
                if is_first {
                    // What was heard before anybody's place was known.
                    let known: Vec<u8> = self.all.iter().map(|one| one.vehicle.id()).collect();
                    known.into_iter().for_each(|system| self.outline(system));
                }
            }
            Message::LOCAL_POSITION_NED(data) if !one.has_global => {
                one.state = Some(state_from_local_position(data)).filter(State::is_finite);
                one.placed = Some(now);
            }
            Message::STATUSTEXT(data) => self.events.extend(event(one.number, data).map(|event| (now, event))),
            message => {
                let home = one.vehicle.heard().home;
                const NOWHERE: Geodetic = Geodetic { latitude_deg: 0.0, longitude_deg: 0.0, altitude_amsl_m: 0.0 };
                let frame = self.frame.unwrap_or_else(|| LocalFrame::new(NOWHERE));
                one.vehicle.hear(message, now, &frame);
                if one.vehicle.heard().home != home {
                    self.outline(header.system_id);
                }
            }
        }
        Some(index)
    }

    /// Writes what is known of an autopilot; `heard` is when it was last heard, for its age.
    pub fn show(&self, index: usize, shown: &mut VehicleNow, heard: Option<Instant>) {
        let Some(one) = self.all.get(index) else { return };
        if let Some(state) = &one.state {
            super::craft::place(shown, index, state);
        }
        let vehicle = &one.vehicle;
        shown.number = one.number;
        shown.system_id = vehicle.id();
        if shown.kind.is_empty() {
            shown.kind = Arc::from(vehicle.driver().map_or("autopilot", |driver| driver.kind().name()));
        }
        shown.set_mode(&vehicle.mode_name());
        shown.is_armed = vehicle.heard().armed;
        shown.is_in_failsafe = vehicle.heard().critical;
        shown.follows = vehicle.follows();
        shown.is_on_ground = vehicle.heard().landed_state.is_some() && vehicle.on_ground();
        shown.heard = heard;
    }
}

/// North and east of where the wind of a WIND blows to, m/s: the message has the degrees from where it comes, and m/s.
fn wind_mps(payload: &[u8]) -> Option<[f64; 2]> {
    let number = |at: usize| payload.get(at..at + 4).and_then(|bytes| bytes.try_into().ok()).map(f32::from_le_bytes);
    let (from_rad, speed_mps) = (f64::from(number(0)?).to_radians(), f64::from(number(4)?));
    let wind_mps = [-speed_mps * libm::cos(from_rad), -speed_mps * libm::sin(from_rad)];
    wind_mps.iter().all(|part| part.is_finite()).then_some(wind_mps)
}

/// A number for a system that nobody has.
pub fn free_number(system: u32, is_taken: impl Fn(u32) -> bool) -> u32 {
    (0..).map(|others| system + 1000 * others).find(|&number| !is_taken(number)).unwrap_or(system)
}

/// Heights are above the home of the vehicle that was heard first.
fn origin(data: &GLOBAL_POSITION_INT_DATA) -> Geodetic {
    Geodetic {
        latitude_deg: f64::from(data.lat) * 1e-7,
        longitude_deg: f64::from(data.lon) * 1e-7,
        altitude_amsl_m: f64::from(data.alt.saturating_sub(data.relative_alt)) * 1e-3,
    }
}

fn event(number: u32, data: &STATUSTEXT_DATA) -> Option<Event> {
    let text = data.text.to_str().unwrap_or("").trim();
    let weight = match data.severity {
        MavSeverity::MAV_SEVERITY_EMERGENCY | MavSeverity::MAV_SEVERITY_ALERT | MavSeverity::MAV_SEVERITY_CRITICAL => {
            Weight::Warning
        }
        _ => Weight::Note,
    };
    let vehicles = vec![number];
    (!text.is_empty()).then(|| Event { at_s: 0.0, vehicles, weight, text: format!("says: {text}") })
}
