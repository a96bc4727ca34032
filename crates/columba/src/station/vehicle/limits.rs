//! What a vehicle's own parameters allow, as limits of the model.

use flight_model::Limits;
use mavlink_bridge::kind::VehicleLimits;

/// Gravity, m/s2: how a bank is an acceleration.
const GRAVITY_MPS2: f64 = 9.81;

/// Narrows limits to those that a vehicle's own parameters set; the expected speed stays within them.
pub fn narrow(limits: &mut Limits, own: &VehicleLimits, speed_mps: f64) {
    if let Some(least) = own.speed_min_mps {
        limits.speed_min_mps = limits.speed_min_mps.max(least.min(speed_mps));
    }
    if let Some(greatest) = own.speed_max_mps {
        limits.speed_max_mps = limits.speed_max_mps.min(greatest.max(speed_mps));
    }
    if let Some(bank_rad) = own.bank_max_rad.filter(|bank_rad| (0.01..1.55).contains(bank_rad)) {
        let overload = GRAVITY_MPS2 * libm::tan(bank_rad) / limits.gravity_mps2;
        limits.lateral_overload_max = limits.lateral_overload_max.min(overload);
    }
    if let Some(climb_mps) = own.climb_max_mps.filter(|climb_mps| *climb_mps > 0.1) {
        limits.climb_max_mps = limits.climb_max_mps.min(climb_mps);
    }
    if let Some(sink_mps) = own.sink_max_mps.filter(|sink_mps| *sink_mps > 0.1) {
        limits.climb_min_mps = limits.climb_min_mps.max(-sink_mps);
    }
}
