//! How things stand at one moment, for those who watch over something.

use crate::autopilot::fence::Fence;
use crate::autopilot::flight::Flight;
use crate::firmware::rules::Rules;
use crate::mode::Mode;
use crate::parameters::Parameters;
use crate::parameters::table::Parameter;
use crate::world::{GpsSettings, World};
use std::time::Duration;

/// How things stand.
#[derive(Clone, Copy)]
pub(crate) struct Situation<'a> {
    /// Vehicle time.
    pub time: Duration,
    pub rules: &'static Rules,
    pub flight: &'a Flight,
    pub fence: &'a Fence,
    pub parameters: &'a Parameters,
    pub world: &'a World,
    /// Whether time stands still between setpoints.
    pub is_in_lockstep: bool,
}

impl Situation<'_> {
    #[inline]
    pub fn get(&self, parameter: Parameter) -> f32 {
        self.parameters.get(parameter)
    }

    #[inline]
    pub fn mode(&self) -> Mode {
        self.flight.mode()
    }

    #[inline]
    pub fn is_armed(&self) -> bool {
        self.flight.is_armed()
    }

    #[inline]
    pub fn has_fix(&self) -> bool {
        GpsSettings::of(self.parameters).has_fix()
    }
}
