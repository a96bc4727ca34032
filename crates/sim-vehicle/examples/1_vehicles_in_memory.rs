//! Two vehicles in memory, an ArduPlane and a PX4, each driven by messages: both take off, fly a minute and return. No
//! sockets and no clock: it ends as soon as it is computed, and always with the same numbers.
//! `cargo run --release -p sim-vehicle --features testing --example 1_vehicles_in_memory`

use mavlink_bridge::dialect::{MavCmd, MavResult};
use sim_vehicle::testing::Client;
use sim_vehicle::{Mode, Personality, SettingsError, VehicleSettings};

fn main() -> Result<(), SettingsError> {
    for personality in [Personality::ArduPlane, Personality::Px4] {
        let settings = VehicleSettings { personality, on_ground: true, ..VehicleSettings::default() };
        let mut client = Client::new(settings)?;

        // Each autopilot has its own way to take off: an ArduPlane has a mode for it, a PX4 a command.
        let takes_off = match personality {
            Personality::Px4 => client.command(MavCmd::MAV_CMD_NAV_TAKEOFF, [0.0, 0.0, 0.0, 0.0, 0.0, 0.0, f32::NAN]),
            _ => client.command(MavCmd::MAV_CMD_DO_SET_MODE, [1.0, Mode::Takeoff.number() as f32]),
        };
        let arms = client.command(MavCmd::MAV_CMD_COMPONENT_ARM_DISARM, [1.0]);
        println!("{personality}: take-off {}, arming {}", word(takes_off), word(arms));

        for second in 0..60 {
            client.fly(1.0);
            if second % 20 == 19 {
                let state = client.vehicle().state();
                println!("  {:>3} s: {:6.1} m up, {:5.1} m/s", second + 1, state.altitude_m, state.speed_mps);
            }
        }

        let returns = client.command(MavCmd::MAV_CMD_NAV_RETURN_TO_LAUNCH, []);
        client.fly(60.0);
        let state = client.vehicle().state();
        println!("  return {}: {:.0} m from home", word(returns), libm::hypot(state.x_m, state.y_m));
        client.texts().iter().for_each(|text| println!("  said: {text}"));
    }
    Ok(())
}

fn word(result: Option<MavResult>) -> &'static str {
    match result {
        Some(MavResult::MAV_RESULT_ACCEPTED) => "accepted",
        Some(_) => "refused",
        None => "not answered",
    }
}
