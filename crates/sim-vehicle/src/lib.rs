//! sim-vehicle
