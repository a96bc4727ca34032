use super::ground::TouchDown;
use super::*;
use flight_model::Wind;

fn settings() -> VehicleSettings {
    let start = State { x_m: 5.0, y_m: -3.0, altitude_m: 50.0, speed_mps: 10.0, course_rad: 0.3, climb_mps: 0.0 };
    VehicleSettings { start, ..VehicleSettings::default() }
}

fn fly(flight: &mut Flight, seconds: f64) -> State {
    for _ in 0..(seconds * 100.0).round() as usize {
        flight.step();
    }
    *flight.state()
}

fn from_centre(state: &State, (x, y): (f64, f64)) -> f64 {
    (state.position_m() - Vector2::new(x, y)).norm()
}

#[test]
fn armed_it_holds_its_start() {
    let mut flight = Flight::new(&settings());
    let end = fly(&mut flight, 10.0);
    assert!((end.x_m - (5.0 + 100.0 * libm::cos(0.3))).abs() < 1e-9);
    assert!((end.y_m - (-3.0 + 100.0 * libm::sin(0.3))).abs() < 1e-9);
    assert_eq!((end.speed_mps, end.course_rad, end.altitude_m), (10.0, 0.3, 50.0));
}

#[test]
fn disarmed_it_waits_on_the_rail() {
    let mut flight = Flight::new(&VehicleSettings { armed: false, ..settings() });
    let waiting = fly(&mut flight, 5.0);
    assert_eq!((waiting.x_m, waiting.y_m, waiting.speed_mps), (5.0, -3.0, 0.0));
    flight.arm();
    assert_eq!(*flight.state(), settings().start);
    assert!(from_centre(&fly(&mut flight, 1.0), (5.0, -3.0)) > 9.99);
}

#[test]
fn a_ramp_asked_for_on_the_rail_begins_at_the_release() {
    let mut flight = Flight::new(&VehicleSettings { armed: false, ..settings() });
    flight.set_speed(14.0, 0.5);
    fly(&mut flight, 5.0);
    flight.arm();
    let speed_mps = fly(&mut flight, 2.0).speed_mps;
    assert!(speed_mps > 10.0 && speed_mps < 11.0, "{speed_mps}");
}

#[test]
fn a_lateral_limit_is_a_ramp_then_the_closed_form() {
    let mut flight = Flight::new(&settings());
    flight.set_course(1.3, 5.0); // 0.5 rad/s at 10 m/s, left at an error of 0.375 rad
    let end = fly(&mut flight, 3.0);
    let expected = 1.3 - 0.375 * libm::exp(-(3.0 - 1.25) / 0.75);
    assert!((end.course_rad - expected).abs() < 1e-9);
    assert!((flight.turn_rate_radps() - 0.5 * libm::exp(-1.75 / 0.75)).abs() < 0.01);
}

#[test]
fn ramps_hold_their_rates() {
    let mut flight = Flight::new(&settings());
    flight.set_speed(14.0, 0.5);
    flight.set_altitude(60.0, 1.0);
    // Behind a ramp a loop lags by its time constant(s): 1 s for speed, 1/3 + 3 s for altitude.
    let end = fly(&mut flight, 7.0);
    assert!((end.speed_mps - (10.0 + 0.5 * (7.0 - 1.0 * (1.0 - libm::exp(-7.0))))).abs() < 0.01);
    let later = fly(&mut flight, 1.0);
    assert!((later.climb_mps - 1.0).abs() < 0.1);
    let end = fly(&mut flight, 30.0);
    assert!((end.speed_mps - 14.0).abs() < 1e-6 && (end.altitude_m - 60.0).abs() < 1e-2);
}

#[test]
fn a_ramp_goes_on_from_the_demand_and_not_from_the_speed_behind_it() {
    let mut flight = Flight::new(&settings());
    flight.set_speed(14.0, 0.5);
    let behind_mps = fly(&mut flight, 2.0).speed_mps;
    assert!(behind_mps < 10.7 && (flight.speed_demand_mps() - 11.0).abs() < 1e-9);
    flight.set_speed(14.1, 0.5);
    assert!((flight.speed_demand_mps() - 11.0).abs() < 1e-9);
}

#[test]
fn loiter_circles_where_it_was_entered() {
    let mut flight = Flight::new(&settings());
    fly(&mut flight, 3.0);
    let entry = *flight.state();
    flight.set_mode(Mode::Loiter);
    for _ in 0..100 {
        let state = fly(&mut flight, 1.0);
        assert_eq!(state.altitude_m, entry.altitude_m);
        assert!(from_centre(&state, (entry.x_m, entry.y_m)) < 60.6);
    }
    assert!((from_centre(flight.state(), (entry.x_m, entry.y_m)) - 60.0).abs() < 0.05);
}

#[test]
fn rtl_circles_home() {
    let mut flight = Flight::new(&settings());
    fly(&mut flight, 60.0);
    flight.set_mode(Mode::Rtl);
    let end = fly(&mut flight, 150.0);
    assert!((from_centre(&end, (0.0, 0.0)) - 60.0).abs() < 0.05);
}

#[test]
fn guided_again_circles_and_forgets_old_setpoints() {
    let mut flight = Flight::new(&settings());
    flight.set_course(1.0, 0.05);
    flight.set_mode(Mode::Cruise);
    fly(&mut flight, 1.0);
    flight.set_mode(Mode::Guided);
    let entry = *flight.state();
    let end = fly(&mut flight, 120.0);
    assert!((from_centre(&end, (entry.x_m, entry.y_m)) - 60.0).abs() < 0.05);
    flight.set_course(0.0, f64::INFINITY);
    assert!(fly(&mut flight, 10.0).course_rad.abs() < 1e-4);
    flight.set_mode(Mode::Guided); // a repeat changes nothing
    assert!(fly(&mut flight, 1.0).course_rad.abs() < 1e-4);
    flight.release_course();
    let end = fly(&mut flight, 200.0);
    assert!((from_centre(&end, (entry.x_m, entry.y_m)) - 60.0).abs() < 0.05);
}

fn on_ground() -> Flight {
    Flight::new(&VehicleSettings { on_ground: true, ..settings() })
}

/// Flies until something happens between it and the ground.
fn fly_to_ground(flight: &mut Flight) -> f64 {
    (0..100_000).find_map(|_| flight.step()).map(|TouchDown { sink_mps }| sink_mps).unwrap()
}

#[test]
fn it_stands_on_the_ground_until_it_takes_off() {
    let mut flight = on_ground();
    let stands = State { altitude_m: 0.0, speed_mps: 0.0, ..settings().start };
    for mode in [Mode::Manual, Mode::Guided, Mode::Loiter, Mode::Rtl] {
        flight.set_mode(mode);
        flight.arm();
        assert_eq!(fly(&mut flight, 2.0), stands);
        assert!(!flight.is_flying());
        flight.disarm();
    }
    flight.set_mode(Mode::Takeoff);
    assert_eq!(fly(&mut flight, 2.0), stands);
    flight.arm();
    let end = fly(&mut flight, 200.0);
    assert!((end.altitude_m - TAKEOFF_ALTITUDE_M).abs() < 1e-3, "{end:?}");
    assert!((end.speed_mps - 10.0).abs() < 1e-3);
    assert!(!flight.is_taking_off());
}

#[test]
fn the_run_is_straight_and_lifts_off_at_the_least_speed() {
    let mut flight = on_ground();
    flight.set_mode(Mode::Takeoff);
    flight.arm();
    while flight.is_on_ground() {
        assert_eq!(flight.state().course_rad, 0.3);
        flight.step();
    }
    assert!((flight.state().speed_mps - 5.0).abs() < 0.04);
    // v^2 / 2a
    assert!((from_centre(flight.state(), (5.0, -3.0)) - 25.0 / 6.0).abs() < 0.1);
}

#[test]
fn a_landing_touches_down_softly_at_its_place_from_wherever_it_begins() {
    for (x, y) in [(400.0, 0.0), (-150.0, 200.0), (20.0, -10.0), (60.0, 0.0), (0.0, 0.0), (5.0, -3.0)] {
        for altitude_m in [10.0, 50.0, 120.0] {
            let start = State { altitude_m, ..settings().start };
            let mut flight = Flight::new(&VehicleSettings { start, mode: Mode::Auto, ..settings() });
            flight.land_at(Vector2::new(x, y));
            let sink_mps = fly_to_ground(&mut flight);
            let miss_m = from_centre(flight.state(), (x, y));
            assert!(sink_mps < 0.4 && miss_m < 3.0, "{sink_mps} {miss_m} at ({x}, {y}) from {altitude_m} m");
            let end = fly(&mut flight, 10.0);
            assert!(end.speed_mps == 0.0 && end.altitude_m == 0.0 && flight.is_armed());
            assert!(from_centre(&end, (x, y)) < 25.0);
        }
    }
}

#[test]
fn without_its_engine_it_glides_down() {
    let mut flight = Flight::new(&settings());
    fly(&mut flight, 1.0);
    flight.set_engine(false);
    let gliding = fly(&mut flight, 20.0);
    assert!((gliding.speed_mps - 5.0).abs() < 1e-6 && (gliding.climb_mps + 0.5).abs() < 1e-3, "{gliding:?}");
    let sink_mps = fly_to_ground(&mut flight);
    assert!((sink_mps - 0.5).abs() < 1e-3 && flight.is_armed());
}

#[test]
fn an_engine_that_works_again_flies_on() {
    let mut flight = Flight::new(&settings());
    flight.disarm();
    assert!(fly(&mut flight, 20.0).altitude_m < 50.0);
    flight.arm();
    let end = fly(&mut flight, 60.0);
    assert!((end.altitude_m - 50.0).abs() < 1e-2 && (end.speed_mps - 10.0).abs() < 1e-3);
}

#[test]
fn who_dives_into_the_ground_stays_there_disarmed() {
    let mut flight = Flight::new(&settings());
    flight.set_altitude(-50.0, f64::INFINITY);
    assert!(fly_to_ground(&mut flight) > 3.0);
    assert!(!flight.is_armed() && !flight.is_flying());
    assert_eq!(flight.state().speed_mps, 0.0);
}

#[test]
fn a_landing_in_wind_touches_down_near_its_place() {
    for wind_mps in [3.0, 6.0] {
        for from_deg in [0.0, 45.0, 90.0, 180.0, 225.0, 315.0_f64] {
            for (x, y) in [(400.0, 0.0), (-150.0, 200.0), (20.0, -10.0)] {
                let wind = Wind::from_direction(wind_mps, from_deg.to_radians());
                let mut flight = Flight::new(&VehicleSettings { mode: Mode::Auto, ..settings() });
                flight.land_at(Vector2::new(x, y));
                let TouchDown { sink_mps } = (0..100_000)
                    .find_map(|_| {
                        flight.feel(wind, None);
                        flight.step()
                    })
                    .unwrap();
                let miss_m = from_centre(flight.state(), (x, y));
                assert!(
                    sink_mps < 0.4 && miss_m < 8.0,
                    "{sink_mps} {miss_m} at ({x}, {y}), {wind_mps} m/s from {from_deg}"
                );
            }
        }
    }
}
