//! A page about vehicles that fly in circles: `1_many_vehicles [HOW MANY] [SECONDS]`.
//!
//! Prints the address, and at the end what the page's thread cost. This is how docs/performance.md measures the page.

use live_view::{Circle, Frame, LiveView, Scene, Settings, Steering, VehicleNow, Weight};
use std::time::{Duration, Instant};

const SPEED_MPS: f32 = 15.0;
const SPACING_M: f32 = 30.0;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut arguments = std::env::args().skip(1);
    let vehicles: usize = arguments.next().map_or(Ok(200), |text| text.parse())?;
    let seconds: f64 = arguments.next().map_or(Ok(f64::INFINITY), |text| text.parse())?;
    let view = LiveView::start(&Settings::default())?;
    println!("{}", view.url());
    let feed = view.feed();
    feed.scene(Scene {
        title: format!("{vehicles} vehicles in circles"),
        source: "an example".into(),
        circles: vec![Circle { x_m: 40.0, y_m: -60.0, radius_m: 25.0 }],
        separation_m: 2.0,
        collision_m: 1.0,
        altitude_m: Some(50.0),
        ..Scene::default()
    });
    feed.tell(live_view::Event { text: "they fly".into(), weight: Weight::Note, ..Default::default() });
    let began = Instant::now();
    while began.elapsed().as_secs_f64() < seconds {
        let time_s = began.elapsed().as_secs_f64();
        feed.update(|frame| fly(frame, vehicles, time_s));
        std::thread::sleep(Duration::from_millis(50));
    }
    eprintln!("{} pages, refused {:?}", view.pages(), view.refused());
    Ok(())
}

/// Puts everybody where they are at a time.
fn fly(frame: &mut Frame, vehicles: usize, time_s: f64) {
    frame.time_s = time_s;
    frame.rate = 1.0;
    frame.phase = "fly".into();
    frame.vehicles.resize(vehicles, VehicleNow::default());
    let side = (vehicles as f32).sqrt().ceil() as usize;
    for (index, vehicle) in frame.vehicles.iter_mut().enumerate() {
        let radius_m = 8.0 + (index % 7) as f32;
        let angle_rad = SPEED_MPS / radius_m * time_s as f32 + index as f32;
        vehicle.number = index as u32 + 1;
        vehicle.x_m = SPACING_M * (index / side) as f32 + radius_m * libm::cosf(angle_rad);
        vehicle.y_m = SPACING_M * (index % side) as f32 + radius_m * libm::sinf(angle_rad);
        vehicle.altitude_m = 40.0 + (index % 20) as f32;
        vehicle.speed_mps = SPEED_MPS;
        vehicle.course_rad = angle_rad + std::f32::consts::FRAC_PI_2;
        // One of a hundred leaves GUIDED after ten seconds.
        let has_left = index % 100 == 7 && time_s > 10.0;
        vehicle.set_mode(if has_left { "RTL" } else { "GUIDED" });
        vehicle.follows = !has_left;
        vehicle.is_armed = true;
        vehicle.heard = Some(Instant::now());
        let weight = |phase: f32| 1.0 + libm::sinf(0.3 * time_s as f32 + phase + index as f32);
        vehicle.steering = Some(Steering {
            weights: [weight(0.0), weight(1.0), weight(2.0)],
            speed_mps: SPEED_MPS,
            course_rad: vehicle.course_rad,
            altitude_m: 50.0,
        });
    }
}
