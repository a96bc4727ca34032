//! A reset: one vehicle is as it was when the program started, while time and all others go on. No autopilot has this command;
//! MAVLink leaves MAV_CMD_USER_1 to everybody.

use crate::parameters::Parameter;
use crate::protocol::command::Refusal;
use crate::protocol::mission::{PlanKind, Plans};
use crate::vehicle::Vehicle;
use mavlink_bridge::dialect::MavSeverity;

impl Vehicle {
    /// Param 1: 1 for the reset. Param 2: 1 keeps the parameters that have been set and the plans that have been uploaded.
    pub(crate) fn reset(&mut self, [which, keeps]: [f32; 2]) -> Result<(), Refusal> {
        if which != 1.0 {
            return Err(Refusal::unsupported());
        }
        if self.lockstep.is_some() {
            return Err(Refusal::failed("Reset: not in simulated time, which its controller keeps"));
        }
        let mut settings = (*self.at_start).clone();
        if keeps == 1.0 {
            settings.kept_parameters = self.set_parameters().map(|(name, value)| (name.to_owned(), value)).collect();
            let [mission, fence, rally] = PlanKind::ALL.map(|kind| self.plan(kind).to_vec());
            settings.plans = Plans { mission, fence, rally };
        }
        let refused = |error: crate::settings::SettingsError| Refusal::failed(format!("Reset: {error}"));
        let fresh = Vehicle::new(settings).map_err(refused)?;
        let system_id = fresh.settings().system_id;
        if self.ids.is_taken(self.place, system_id) {
            return Err(Refusal::failed(format!("Reset: MAV_SYSID {system_id} is another vehicle's on this port")));
        }
        self.ids.set(self.place, system_id);
        self.begin_anew(fresh);
        // The state folder follows.
        self.parameters_changed = true;
        self.plans_changed = [true; PlanKind::ALL.len()];
        (0..self.links.len()).for_each(|link| self.announce(link));
        PlanKind::ALL.into_iter().for_each(|kind| self.tell_parameter(kind.total()));
        self.tell_parameter(Parameter::SystemId);
        self.say(MavSeverity::MAV_SEVERITY_INFO, "Reset to the start");
        Ok(())
    }
}
