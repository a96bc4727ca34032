//! The parameter protocol (<https://mavlink.io/en/services/parameter.html>): what is asked, and how it is answered.

mod hash;
mod pace;
mod start;

pub(crate) use pace::Pace;

use crate::error::{ParameterError, Severity};
use crate::host::system_ids::SystemIds;
use crate::links::PeerId;
use crate::parameters::Listed;
use crate::parameters::renamed::no_parameter;
use crate::parameters::table::{Effect, Parameter, RateGroup};
use crate::telemetry::announce::Component;
use crate::telemetry::streams::{Stream, groups};
use mavlink_bridge::dialect::{MavParamError, MavParamType, Message};
use mavlink_bridge::{ParameterRequest, Target, parameter_error, parameter_value};
use pace::PARAMETERS_AT_ONCE;
use std::sync::Arc;
use std::time::Duration;

/// The lists that are under way, and what vehicles share that have peers or a port in common.
#[derive(Debug, Default)]
pub(crate) struct ParameterService {
    listings: Vec<Listing>,
    pace: Arc<Pace>,
    /// The system ids behind its port, and its place among them.
    ids: Arc<SystemIds>,
    place: usize,
    /// Whether a parameter has been set since somebody asked.
    has_changed: bool,
    /// Whether all parameters have their first values again when the vehicle starts anew.
    resets_by_reboot: bool,
    /// What a client has set SIM_SPEEDUP to, until the host takes it.
    speedup_wanted: Option<f64>,
}

/// A list that is under way, one for each peer that has asked.
#[derive(Debug)]
struct Listing {
    peer: PeerId,
    next: usize,
    /// Host time.
    due: Duration,
}

impl ParameterService {
    /// Lets vehicles that may have the same peers share the pace at which these are sent lists of parameters.
    pub fn keep_pace(&mut self, pace: Arc<Pace>) {
        self.pace = pace;
    }

    /// Tells a vehicle whom it shares a port with.
    pub fn share_port(&mut self, ids: Arc<SystemIds>, place: usize) {
        (self.ids, self.place) = (ids, place);
    }

    /// The earliest host time at which more of a list is to be sent.
    pub fn next_due(&self) -> Option<Duration> {
        self.listings.iter().map(|listing| listing.due).min()
    }

    /// Nobody has asked for a list.
    pub fn forget_listings(&mut self) {
        self.listings.clear();
    }

    /// The vehicle is switched on again: nobody has asked for a list.
    pub fn start_anew(&mut self, component: &mut Component) {
        self.forget_listings();
        if std::mem::take(&mut self.resets_by_reboot) {
            self.reset(component);
        }
    }

    /// All parameters have their first values again when the vehicle starts anew.
    pub fn reset_by_reboot(&mut self) {
        self.resets_by_reboot = true;
    }

    /// How fast the host's clock is to run, if somebody has set SIM_SPEEDUP since this was last asked.
    pub fn take_speedup(&mut self) -> Option<f64> {
        self.speedup_wanted.take()
    }

    /// The vehicle begins anew with a system id: nobody has asked for a list, and everything is to be kept anew.
    pub fn begin_anew(&mut self, system_id: u8) {
        self.forget_listings();
        self.has_changed = true;
        self.ids.set(self.place, system_id);
    }

    /// Whether another vehicle behind the same port has a system id.
    pub fn is_taken(&self, system_id: u8) -> bool {
        self.ids.is_taken(self.place, system_id)
    }

    /// Whether a parameter has been set since this was last asked.
    pub fn take_changed(&mut self) -> bool {
        std::mem::take(&mut self.has_changed)
    }

    pub fn serve(&mut self, component: &mut Component, link: usize, sender: Target, request: &ParameterRequest) {
        match request {
            ParameterRequest::List => {
                let peer = component.peers().peer(link);
                // Clients that ask for all this have just connected: some learn from the next heartbeat whom they talk
                // to.
                component.send_stream(link, Stream::Heartbeat);
                let due = self.pace.reserve(peer, component.host_now);
                // Asked again, it begins again.
                self.listings.retain(|listing| listing.peer != peer);
                self.listings.push(Listing { peer, next: 0, due });
                self.send_listings(component);
            }
            ParameterRequest::ReadIndex(index) => {
                // Only who completes a list asks by index.
                component.links().slow_down(link);
                match usize::try_from(*index).ok().and_then(|i| component.autopilot.parameters.at(i)) {
                    Some(listed) => send(component, link, listed, u16::try_from(*index).ok()),
                    // A PX4 says nothing.
                    None if component.autopilot.rules().bytewise_parameters => {}
                    None => {
                        let reason = format!("No parameter of index {index}");
                        let error = MavParamError::MAV_PARAM_ERROR_DOES_NOT_EXIST;
                        refuse(component, link, &parameter_error("", *index, error, sender), &reason);
                    }
                }
            }
            ParameterRequest::ReadName(name)
                if name == hash::NAME && component.autopilot.rules().has_parameter_hash =>
            {
                let parameters = &component.autopilot.parameters;
                let (hash, count) = (f32::from_bits(hash::of(parameters)), parameters.count() as u16);
                let value = parameter_value(hash::NAME, MavParamType::MAV_PARAM_TYPE_UINT32, hash, count, None);
                component.links().send(link, &value);
            }
            ParameterRequest::ReadName(name) => match component.autopilot.parameters.find(name) {
                Some(listed) => send(component, link, listed, None),
                None => refuse_unknown(component, link, sender, name),
            },
            ParameterRequest::Set { name, value, kind } => match component.autopilot.parameters.find(name) {
                Some(listed) => self.write(component, link, sender, listed, *value, *kind),
                None => refuse_unknown(component, link, sender, name),
            },
        }
    }

    /// Sends what is due of the lists.
    pub fn send_listings(&mut self, component: &mut Component) {
        let pace = &self.pace;
        self.listings.retain_mut(|listing| {
            let Some(link) = component.peers().of_peer(listing.peer) else { return false };
            component.links().slow_down(link);
            let count = component.autopilot.parameters.count();
            while listing.due <= component.host_now && listing.next < count {
                for index in listing.next..listing.next + PARAMETERS_AT_ONCE {
                    if let Some(listed) = component.autopilot.parameters.at(index) {
                        send(component, link, listed, u16::try_from(index).ok());
                    }
                }
                listing.next += PARAMETERS_AT_ONCE;
                listing.due = pace.reserve(listing.peer, component.host_now);
            }
            listing.next < count
        });
    }

    /// Takes a value of a parameter, and does what it means.
    ///
    /// # Errors
    /// Where the parameter is only read, or the value is out of its range.
    pub fn set(&mut self, component: &mut Component, parameter: Parameter, value: f32) -> Result<(), ParameterError> {
        component.autopilot.set_parameter(parameter, value)?;
        self.has_changed = true;
        let value = component.autopilot.parameters.get(parameter);
        match parameter.row().effect {
            Effect::SystemId => {
                // In range, so it fits.
                let system_id = value as u8;
                component.settings.system_id = system_id;
                component.links().set_system_id(system_id);
                self.ids.set(self.place, system_id);
            }
            Effect::Rates(group) => set_rates(component, group, value),
            Effect::RadioLoss => component.links().set_loss(f64::from(value) / 100.0),
            Effect::Speedup => self.speedup_wanted = Some(f64::from(value)),
            Effect::LookedUp | Effect::ReadOnly => {}
            Effect::Tuning | Effect::Battery | Effect::Fence | Effect::Points | Effect::SetpointTimeout => {}
        }
        Ok(())
    }

    fn write(&mut self, component: &mut Component, link: usize, sender: Target, listed: Listed, value: f32, kind: u8) {
        // Everybody hears of a change, from the system that they know.
        let before = component.settings.system_id;
        let taken = match listed {
            Listed::Acting(parameter) => {
                let value = component.autopilot.parameters.read_wire(parameter, value, kind);
                let value = value.and_then(|value| self.check_system_id(parameter, value));
                value.and_then(|value| self.set(component, parameter, value))
            }
            Listed::Inert(index) => {
                self.has_changed = true;
                component.autopilot.parameters.write_inert(index, value, kind)
            }
        };
        match taken {
            Ok(()) => {
                let after = component.settings.system_id;
                component.links().set_system_id(before);
                tell_listed(component, listed);
                component.links().set_system_id(after);
            }
            Err(refused) => {
                let error = match refused {
                    ParameterError::ReadOnly(_) => MavParamError::MAV_PARAM_ERROR_READ_ONLY,
                    // Those of a PX4 are of two types.
                    ParameterError::Type(_) if !is_type_of_px4(kind) => MavParamError::MAV_PARAM_ERROR_TYPE_UNSUPPORTED,
                    ParameterError::Type(_) => MavParamError::MAV_PARAM_ERROR_TYPE_MISMATCH,
                    _ => MavParamError::MAV_PARAM_ERROR_VALUE_OUT_OF_RANGE,
                };
                let name = component.autopilot.parameters.on_wire(listed, |_| 0.0).0;
                let answer = parameter_error(name, -1, error, sender);
                refuse(component, link, &answer, &refused.to_string());
                send(component, link, listed, None);
            }
        }
    }

    /// Another vehicle's system id is not taken, if others stand behind the same port.
    fn check_system_id(&self, parameter: Parameter, value: f32) -> Result<f32, ParameterError> {
        let id = value as u8;
        if parameter == Parameter::SystemId && f32::from(id) == value.trunc() && self.ids.is_taken(self.place, id) {
            return Err(ParameterError::SystemIdTaken(id));
        }
        Ok(value)
    }
}

fn is_type_of_px4(kind: u8) -> bool {
    [MavParamType::MAV_PARAM_TYPE_INT32, MavParamType::MAV_PARAM_TYPE_REAL32].iter().any(|known| *known as u8 == kind)
}

/// Tells everybody what a parameter is.
pub(crate) fn tell(component: &mut Component, parameter: Parameter) {
    tell_listed(component, Listed::Acting(parameter));
}

fn tell_listed(component: &mut Component, listed: Listed) {
    let message = message(component, listed, None);
    component.links().send_all(&message);
}

fn set_rates(component: &mut Component, group: RateGroup, rate_hz: f32) {
    let (rules, streams) = (component.autopilot.rules(), groups::of(group));
    for &stream in streams {
        stream.set_default_rate(&mut component.settings.rates, rules, f64::from(rate_hz));
    }
    let (rates, time) = (component.settings.rates, component.autopilot.time());
    component.links().set_default_rates(&rates, streams, time);
}

fn send(component: &mut Component, link: usize, listed: Listed, index: Option<u16>) {
    let message = message(component, listed, index);
    component.links().send(link, &message);
}

fn message(component: &Component, listed: Listed, index: Option<u16>) -> Message {
    let autopilot = &component.autopilot;
    let parameters = &autopilot.parameters;
    let (name, kind, value) = parameters.on_wire(listed, |acting| autopilot.parameter_value(acting));
    parameter_value(name, kind, value, parameters.count() as u16, index)
}

fn refuse_unknown(component: &mut Component, link: usize, sender: Target, name: &str) {
    let reason = no_parameter(component.autopilot.rules(), name).to_string();
    let error = MavParamError::MAV_PARAM_ERROR_DOES_NOT_EXIST;
    refuse(component, link, &parameter_error(name, -1, error, sender), &reason);
}

fn refuse(component: &mut Component, link: usize, answer: &Message, reason: &str) {
    component.say(Severity::Warning, reason);
    component.links().send(link, answer);
}
