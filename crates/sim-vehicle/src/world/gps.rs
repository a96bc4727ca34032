//! The GPS receiver: whether it has a fix, and how late and how wrong it is.

use super::noise::{Noise, Source};
use flight_model::State;
use std::collections::VecDeque;
use std::time::Duration;

/// Fewer satellites give no place.
const SATELLITES_MIN: f32 = 4.0;
/// What a receiver without a fix says it sees, as in ArduPilot's simulation.
const SATELLITES_WITHOUT_FIX: u8 = 3;

/// The receiver as it is set up.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct GpsSettings {
    /// SIM_GPS1_ENABLE, and not SIM_GPS_FAIL.
    pub is_on: bool,
    /// SIM_GPS1_LAG_MS.
    pub lag: Duration,
    /// SIM_GPS1_NOISE: standard deviation of each component of the place, m.
    pub noise_m: f64,
    /// SIM_GPS1_NUMSATS.
    pub satellites: f32,
}

/// The receiver's memory.
#[derive(Clone, Debug, Default)]
pub(crate) struct Gps {
    /// The states before the last steps, the newest last, as many as the lag is long; none without a lag.
    track: VecDeque<State>,
    /// Where the fix was lost.
    last: Option<State>,
}

impl GpsSettings {
    pub fn has_fix(&self) -> bool {
        self.is_on && self.satellites >= SATELLITES_MIN
    }

    pub fn satellites(&self) -> u8 {
        if self.has_fix() { self.satellites as u8 } else { SATELLITES_WITHOUT_FIX }
    }
}

impl Gps {
    /// Takes note of the state before a step of so long.
    pub fn step(&mut self, settings: &GpsSettings, state: &State, step: Duration) {
        if settings.has_fix() {
            self.last = None;
        } else if self.last.is_none() {
            self.last = Some(*self.track.front().unwrap_or(state));
        }
        if settings.lag < step {
            self.track.clear();
            return;
        }
        let steps = settings.lag.as_nanos() / step.as_nanos().max(1);
        self.track.push_back(*state);
        while self.track.len() as u128 > steps {
            self.track.pop_front();
        }
    }

    /// What it measures when the vehicle is in a state: late, and with the error of that tick.
    pub fn measure(&self, settings: &GpsSettings, state: &State, noise: &Noise, tick: u64) -> State {
        let measured = self.last.or_else(|| self.track.front().copied()).unwrap_or(*state);
        if settings.noise_m == 0.0 || !settings.has_fix() {
            return measured;
        }
        let [north, east, up] = noise.normals(Source::Gps, tick);
        State {
            x_m: measured.x_m + settings.noise_m * north,
            y_m: measured.y_m + settings.noise_m * east,
            altitude_m: measured.altitude_m + settings.noise_m * up,
            ..measured
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const STEP: Duration = Duration::from_millis(10);
    const GOOD: GpsSettings = GpsSettings { is_on: true, lag: Duration::ZERO, noise_m: 0.0, satellites: 10.0 };

    fn at(x_m: f64) -> State {
        State { x_m, ..State::default() }
    }

    fn fly(gps: &mut Gps, settings: &GpsSettings, from: u32, to: u32) -> State {
        (from..=to).for_each(|x| gps.step(settings, &at(f64::from(x)), STEP));
        gps.measure(settings, &at(f64::from(to)), &Noise::new(1, 1), u64::from(to))
    }

    #[test]
    fn without_faults_it_measures_what_is() {
        assert_eq!(fly(&mut Gps::default(), &GOOD, 0, 100), at(100.0));
    }

    #[test]
    fn a_lag_is_as_long_as_it_is_set() {
        let late = GpsSettings { lag: Duration::from_millis(200), ..GOOD };
        // The states before the steps from 0 to 100 are noted: now it is at 101.
        assert_eq!(fly(&mut Gps::default(), &late, 0, 100), at(81.0));
    }

    #[test]
    fn errors_are_as_large_as_set_and_the_same_for_all_who_ask() {
        let noisy = GpsSettings { noise_m: 2.0, ..GOOD };
        let (gps, noise) = (Gps::default(), Noise::new(1, 1));
        let measure = |tick| gps.measure(&noisy, &at(0.0), &noise, tick).x_m;
        assert_eq!(measure(5).to_bits(), measure(5).to_bits());
        let mean_square = (0..5_000).map(|tick| measure(tick) * measure(tick)).sum::<f64>() / 5_000.0;
        assert!((mean_square.sqrt() - 2.0).abs() < 0.1);
    }

    #[test]
    fn without_a_fix_it_stays_where_it_was() {
        let mut gps = Gps::default();
        fly(&mut gps, &GOOD, 0, 50);
        for bad in [GpsSettings { is_on: false, ..GOOD }, GpsSettings { satellites: 3.0, ..GOOD }] {
            assert_eq!((bad.has_fix(), bad.satellites()), (false, 3));
            assert_eq!(fly(&mut gps, &bad, 51, 80), at(51.0));
        }
        assert_eq!(fly(&mut gps, &GOOD, 81, 81), at(81.0));
    }
}
