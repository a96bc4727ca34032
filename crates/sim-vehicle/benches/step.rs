//! What one integration step of one vehicle costs, without telemetry and with it.
#![allow(clippy::expect_used)]

use divan::{Bencher, black_box};
use flight_model::Setpoint;
use mavlink_bridge::PlanItem;
use sim_vehicle::{Plans, TelemetryRates, Vehicle, VehicleSettings};
use std::time::Duration;

fn main() {
    divan::main();
}

/// Steps in one sample: ten seconds of flight.
const STEPS: u32 = 1000;

fn fly(bencher: Bencher<'_, '_>, settings: VehicleSettings) {
    let mut vehicle = Vehicle::new(VehicleSettings { setpoint_timeout_s: 0.0, ..settings }).expect("valid settings");
    let mut track = Vec::with_capacity(STEPS as usize);
    let step = vehicle.settings().step;
    bencher.counter(divan::counter::ItemsCount::new(STEPS)).bench_local(|| {
        track.clear();
        vehicle.advance(vehicle.time() + step * STEPS, &mut track);
        while let Some(transmit) = vehicle.poll_transmit() {
            black_box(transmit);
        }
        black_box(track.last());
    });
}

#[divan::bench]
fn without_telemetry(bencher: Bencher<'_, '_>) {
    fly(bencher, VehicleSettings { ground: None, ..VehicleSettings::default() });
}

/// Inside a polygon of a hundred corners, which is looked at in each step.
#[divan::bench]
fn within_a_fence_of_100_corners(bencher: Bencher<'_, '_>) {
    const CORNERS: u16 = 100;
    let settings = VehicleSettings::default();
    let corner = |index: u16| {
        let bearing_rad = std::f64::consts::TAU * f64::from(index) / f64::from(CORNERS);
        let place = settings.frame.to_geodetic(1e5 * libm::cos(bearing_rad), 1e5 * libm::sin(bearing_rad), 0.0);
        PlanItem {
            command: 5001,
            params: [f32::from(CORNERS), 0.0, 0.0, 0.0],
            latitude_e7: (place.latitude_deg * 1e7) as i32,
            longitude_e7: (place.longitude_deg * 1e7) as i32,
            ..PlanItem::default()
        }
    };
    let plans = Plans { fence: (0..CORNERS).map(corner).collect(), ..Plans::default() };
    let parameters = vec![("FENCE_ENABLE".to_owned(), 1.0)];
    fly(bencher, VehicleSettings { ground: None, plans, default_parameters: parameters, ..settings });
}

#[divan::bench]
fn with_default_telemetry(bencher: Bencher<'_, '_>) {
    fly(bencher, VehicleSettings::default());
}

#[divan::bench]
fn with_position_only(bencher: Bencher<'_, '_>) {
    let rates = TelemetryRates { local_position_ned_hz: 10.0, ..TelemetryRates::OFF };
    fly(bencher, VehicleSettings { rates, ..VehicleSettings::default() });
}

/// A control tick of a run in memory: one setpoint, then fifty steps.
#[divan::bench]
fn memory_tick(bencher: Bencher<'_, '_>) {
    let settings = VehicleSettings { ground: None, ..VehicleSettings::default() };
    let mut vehicle = Vehicle::new(settings).expect("valid settings");
    let mut track = Vec::with_capacity(50);
    let mut course_rad = 0.0;
    bencher.bench_local(|| {
        track.clear();
        course_rad = 0.5 - course_rad;
        let _ = vehicle.command(black_box(&Setpoint { speed_mps: 10.0, course_rad, altitude_m: 50.0 }));
        vehicle.advance(vehicle.time() + Duration::from_millis(500), &mut track);
    });
}
