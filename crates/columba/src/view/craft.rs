//! Simulated vehicles of this process, as their host reports them.

use super::plans::{Outlines, Plans, Reference, outlines};
use crate::flight::vehicle_number;
use flight_model::State;
use live_view::{Feed, Scene, VehicleNow};
use sim_vehicle::{Advance, Mode, Observer, Vehicle};
use std::sync::{Arc, Mutex};
use std::time::Duration;

/// A vehicle is shown anew so often, in wall time: twice for each look of the page.
const SHOWN_EVERY: Duration = Duration::from_millis(50);
/// Its plans are looked at once in so many times.
const PLANS_EVERY: u128 = 20;

/// An observer that shows vehicles and their plans on the page, and passes everything on to another. `speed` is vehicle
/// seconds for each second of the wall clock; none in simulated time.
pub fn watch_vehicles(feed: Feed, scene: Scene, observer: Observer, speed: Option<f64>) -> Observer {
    let period = SHOWN_EVERY.mul_f64(speed.unwrap_or(1.0)).max(Duration::from_millis(1));
    let lines = Mutex::new(Outlines::default());
    Arc::new(move |advance: Advance<'_>| {
        let end = advance.start + advance.step * advance.track.len() as u32;
        // Each vehicle in its turn, so that not all of them are shown in one stretch.
        let count = |time: Duration| time.as_nanos() / period.as_nanos();
        if count(advance.start) / PLANS_EVERY != count(end) / PLANS_EVERY
            && let Ok(mut lines) = lines.try_lock()
        {
            lines.set(vehicle_number(advance.vehicle), lines_of(advance.vehicle, advance.craft));
            // All vehicles have been looked at when it is the first one's turn again.
            if advance.vehicle == 0
                && let Some(outlines) = lines.take_changed()
            {
                feed.scene(Scene { outlines, ..scene.clone() });
            }
        }
        if count(advance.start) != count(end) {
            feed.update(|frame| {
                if frame.vehicles.len() <= advance.vehicle {
                    frame.vehicles.resize(advance.vehicle + 1, VehicleNow::default());
                }
                frame.rate = speed.unwrap_or(0.0);
                frame.time_s = end.as_secs_f64() - frame.zero_s;
                show(&mut frame.vehicles[advance.vehicle], advance.vehicle, advance.craft);
            });
        }
        observer(advance);
    })
}

/// The plans of a vehicle.
fn lines_of(index: usize, vehicle: &Vehicle) -> Vec<live_view::Outline> {
    let [mission, fence, rally] = vehicle.plan_items();
    if mission.is_empty() && fence.is_empty() && rally.is_empty() {
        return Vec::new();
    }
    let at = Reference { frame: vehicle.frame(), home_m: Some(vehicle.home_m()) };
    outlines(vehicle_number(index), at, &Plans { mission, fence, rally })
}

/// What a vehicle is now.
fn show(shown: &mut VehicleNow, index: usize, vehicle: &Vehicle) {
    place(shown, index, vehicle.state());
    shown.system_id = vehicle.settings().system_id;
    if shown.kind.is_empty() {
        shown.kind = Arc::from(vehicle.settings().personality.name());
    }
    shown.set_mode(vehicle.mode().name());
    shown.is_armed = vehicle.is_armed();
    shown.is_in_failsafe = vehicle.is_in_failsafe();
    shown.follows = matches!(vehicle.mode(), Mode::Guided | Mode::Course | Mode::Offboard);
    shown.is_on_ground = vehicle.is_on_ground();
}

/// Where a vehicle is.
pub fn place(shown: &mut VehicleNow, index: usize, state: &State) {
    shown.number = crate::flight::vehicle_number(index);
    (shown.x_m, shown.y_m) = (state.x_m as f32, state.y_m as f32);
    (shown.altitude_m, shown.speed_mps) = (state.altitude_m as f32, state.speed_mps as f32);
    shown.course_rad = state.course_rad as f32;
}
