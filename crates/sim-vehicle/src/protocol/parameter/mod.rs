//! The parameter protocol: what is asked, and how it is answered.

mod hash;
mod pace;

pub(crate) use pace::Pace;

use crate::firmware::Personality;
use crate::links::PeerId;
use crate::parameters::{Effect, Listed, Parameter, ParameterRefused};
use crate::telemetry::streams::Stream;
use crate::vehicle::Vehicle;
use mavlink_bridge::dialect::{MavParamError, MavParamType, MavSeverity, Message};
use mavlink_bridge::{ParameterRequest, Target, parameter_error, parameter_value};
use pace::PARAMETERS_AT_ONCE;
use std::time::Duration;

/// The lists that are under way, one for each peer that has asked.
#[derive(Debug, Default)]
pub(crate) struct Listings(Vec<Listing>);

#[derive(Debug)]
struct Listing {
    peer: PeerId,
    next: usize,
    /// Host time.
    due: Duration,
}

impl Listings {
    /// The earliest host time at which more of a list is to be sent.
    pub fn next_due(&self) -> Option<Duration> {
        self.0.iter().map(|listing| listing.due).min()
    }
}

impl Vehicle {
    pub(crate) fn serve_parameter(&mut self, link: usize, sender: Target, request: &ParameterRequest) {
        match request {
            ParameterRequest::List => {
                let peer = self.links.peer(link);
                // Clients that ask for all this have just connected: some learn from the next heartbeat whom they talk to.
                self.send_stream(link, Stream::Heartbeat);
                let due = self.pace.reserve(peer, self.host_now);
                // Asked again, it begins again.
                self.listings.0.retain(|listing| listing.peer != peer);
                self.listings.0.push(Listing { peer, next: 0, due });
                self.send_listings();
            }
            ParameterRequest::ReadIndex(index) => {
                // Only who completes a list asks by index.
                self.links.slow_down(link);
                match usize::try_from(*index).ok().and_then(|i| self.parameters.at(i)) {
                    Some(listed) => self.send_parameter(link, listed, u16::try_from(*index).ok()),
                    None => {
                        let reason = format!("No parameter of index {index}");
                        self.refuse_parameter(
                            link,
                            sender,
                            "",
                            *index,
                            MavParamError::MAV_PARAM_ERROR_DOES_NOT_EXIST,
                            &reason,
                        );
                    }
                }
            }
            ParameterRequest::ReadName(name) if name == hash::NAME && self.settings.personality == Personality::Px4 => {
                let (hash, count) = (f32::from_bits(hash::of(&self.parameters)), self.parameters.count() as u16);
                let value = parameter_value(hash::NAME, MavParamType::MAV_PARAM_TYPE_UINT32, hash, count, None);
                self.links.send(link, &value);
            }
            ParameterRequest::ReadName(name) => match self.parameters.find(name) {
                Some(listed) => self.send_parameter(link, listed, None),
                None => self.refuse_unknown(link, sender, name),
            },
            ParameterRequest::Set { name, value, kind } => match self.parameters.find(name) {
                Some(listed) => self.write_parameter(link, sender, listed, *value, *kind),
                None => self.refuse_unknown(link, sender, name),
            },
        }
    }

    /// Sends what is due of the lists.
    pub(crate) fn send_listings(&mut self) {
        let mut listings = std::mem::take(&mut self.listings);
        listings.0.retain_mut(|listing| {
            let Some(link) = self.links.of_peer(listing.peer) else { return false };
            self.links.slow_down(link);
            while listing.due <= self.host_now && listing.next < self.parameters.count() {
                for index in listing.next..listing.next + PARAMETERS_AT_ONCE {
                    if let Some(listed) = self.parameters.at(index) {
                        self.send_parameter(link, listed, u16::try_from(index).ok());
                    }
                }
                listing.next += PARAMETERS_AT_ONCE;
                listing.due = self.pace.reserve(listing.peer, self.host_now);
            }
            listing.next < self.parameters.count()
        });
        self.listings = listings;
    }

    /// Takes a value of a parameter, and does what it means.
    pub(crate) fn set_parameter(&mut self, parameter: Parameter, value: f32) -> Result<(), ParameterRefused> {
        if parameter == Parameter::Speedup && self.lockstep.is_some() {
            return Err(ParameterRefused::ReadOnly(self.parameters.name(parameter).into()));
        }
        self.parameters.set(parameter, value)?;
        self.parameters_changed = true;
        let value = self.parameters.get(parameter);
        match parameter.row().effect {
            Effect::SystemId => {
                // In range, so it fits.
                self.settings.system_id = value as u8;
                self.links.set_system_id(self.settings.system_id);
                self.ids.set(self.place, self.settings.system_id);
            }
            Effect::Rates(streams) => self.set_rates(streams, value),
            Effect::Tuning => self.flight.retune(self.parameters.tuning(&self.settings)),
            Effect::RadioLoss => self.links.set_loss(f64::from(value) / 100.0),
            Effect::Battery => self.world.battery.replace(),
            Effect::Fence => self.reconfigure_fence(parameter),
            Effect::Speedup => self.speedup_wanted = Some(f64::from(value)),
            Effect::SetpointTimeout => self.restart_setpoint_timeout(),
            Effect::LookedUp | Effect::ReadOnly => {}
        }
        Ok(())
    }

    fn write_parameter(&mut self, link: usize, sender: Target, listed: Listed, value: f32, kind: u8) {
        // Everybody hears of a change, from the system that they know.
        let before = self.settings.system_id;
        let taken = match listed {
            Listed::Acting(parameter) => {
                let value = self.parameters.read_wire(parameter, value, kind);
                let value = value.and_then(|value| self.check_system_id(parameter, value));
                value.and_then(|value| self.set_parameter(parameter, value))
            }
            Listed::Inert(index) => {
                self.parameters_changed = true;
                self.parameters.write_inert(index, value, kind)
            }
        };
        match taken {
            Ok(()) => {
                let after = self.settings.system_id;
                self.links.set_system_id(before);
                self.links.send_all(&self.parameter_message(listed, None));
                self.links.set_system_id(after);
            }
            Err(refused) => {
                let error = match refused {
                    ParameterRefused::ReadOnly(_) => MavParamError::MAV_PARAM_ERROR_READ_ONLY,
                    ParameterRefused::Type(_) => MavParamError::MAV_PARAM_ERROR_TYPE_MISMATCH,
                    _ => MavParamError::MAV_PARAM_ERROR_VALUE_OUT_OF_RANGE,
                };
                let name = self.parameters.on_wire(listed, |_| 0.0).0.to_owned();
                self.refuse_parameter(link, sender, &name, -1, error, &refused.to_string());
                self.send_parameter(link, listed, None);
            }
        }
    }

    /// Another vehicle's system id is not taken, if others stand behind the same port.
    fn check_system_id(&self, parameter: Parameter, value: f32) -> Result<f32, ParameterRefused> {
        let id = value as u8;
        if parameter == Parameter::SystemId && f32::from(id) == value.trunc() && self.ids.is_taken(self.place, id) {
            return Err(ParameterRefused::SystemIdTaken(id));
        }
        Ok(value)
    }

    fn set_rates(&mut self, streams: &[Stream], rate_hz: f32) {
        for &stream in streams {
            stream.set_default_rate(&mut self.settings.rates, self.settings.personality, f64::from(rate_hz));
        }
        self.links.set_default_rates(&self.settings.rates, streams, self.time);
    }

    fn send_parameter(&mut self, link: usize, listed: Listed, index: Option<u16>) {
        let message = self.parameter_message(listed, index);
        self.links.send(link, &message);
    }

    /// What it is now.
    pub(crate) fn parameter_value(&self, parameter: Parameter) -> f32 {
        match parameter {
            Parameter::RunTime => self.time.as_secs() as f32,
            Parameter::MissionTotal => self.mission.items.len() as f32,
            Parameter::FenceTotal => self.fence.total() as f32,
            Parameter::RallyTotal => self.rally.items.len() as f32,
            other => self.parameters.get(other),
        }
    }

    /// Tells everybody what it is.
    pub(crate) fn tell_parameter(&mut self, parameter: Parameter) {
        self.links.send_all(&self.parameter_message(Listed::Acting(parameter), None));
    }

    fn parameter_message(&self, listed: Listed, index: Option<u16>) -> Message {
        let (name, kind, value) = self.parameters.on_wire(listed, |acting| self.parameter_value(acting));
        parameter_value(name, kind, value, self.parameters.count() as u16, index)
    }

    fn refuse_unknown(&mut self, link: usize, sender: Target, name: &str) {
        let reason = ParameterRefused::Unknown(name.to_owned()).to_string();
        self.refuse_parameter(link, sender, name, -1, MavParamError::MAV_PARAM_ERROR_DOES_NOT_EXIST, &reason);
    }

    fn refuse_parameter(
        &mut self,
        link: usize,
        sender: Target,
        name: &str,
        index: i16,
        error: MavParamError,
        reason: &str,
    ) {
        self.say(MavSeverity::MAV_SEVERITY_WARNING, reason);
        self.links.send(link, &parameter_error(name, index, error, sender));
    }
}
