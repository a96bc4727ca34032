//! Alarms: what about a vehicle asks for a look, and the events that they begin and end with.

use crate::distances::Near;
use crate::scene::{Event, Frame, Least, Scene, Weight};
use std::time::Instant;

/// A vehicle that was not heard for so long is stale, s.
pub const STALE_S: f32 = 1.5;
/// A vehicle that was not heard for so long is lost, s.
pub const LOST_S: f32 = 4.0;
/// Separation is there again beyond this many times the safe distance: an alarm does not flutter.
const APART_AGAIN: f32 = 1.2;

/// What about a vehicle asks for a look; a bit each, as on the wire.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Flags(pub u16);

impl Flags {
    /// The motors may turn.
    pub const ARMED: u16 = 1;
    /// It follows a controller's setpoints.
    pub const FOLLOWS: u16 = 1 << 1;
    /// It stands on the ground.
    pub const ON_GROUND: u16 = 1 << 2;
    /// It is kept out of the flock.
    pub const OUT: u16 = 1 << 3;
    /// Alarm: its autopilot says that something is amiss.
    pub const FAILSAFE: u16 = 1 << 4;
    /// Alarm: not heard for [`STALE_S`].
    pub const STALE: u16 = 1 << 5;
    /// Alarm: not heard for [`LOST_S`].
    pub const LOST: u16 = 1 << 6;
    /// Alarm: another vehicle is nearer than the safe distance.
    pub const SEPARATION: u16 = 1 << 7;
    /// Alarm: it is in a circle.
    pub const CLEARANCE: u16 = 1 << 8;
    /// Alarm: it followed setpoints in the air, and left that mode.
    pub const LEFT: u16 = 1 << 9;

    /// Whether a bit is set.
    pub fn has(self, bit: u16) -> bool {
        self.0 & bit != 0
    }
}

/// What is remembered of a vehicle from one look to the next.
#[derive(Clone, Debug, Default)]
struct Memory {
    flags: Flags,
    mode: std::sync::Arc<str>,
    is_known: bool,
}

/// The alarms of a flock, and the least distances that were seen.
#[derive(Clone, Debug, Default)]
pub struct Alarms {
    memories: Vec<Memory>,
    least_separation: Option<Least>,
    least_clearance: Option<Least>,
}

impl Alarms {
    /// Looks at a frame: each vehicle's flags, and what has happened since the last look.
    pub fn look(&mut self, frame: &Frame, near: &[Near], scene: &Scene, now: Instant) -> (Vec<Flags>, Vec<Event>) {
        self.memories.resize(frame.vehicles.len(), Memory::default());
        let mut events = Vec::new();
        let mut all = Vec::with_capacity(frame.vehicles.len());
        for (index, ((vehicle, near), memory)) in frame.vehicles.iter().zip(near).zip(&mut self.memories).enumerate() {
            let before = memory.flags;
            let mut flags = 0;
            let mut set = |bit: u16, holds: bool| flags |= if holds { bit } else { 0 };
            let silent_s = vehicle.heard.map_or(0.0, |heard| now.saturating_duration_since(heard).as_secs_f32());
            let safe_m = scene.separation_m as f32;
            let safe_m = if before.has(Flags::SEPARATION) { safe_m * APART_AGAIN } else { safe_m };
            set(Flags::ARMED, vehicle.is_armed);
            set(Flags::FOLLOWS, vehicle.follows);
            set(Flags::ON_GROUND, vehicle.is_on_ground);
            set(Flags::OUT, vehicle.is_out);
            set(Flags::FAILSAFE, vehicle.is_in_failsafe);
            set(Flags::STALE, silent_s > STALE_S);
            set(Flags::LOST, silent_s > LOST_S);
            set(Flags::SEPARATION, near.separation_m < safe_m);
            set(Flags::CLEARANCE, near.clearance_m < 0.0);
            let has_left = (before.has(Flags::FOLLOWS) || before.has(Flags::LEFT)) && !vehicle.follows;
            set(Flags::LEFT, has_left && vehicle.is_armed && !vehicle.is_on_ground);
            let flags = Flags(flags);
            let begins = |bit: u16| flags.has(bit) && !before.has(bit);
            let ends = |bit: u16| !flags.has(bit) && before.has(bit);
            let mut tell = |weight, text: String| {
                events.push(Event { at_s: frame.time_s, vehicles: vec![vehicle.number], weight, text });
            };
            if memory.is_known && memory.mode != vehicle.mode && !memory.mode.is_empty() {
                let left = if begins(Flags::LEFT) { Weight::Warning } else { Weight::Note };
                let verb = if begins(Flags::LEFT) { "left" } else { "from" };
                tell(left, format!("{verb} {} to {}", memory.mode, vehicle.mode));
            }
            if begins(Flags::FAILSAFE) {
                tell(Weight::Warning, format!("failsafe, in {}", vehicle.mode));
            }
            if ends(Flags::FAILSAFE) {
                tell(Weight::Note, "failsafe is over".to_owned());
            }
            if begins(Flags::LOST) {
                tell(Weight::Fault, format!("not heard for {LOST_S} s"));
            }
            if ends(Flags::LOST) {
                tell(Weight::Note, "heard again".to_owned());
            }
            if begins(Flags::CLEARANCE) {
                tell(Weight::Fault, "is in a circle".to_owned());
            }
            if ends(Flags::CLEARANCE) {
                tell(Weight::Note, "is out of the circle".to_owned());
            }
            // Of two vehicles that lose each other, the first tells.
            if let Some(nearest) = near.nearest.filter(|&nearest| begins(Flags::SEPARATION) && index < nearest) {
                events.push(Event {
                    at_s: frame.time_s,
                    vehicles: vec![vehicle.number, frame.vehicles[nearest].number],
                    weight: Weight::Warning,
                    text: format!("separation {:.1} m, less than {} m", near.separation_m, scene.separation_m),
                });
            }
            if let Some(nearest) = near.nearest {
                let pair = || vec![vehicle.number, frame.vehicles[nearest].number];
                keep_least(&mut self.least_separation, near.separation_m, frame.time_s, pair);
            }
            keep_least(&mut self.least_clearance, near.clearance_m, frame.time_s, || vec![vehicle.number]);
            *memory = Memory { flags, mode: vehicle.mode.clone(), is_known: true };
            all.push(flags);
        }
        (all, events)
    }

    /// The least separation and the least clearance of all frames that were looked at.
    pub fn least(&self) -> (Option<&Least>, Option<&Least>) {
        (self.least_separation.as_ref(), self.least_clearance.as_ref())
    }
}

fn keep_least(least: &mut Option<Least>, value_m: f32, at_s: f64, vehicles: impl FnOnce() -> Vec<u32>) {
    let value_m = f64::from(value_m);
    if value_m.is_finite() && least.as_ref().is_none_or(|least| value_m < least.value_m) {
        *least = Some(Least { value_m, at_s, vehicles: vehicles() });
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::distances::near;
    use crate::scene::VehicleNow;
    use std::time::Duration;

    fn texts(events: &[Event]) -> Vec<(&[u32], &str)> {
        events.iter().map(|event| (&event.vehicles[..], event.text.as_str())).collect()
    }

    #[test]
    fn each_alarm_is_told_once_when_it_begins() {
        let scene = Scene { separation_m: 2.0, ..Scene::default() };
        let guided = VehicleNow { mode: "GUIDED".into(), is_armed: true, follows: true, ..VehicleNow::default() };
        let mut frame = Frame {
            vehicles: vec![
                VehicleNow { number: 1, x_m: 0.0, y_m: 0.0, ..guided.clone() },
                VehicleNow { number: 7, x_m: 9.0, y_m: 0.0, ..guided },
            ],
            ..Frame::default()
        };
        let (mut alarms, now) = (Alarms::default(), Instant::now());
        let mut look = |frame: &Frame, now| alarms.look(frame, &near(&frame.vehicles, &[]), &scene, now);
        assert_eq!(look(&frame, now).1, []);
        frame.vehicles[1].set_mode("RTL");
        frame.vehicles[1].follows = false;
        let (flags, events) = look(&frame, now);
        assert_eq!(texts(&events), [(&[7][..], "left GUIDED to RTL")]);
        assert!(flags[1].has(Flags::LEFT) && !flags[0].has(Flags::LEFT));
        frame.vehicles[1].x_m = 1.5;
        assert_eq!(texts(&look(&frame, now).1), [(&[1, 7][..], "separation 1.5 m, less than 2 m")]);
        frame.vehicles[1].x_m = 2.1;
        assert!(look(&frame, now).0[0].has(Flags::SEPARATION), "no flutter at the edge");
        frame.vehicles[1].heard = Some(now);
        let (flags, events) = look(&frame, now + Duration::from_secs(5));
        assert_eq!(texts(&events), [(&[7][..], "not heard for 4 s")]);
        assert!(flags[1].has(Flags::LOST | Flags::STALE));
        assert_eq!(look(&frame, now + Duration::from_secs(6)).1, []);
        let least = alarms.least().0.unwrap();
        assert_eq!((least.value_m, &least.vehicles[..]), (1.5, &[1, 7][..]));
    }
}
