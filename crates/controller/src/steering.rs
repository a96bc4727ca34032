//! The desired avoidance course delta of Eq. 7 (reading 8).

use crate::vector::Vec2;
use crate::{Expected, LawSettings, Obstacle, ObstacleRule};

/// Whether a vehicle perceives an obstacle: its edge within the perception distance, and some of it in the half plane
/// ahead of the vehicle (the paper's field of view of 180 degrees).
pub fn detects(law: &LawSettings, position_m: Vec2, heading: Vec2, obstacle: &Obstacle) -> bool {
    let offset = Vec2::new(obstacle.x_m, obstacle.y_m) - position_m;
    offset.norm() - obstacle.radius_m <= law.perception_distance_m && offset.dot(heading) > -obstacle.radius_m
}

/// The unit vector along delta: towards the tangent point of the steering obstacle that needs the smaller turn, or the
/// expected course where no obstacle steers. `heading` is the unit vector along the vehicle's course.
pub fn direction(
    law: &LawSettings,
    expected: &Expected,
    position_m: Vec2,
    heading: Vec2,
    obstacles: &[Obstacle],
) -> Vec2 {
    let (ex, ey) = expected.direction();
    let ahead = Vec2::new(ex, ey);
    let steers = |obstacle: &&Obstacle| {
        detects(law, position_m, heading, obstacle)
            && (law.obstacle_rule == ObstacleRule::Nearest || blocks(law, ahead, position_m, obstacle))
    };
    let mut nearest: Option<(f64, &Obstacle)> = None;
    for obstacle in obstacles.iter().filter(steers) {
        let clearance_m = obstacle.clearance_m(position_m.x, position_m.y);
        if nearest.is_none_or(|(least_m, _)| clearance_m < least_m) {
            nearest = Some((clearance_m, obstacle));
        }
    }
    nearest.map_or(ahead, |(_, obstacle)| tangent(law, position_m, heading, obstacle))
}

/// Whether the obstacle, inflated by the margin, reaches into the corridor that starts at the vehicle and runs along the
/// expected course.
fn blocks(law: &LawSettings, ahead: Vec2, position_m: Vec2, obstacle: &Obstacle) -> bool {
    let offset = Vec2::new(obstacle.x_m, obstacle.y_m) - position_m;
    offset.dot(ahead) > 0.0 && ahead.cross(offset).abs() < obstacle.radius_m + law.obstacle_margin_m
}

/// The unit vector along the tangent of the inflated circle that is nearer to the heading. Inside the inflated circle
/// there is no tangent: the vehicle is sent square to the centre and outwards, the more the deeper it is.
fn tangent(law: &LawSettings, position_m: Vec2, heading: Vec2, obstacle: &Obstacle) -> Vec2 {
    let offset = Vec2::new(obstacle.x_m, obstacle.y_m) - position_m;
    let distance_m = offset.norm().max(f64::MIN_POSITIVE);
    let to_centre = offset * (1.0 / distance_m);
    let sin = (obstacle.radius_m + law.obstacle_margin_m) / distance_m;
    let (sin, cos) = if sin <= 1.0 {
        (sin, (1.0 - sin * sin).sqrt())
    } else {
        // Outwards by up to 45 degrees where the edge itself is reached.
        let depth_m = obstacle.radius_m + law.obstacle_margin_m - distance_m;
        let outward = (depth_m / law.obstacle_margin_m.max(1e-3)).min(1.0);
        let norm = (1.0 + outward * outward).sqrt();
        (1.0 / norm, -outward / norm)
    };
    let right = Vec2::new(to_centre.x * cos - to_centre.y * sin, to_centre.y * cos + to_centre.x * sin);
    let left = Vec2::new(to_centre.x * cos + to_centre.y * sin, to_centre.y * cos - to_centre.x * sin);
    if right.dot(heading) >= left.dot(heading) { right } else { left }
}
