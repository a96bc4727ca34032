//! Autopilots of any make, as a listener knows them: by what they say on a link, or said in a log.

use crate::station::vehicle::{Vehicle, state};
use flight_model::{Geodetic, LocalFrame, State};
use live_view::{Event, VehicleNow, Weight};
use mavlink_bridge::dialect::{
    GLOBAL_POSITION_INT_DATA, HEARTBEAT_DATA, MavAutopilot, MavSeverity, MavType, Message, STATUSTEXT_DATA,
};
use mavlink_bridge::{Header, state_from_local_position};
use std::sync::Arc;
use std::time::{Duration, Instant};

/// Ids of the messages that say where an autopilot is and in which state, of all that [`Flock::hear`] takes.
pub const SHOWN: [u32; 6] = [0, 32, 33, 245, 253, 436];

/// One autopilot, and by which way it is heard.
pub struct Heard<W> {
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
}

/// All autopilots that were heard, in the order in which they were.
pub struct Flock<W> {
    /// The autopilots.
    pub all: Vec<Heard<W>>,
    /// The frame of all: its origin is the first place that was heard of.
    pub frame: Option<LocalFrame>,
    /// What autopilots said in words, and nobody has taken yet.
    pub events: Vec<(Duration, Event)>,
    /// Whether ways and clocks are followed, which tell at what rate positions come: a log needs neither.
    follows_ways: bool,
}

impl<W: Copy + PartialEq> Flock<W> {
    /// Nobody was heard; `follows_ways` on a link, whose positions may have to be asked for.
    pub fn new(follows_ways: bool) -> Self {
        Self { all: Vec::new(), frame: None, events: Vec::new(), follows_ways }
    }

    /// Whether a system tells its global position, so that its local one is not needed.
    pub fn has_global(&self, system_id: u8) -> bool {
        self.all.iter().any(|one| one.has_global && one.vehicle.id() == system_id)
    }

    /// Takes a message that came by a way, at a time on the listener's clock; gives the index of who said it.
    pub fn hear(&mut self, header: &Header, message: &Message, way: W, now: Duration) -> Option<usize> {
        let known = self.all.iter().position(|one| one.vehicle.id() == header.system_id && one.way == way);
        let index = match (known, message) {
            (Some(index), _) => index,
            (None, Message::HEARTBEAT(heartbeat)) if is_autopilot(heartbeat) => {
                let vehicle = Vehicle::new(header.system_id, header.component_id);
                self.all.push(Heard { way, vehicle, state: None, placed: None, last: now, has_global: false });
                self.all.len() - 1
            }
            _ => return None,
        };
        let one = &mut self.all[index];
        // A camera, a gimbal, a companion computer.
        if header.component_id != one.vehicle.target.component_id {
            return None;
        }
        one.last = now;
        match message {
            Message::GLOBAL_POSITION_INT(data) if is_place(data) => {
                let frame = *self.frame.get_or_insert_with(|| LocalFrame::new(origin(data)));
                one.has_global = true;
                one.state = Some(state(data, &frame));
                one.placed = Some(now);
                if self.follows_ways {
                    one.vehicle.hear(message, now, &frame);
                } else {
                    one.vehicle.height_m = f64::from(data.relative_alt) * 1e-3;
                }
            }
            Message::LOCAL_POSITION_NED(data) if !one.has_global => {
                one.state = Some(state_from_local_position(data)).filter(State::is_finite);
                one.placed = Some(now);
            }
            Message::STATUSTEXT(data) => self.events.extend(event(index, data).map(|event| (now, event))),
            message => {
                const NOWHERE: Geodetic = Geodetic { latitude_deg: 0.0, longitude_deg: 0.0, altitude_amsl_m: 0.0 };
                let frame = self.frame.unwrap_or_else(|| LocalFrame::new(NOWHERE));
                one.vehicle.hear(message, now, &frame);
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
        shown.number = crate::flight::vehicle_number(index);
        shown.system_id = vehicle.id();
        if shown.kind.is_empty() {
            shown.kind = Arc::from(vehicle.driver().map_or("autopilot", |driver| driver.kind().name()));
        }
        shown.set_mode(&vehicle.mode_name());
        shown.is_armed = vehicle.armed;
        shown.is_in_failsafe = vehicle.critical;
        shown.follows = vehicle.follows();
        shown.is_on_ground = vehicle.landed_state.is_some() && vehicle.on_ground();
        shown.heard = heard;
    }
}

fn is_autopilot(heartbeat: &HEARTBEAT_DATA) -> bool {
    heartbeat.autopilot != MavAutopilot::MAV_AUTOPILOT_INVALID
        && !matches!(
            heartbeat.mavtype,
            MavType::MAV_TYPE_GCS
                | MavType::MAV_TYPE_ONBOARD_CONTROLLER
                | MavType::MAV_TYPE_GIMBAL
                | MavType::MAV_TYPE_ADSB
        )
}

/// Before its estimator has a fix, ArduPilot tells places within metres of 0, 0.
fn is_place(data: &GLOBAL_POSITION_INT_DATA) -> bool {
    data.lat.abs() >= 10_000 || data.lon.abs() >= 10_000
}

/// Heights are above the home of the vehicle that was heard first.
fn origin(data: &GLOBAL_POSITION_INT_DATA) -> Geodetic {
    Geodetic {
        latitude_deg: f64::from(data.lat) * 1e-7,
        longitude_deg: f64::from(data.lon) * 1e-7,
        altitude_amsl_m: f64::from(data.alt.saturating_sub(data.relative_alt)) * 1e-3,
    }
}

fn event(index: usize, data: &STATUSTEXT_DATA) -> Option<Event> {
    let text = data.text.to_str().unwrap_or("").trim();
    let weight = match data.severity {
        MavSeverity::MAV_SEVERITY_EMERGENCY | MavSeverity::MAV_SEVERITY_ALERT | MavSeverity::MAV_SEVERITY_CRITICAL => {
            Weight::Warning
        }
        _ => Weight::Note,
    };
    let vehicles = vec![crate::flight::vehicle_number(index)];
    (!text.is_empty()).then(|| Event { at_s: 0.0, vehicles, weight, text: format!("says: {text}") })
}
