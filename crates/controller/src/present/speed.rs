//! A slow observer of speed: the model tells how it changes, telemetry where it lies.

/// The observer takes up a difference to the measured speed with this time constant, s: slowly enough that a law with a
/// high gain, and the push of a throttle that is fed forward, do not keep each other busy.
const FOLLOW_S: f64 = 5.0;
/// The bias takes it up with this one, s: slower than the speed loop of any autopilot.
const BIAS_S: f64 = 15.0;
/// Of a difference at most so much is taken up into the bias, m/s.
const TAKEN_MAX_MPS: f64 = 1.0;
/// Greatest bias, m/s: beyond it something else is wrong.
const BIAS_MAX_MPS: f64 = 8.0;

/// Speed as a law may add to it, and what a speed setpoint has to be corrected by.
#[derive(Clone, Copy, Debug, Default)]
pub struct SpeedObserver {
    speed_mps: f64,
    bias_mps: f64,
}

impl SpeedObserver {
    /// Begins at a measured speed.
    pub fn begin(&mut self, measured_mps: f64) {
        self.speed_mps = measured_mps;
    }

    /// Some time has passed, in which the model came from the observed speed to `modelled_mps`.
    pub fn follow(&mut self, time_s: f64, modelled_mps: f64, measured_mps: f64) {
        let difference_mps = measured_mps - modelled_mps;
        self.speed_mps = modelled_mps + (time_s / FOLLOW_S).min(1.0) * difference_mps;
        // What is far off is a gust, a turn or a limit, and no bias: taken up, it would stay when they are gone.
        let taken_mps = difference_mps.clamp(-TAKEN_MAX_MPS, TAKEN_MAX_MPS);
        let bias_mps = self.bias_mps + (time_s / BIAS_S).min(1.0) * taken_mps;
        self.bias_mps = bias_mps.clamp(-BIAS_MAX_MPS, BIAS_MAX_MPS);
    }

    /// The speed, m/s.
    pub fn speed_mps(&self) -> f64 {
        self.speed_mps
    }

    /// What the vehicle flies too fast with a setpoint that is sent as it is wanted, m/s.
    pub fn bias_mps(&self) -> f64 {
        self.bias_mps
    }
}
