//! The scene of a scenario.

use crate::config::Scenario;
use crate::judge::COLLISION_DISTANCE_M;
use live_view::{Circle, Scene, Wind};

/// What stands still in a scenario.
pub fn scene_of(scenario: &Scenario, source: &str) -> Scene {
    let parameter = |name: &str| scenario.parameters.get(name).copied().map(f64::from);
    let wind_mps = parameter("SIM_WIND_SPD").filter(|speed_mps| *speed_mps > 0.0);
    Scene {
        title: scenario.name.clone(),
        source: source.to_owned(),
        circles: scenario
            .obstacles
            .iter()
            .map(|circle| Circle { x_m: circle.x_m, y_m: circle.y_m, radius_m: circle.radius_m })
            .collect(),
        separation_m: scenario.controller.law.safe_distance_m,
        collision_m: COLLISION_DISTANCE_M,
        altitude_m: Some(scenario.expected.altitude_m),
        // ArduPilot's own default direction.
        wind: wind_mps.map(|speed_mps| Wind { speed_mps, from_deg: parameter("SIM_WIND_DIR").unwrap_or(180.0) }),
        ..Scene::default()
    }
}
