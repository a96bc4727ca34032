//! Eq. 7: the obstacle avoidance term and its desired avoidance course delta (reading 8).

use crate::{Expected, LawSettings, Obstacle, ObstacleRule};
use nalgebra::Vector2;

/// Eq. 7 without its weight: C_o (V_e (cos delta, sin delta) - v_i), `towards` being the unit vector along delta.
pub fn obstacle_avoidance(
    law: &LawSettings,
    expected_speed_mps: f64,
    towards: Vector2<f64>,
    velocity_mps: Vector2<f64>,
) -> Vector2<f64> {
    (towards * expected_speed_mps - velocity_mps) * law.obstacle_gain
}

/// Whether a vehicle perceives an obstacle: its edge within the perception distance, and some of it in the half plane
/// ahead of the vehicle (the paper's field of view of 180 degrees).
pub fn detects(law: &LawSettings, position_m: Vector2<f64>, heading: Vector2<f64>, obstacle: &Obstacle) -> bool {
    let offset = obstacle.centre_m() - position_m;
    offset.norm() - obstacle.radius_m <= law.perception_distance_m && offset.dot(&heading) > -obstacle.radius_m
}

/// The unit vector along delta: towards the tangent point of the steering obstacle that needs the smaller turn, or the
/// expected course where no obstacle steers. `heading` is the unit vector along the vehicle's course, `from` along that
/// from which the turn is measured.
pub fn avoidance_course(
    law: &LawSettings,
    expected: &Expected,
    position_m: Vector2<f64>,
    heading: Vector2<f64>,
    from: Vector2<f64>,
    obstacles: &[Obstacle],
) -> Vector2<f64> {
    let ahead = expected.direction();
    let steers = |obstacle: &&Obstacle| {
        detects(law, position_m, heading, obstacle)
            && (law.obstacle_rule == ObstacleRule::Nearest || blocks(law, ahead, position_m, obstacle))
    };
    let mut nearest: Option<(f64, &Obstacle)> = None;
    for obstacle in obstacles.iter().filter(steers) {
        let clearance_m = obstacle.clearance_m(position_m);
        if nearest.is_none_or(|(least_m, _)| clearance_m < least_m) {
            nearest = Some((clearance_m, obstacle));
        }
    }
    nearest.map_or(ahead, |(_, obstacle)| tangent(law, position_m, from, obstacle))
}

/// Whether the obstacle, inflated by the margin, reaches into the corridor that starts at the vehicle and runs along
/// the expected course.
fn blocks(law: &LawSettings, ahead: Vector2<f64>, position_m: Vector2<f64>, obstacle: &Obstacle) -> bool {
    let offset = obstacle.centre_m() - position_m;
    offset.dot(&ahead) > 0.0 && ahead.perp(&offset).abs() < obstacle.radius_m + law.obstacle_margin_m
}

/// The unit vector along the tangent of the inflated circle that is nearer to another one. Inside the inflated circle
/// there is no tangent: the vehicle is sent square to the centre and outwards, the more the deeper it is.
fn tangent(law: &LawSettings, position_m: Vector2<f64>, from: Vector2<f64>, obstacle: &Obstacle) -> Vector2<f64> {
    let offset = obstacle.centre_m() - position_m;
    let distance_m = offset.norm().max(f64::MIN_POSITIVE);
    let to_centre = offset * (1.0 / distance_m);
    let inflated_m = obstacle.radius_m + law.obstacle_margin_m;
    let (sin, cos) = half_angle(distance_m, inflated_m, law.obstacle_margin_m);
    let right = Vector2::new(to_centre.x * cos - to_centre.y * sin, to_centre.y * cos + to_centre.x * sin);
    let left = Vector2::new(to_centre.x * cos + to_centre.y * sin, to_centre.y * cos - to_centre.x * sin);
    if right.dot(&from) >= left.dot(&from) { right } else { left }
}

/// Sine and cosine of the angle at the vehicle between the centre of an inflated circle and its tangent. Inside, beyond
/// a right angle, by up to 45 degrees where the edge itself is reached.
#[inline(always)]
pub(crate) fn half_angle(distance_m: f64, inflated_m: f64, margin_m: f64) -> (f64, f64) {
    let inside = distance_m < inflated_m;
    let margin_m = if margin_m > 1e-3 { margin_m } else { 1e-3 };
    let depth = (inflated_m - distance_m) / margin_m;
    let outward = std::f64::consts::FRAC_1_SQRT_2 * if depth < 1.0 { depth } else { 1.0 };
    let leg = if inside { outward } else { inflated_m / distance_m };
    let other = (1.0 - leg * leg).sqrt();
    (if inside { other } else { leg }, if inside { -leg } else { other })
}
