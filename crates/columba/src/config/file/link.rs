//! `[link]`: the MAVLink link between vehicles and controller.

use mavlink_bridge::{ImpairmentSettings, MulticastScope};
use serde::{Deserialize, Serialize};
use sim_vehicle::PortLayout;

/// The MAVLink link between vehicles and controller.
#[derive(Clone, Debug, Deserialize, Serialize)]
#[serde(deny_unknown_fields, default)]
pub struct LinkTable {
    /// Address that everything binds to.
    pub host: String,
    /// First vehicle's port; the others follow. 0: any free ports. Where absent: 14600, or any free ports for a run in
    /// lockstep, which nobody else needs to find.
    pub vehicle_port: Option<u16>,
    /// Vehicles on one port, 1 to 250; frames find theirs by the target system.
    pub vehicles_per_port: usize,
    /// Controller's port, to which vehicles send their telemetry. Where absent: 14550, or any free port for a run.
    pub ground_port: Option<u16>,
    /// Which ports vehicles have.
    pub ports: PortsKey,
    /// With an autopilot's ports, the instance of the first vehicle.
    pub instance: u16,
    /// Whether vehicles are members of ArduPilot's multicast group too.
    pub multicast: bool,
    /// How setpoints are written in real time.
    pub setpoints: SetpointDialect,
    /// Share of datagrams that are lost, each way.
    pub loss: f64,
    /// Share that arrives twice.
    pub duplication: f64,
    /// Share that is overtaken by the next.
    pub reordering: f64,
    /// Delay of every datagram, ms, each way.
    pub delay_ms: f64,
    /// What is added to it at random, up to, ms.
    pub jitter_ms: f64,
}

/// Which ports `columba vehicles` opens.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, Serialize, clap::ValueEnum)]
#[serde(rename_all = "lowercase")]
#[value(rename_all = "lowercase")]
pub enum PortsKey {
    /// UDP 14600 and up, as `vehicle_port` and `vehicles_per_port` say.
    #[default]
    Columba,
    /// Those of ArduPilot's SITL: TCP 5760 + 10 i, telemetry to UDP 14550 + 10 i.
    ArduPilot,
    /// Those of PX4's SITL: UDP 14580 + i to 14540 + i, and 18570 + i to 14550.
    Px4,
}

impl LinkTable {
    /// The ports as a host has them.
    pub fn layout(&self) -> PortLayout {
        match self.ports {
            PortsKey::Columba => PortLayout::Columba,
            PortsKey::ArduPilot => PortLayout::ArduPilot { instance: self.instance },
            PortsKey::Px4 => PortLayout::Px4 { instance: self.instance },
        }
    }

    /// How far multicast reaches, if there is any: no further than the other ports.
    pub fn multicast(&self) -> Option<MulticastScope> {
        let is_local = self.host.parse().is_ok_and(|host: std::net::IpAddr| host.is_loopback());
        self.multicast.then_some(if is_local { MulticastScope::Host } else { MulticastScope::Network })
    }

    /// What spoils the link, the same each way.
    pub fn impairment(&self) -> ImpairmentSettings {
        ImpairmentSettings {
            loss: self.loss,
            duplication: self.duplication,
            reordering: self.reordering,
            delay_ms: self.delay_ms,
            jitter_ms: self.jitter_ms,
        }
    }
}

/// How setpoints are written in real time; a lockstep run always uses the stamped local-ned form.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, Serialize, clap::ValueEnum)]
#[serde(rename_all = "kebab-case")]
pub enum SetpointDialect {
    /// COMMAND_INT GUIDED_CHANGE_SPEED, _ALTITUDE and _HEADING, as ArduPlane takes them.
    #[default]
    Arduplane,
    /// SET_POSITION_TARGET_LOCAL_NED with velocity and altitude.
    LocalNed,
}

impl Default for LinkTable {
    fn default() -> Self {
        Self {
            host: "127.0.0.1".to_owned(),
            vehicle_port: None,
            vehicles_per_port: 1,
            ground_port: None,
            ports: PortsKey::default(),
            instance: 0,
            multicast: false,
            setpoints: SetpointDialect::default(),
            loss: 0.0,
            duplication: 0.0,
            reordering: 0.0,
            delay_ms: 0.0,
            jitter_ms: 0.0,
        }
    }
}
