//! What is shown: the scene, which seldom changes, and a frame, which is one moment of the flight.
//!
//! Lengths are metres in a local frame: x is north, y is east. Courses are radians, clockwise from north.

use serde::Serialize;
use std::sync::Arc;
use std::time::Instant;

/// What stands still, or changes seldom.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Scene {
    /// The flight's name.
    pub title: String,
    /// What feeds the page, as "columba fly" or the name of a log.
    pub source: String,
    /// Whether the operator's words are carried out.
    pub takes_words: bool,
    /// What operators may say, as "pause" or "drop N".
    pub verbs: Vec<String>,
    /// Obstacles.
    pub circles: Vec<Circle>,
    /// Fences, missions and other lines.
    pub outlines: Vec<Outline>,
    /// Two vehicles that are nearer than this have lost separation, m; 0 where that is not known.
    pub separation_m: f64,
    /// Two vehicles that are nearer than this have collided, m.
    pub collision_m: f64,
    /// The altitude that is flown, m, where there is one.
    pub altitude_m: Option<f64>,
    /// Wind, where it is known.
    pub wind: Option<Wind>,
    /// On what separations and clearances rest, in words.
    pub distances_rest_on: String,
}

/// An obstacle: a cylinder without an end.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Circle {
    /// North, m.
    pub x_m: f64,
    /// East, m.
    pub y_m: f64,
    /// Radius, m.
    pub radius_m: f64,
}

/// A line over the ground.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Outline {
    /// What it is: "fence", "mission", "route" or "goal".
    pub kind: String,
    /// The vehicle that it belongs to; none: to all.
    pub vehicle: Option<u32>,
    /// North, east and altitude of its corners, m.
    pub points_m: Vec<[f64; 3]>,
    /// Whether the last corner is joined to the first.
    pub is_closed: bool,
}

/// Wind.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Wind {
    /// m/s.
    pub speed_mps: f64,
    /// Where it comes from, degrees clockwise from north.
    pub from_deg: f64,
}

/// One moment of the flight.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Frame {
    /// Flight time, s.
    pub time_s: f64,
    /// What the vehicles' own clocks showed at flight time zero, s: for feeds that know only those.
    pub zero_s: f64,
    /// Flight seconds for each second of the wall clock; 0 while it stands still.
    pub rate: f64,
    /// Where the flight is, in a word or two.
    pub phase: String,
    /// All vehicles, always in the same order; new ones come at the end.
    pub vehicles: Vec<VehicleNow>,
    /// The least separation so far, where the flight itself measures it.
    pub least_separation: Option<Least>,
    /// The least clearance so far, where the flight itself measures it.
    pub least_clearance: Option<Least>,
}

/// A least distance so far.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Least {
    /// m.
    pub value_m: f64,
    /// Flight time, s.
    pub at_s: f64,
    /// Numbers of the vehicles: two, or one that was near a circle.
    pub vehicles: Vec<u32>,
}

/// A vehicle at one moment.
#[derive(Clone, Debug, PartialEq)]
pub struct VehicleNow {
    /// Its number, from one.
    pub number: u32,
    /// Its MAVLink system id; 0 where it has none.
    pub system_id: u8,
    /// What it is, as "ArduPlane".
    pub kind: Arc<str>,
    /// North, m; not a number while nobody knows.
    pub x_m: f32,
    /// East, m.
    pub y_m: f32,
    /// Above the local frame's zero, m.
    pub altitude_m: f32,
    /// Over the ground, m/s.
    pub speed_mps: f32,
    /// Clockwise from north, rad.
    pub course_rad: f32,
    /// The autopilot's own name of its mode.
    pub mode: Arc<str>,
    /// Whether the motors may turn.
    pub is_armed: bool,
    /// Whether its autopilot says that something is amiss.
    pub is_in_failsafe: bool,
    /// Whether it is in the mode in which it follows a controller's setpoints.
    pub follows: bool,
    /// Whether it stands on the ground.
    pub is_on_ground: bool,
    /// Whether the operator, or the station, keeps it out of the flock.
    pub is_out: bool,
    /// When its last message came; none where there is no link to be silent.
    pub heard: Option<Instant>,
    /// What the controller chose for it, where one flies it.
    pub steering: Option<Steering>,
}

/// What a controller chose for a vehicle at its last tick.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Steering {
    /// Weights of the formation, obstacle and neighbour-velocity terms.
    pub weights: [f32; 3],
    /// Speed, m/s.
    pub speed_mps: f32,
    /// Course, rad.
    pub course_rad: f32,
    /// Altitude, m.
    pub altitude_m: f32,
}

impl Default for VehicleNow {
    /// One of which nothing is known yet.
    fn default() -> Self {
        Self {
            number: 0,
            system_id: 0,
            kind: Arc::from(""),
            x_m: f32::NAN,
            y_m: f32::NAN,
            altitude_m: 0.0,
            speed_mps: 0.0,
            course_rad: 0.0,
            mode: Arc::from(""),
            is_armed: false,
            is_in_failsafe: false,
            follows: false,
            is_on_ground: false,
            is_out: false,
            heard: None,
            steering: None,
        }
    }
}

impl VehicleNow {
    /// Whether anybody knows where it is.
    pub fn is_placed(&self) -> bool {
        self.x_m.is_finite() && self.y_m.is_finite()
    }

    /// Sets the mode; the name is copied only when it changes.
    pub fn set_mode(&mut self, name: &str) {
        if *self.mode != *name {
            self.mode = Arc::from(name);
        }
    }
}

/// How much an event weighs.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Weight {
    /// Worth knowing.
    #[default]
    Note,
    /// Worth worrying about.
    Warning,
    /// The flight is not what it was meant to be.
    Fault,
}

/// Something that happened.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Event {
    /// Flight time, s.
    pub at_s: f64,
    /// Numbers of the vehicles that it is about; none: about all.
    pub vehicles: Vec<u32>,
    /// How much it weighs.
    pub weight: Weight,
    /// In words.
    pub text: String,
}
