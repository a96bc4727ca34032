//! What the flock is told before it decides: how its members fly, where they will be, and who else is in the air.

use crate::station::vehicle::Vehicle;
use crate::station::{STALE_S, Station};
use controller::{FlockSettings, Obstacle};
use flight_model::{State, Wind};
use std::time::Duration;

/// A vehicle of which nothing is heard may be anywhere in a disc that grows by this share of its greatest speed.
const GROWTH_SHARE: f64 = 0.25;
/// The disc grows for so long, s.
const GROWTH_S: f64 = 20.0;
/// Vehicles at heights that differ by more than this are no obstacles to each other, m.
const HEIGHT_APART_M: f64 = 25.0;
/// Commands that take longer to a vehicle do not hold up the flock, s.
const LEAD_MAX_S: f64 = 2.0;

/// What a flock of these members is to know: each flies by its own model, within its own limits.
pub fn settings(station: &Station, members: &[usize]) -> FlockSettings {
    let dynamics = members.iter().map(|&index| *station.vehicles[index].present().dynamics()).collect();
    let delay_s = |&index: &usize| station.vehicles[index].present().command_delay_s();
    let slowest_s = members.iter().map(delay_s).fold(0.0, f64::max);
    FlockSettings { dynamics, ..station.scenario.flock_settings() }.behind_a_link(slowest_s)
}

/// Where the members will be when commands that are sent now act.
#[derive(Default)]
pub struct Foreseen {
    /// States then.
    pub states: Vec<State>,
    /// How far off these may be until the next command acts, m.
    pub margins_m: Vec<f64>,
    /// The speeds to which Eq. 2 adds, m/s.
    pub reference_speeds_mps: Vec<f64>,
    /// The winds in which they fly.
    pub winds: Vec<Wind>,
}

/// Where these members will be when a command reaches the last of them.
pub fn foresee(station: &mut Station, members: &[usize], now: Duration) -> Foreseen {
    let sigmas = station.scenario.controller.look_ahead.margin_sigmas;
    let period_s = station.scenario.control_period.as_secs_f64();
    let lead = |&index: &usize| station.vehicles[index].present().acts_after_s();
    let lead_s = members.iter().map(lead).fold(0.0, f64::max).min(LEAD_MAX_S);
    let mut foreseen = Foreseen::default();
    for &index in members {
        // A member was heard a moment ago: there is always an estimate.
        if let Some(estimate) = station.vehicles[index].foresee(now.as_secs_f64() + lead_s) {
            foreseen.states.push(estimate.state);
            foreseen.margins_m.push(sigmas * estimate.position_std_after_m(period_s));
            foreseen.reference_speeds_mps.push(estimate.reference_speed_mps);
            foreseen.winds.push(station.vehicles[index].present().wind());
        }
    }
    foreseen
}

/// Vehicles in the air that are no members, as circles that the flock keeps out of: along their way over the look-ahead
/// while they are heard, a disc that grows when they are not.
pub fn others(station: &Station, members: &[usize], now: Duration) -> Vec<Obstacle> {
    let look_ahead = &station.scenario.controller.look_ahead;
    let period_s = station.scenario.control_period.as_secs_f64();
    let radius_m = (look_ahead.separation_m - look_ahead.clearance_m).max(1.0);
    let flock_m = station.scenario.expected.altitude_m;
    let now_s = now.as_secs_f64();
    let mut circles = Vec::new();
    let is_other = |(index, vehicle): &(usize, &Vehicle)| !members.contains(index) && !vehicle.on_ground();
    for (_, vehicle) in station.vehicles.iter().enumerate().filter(is_other) {
        let Some((state, age_s)) = vehicle.track().carried_to(now_s, GROWTH_S) else { continue };
        if (state.altitude_m - flock_m).abs() > HEIGHT_APART_M && age_s <= STALE_S {
            continue;
        }
        if age_s > STALE_S {
            let grown_m = GROWTH_SHARE * station.limits.speed_max_mps * age_s.min(GROWTH_S);
            circles.push(Obstacle { x_m: state.x_m, y_m: state.y_m, radius_m: radius_m + grown_m });
            continue;
        }
        for step in 0..=look_ahead.steps(period_s) {
            let position_m = state.position_m() + state.velocity_mps() * (period_s * step as f64);
            circles.push(Obstacle { x_m: position_m.x, y_m: position_m.y, radius_m });
        }
    }
    circles
}
