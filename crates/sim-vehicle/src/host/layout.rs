//! Which ports vehicles have: Columba's own, or those that tools for an autopilot expect.

use crate::host::clock::{HostError, port_index};
use crate::telemetry::rates::LinkUse;
use std::net::{IpAddr, Ipv4Addr, SocketAddr};

/// Where vehicles listen, and where they send telemetry unasked.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum PortLayout {
    /// UDP, one port after the other, as [`HostSettings`](crate::HostSettings) says.
    #[default]
    Columba,
    /// ArduPilot's SITL with its `sim_vehicle.py`: instance *i* takes clients at TCP 5760, 5762 and 5763 + 10 *i*,
    /// sends to UDP 14550 + 10 *i* and hears a pilot's transmitter at UDP 5501 + 10 *i*.
    ArduPilot {
        /// The instance of the first vehicle.
        instance: u16,
    },
    /// PX4's SITL: instance *i* listens at UDP 14580 + *i* and sends to 14540 + *i* (the last of these is 14549), and
    /// at 18570 + *i* and sends to 14550. On each, the first sender becomes the partner, and all telemetry goes to it.
    Px4 {
        /// The instance of the first vehicle.
        instance: u16,
    },
}

/// The ports of one vehicle, or of one group of vehicles.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct PortSet {
    pub udp: Vec<UdpPort>,
    pub tcp: Vec<SocketAddr>,
    /// Where a pilot's transmitter is heard.
    pub transmitter: Option<SocketAddr>,
}

/// One UDP port.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct UdpPort {
    /// Where it listens; port 0 is any free one.
    pub bind: SocketAddr,
    /// The address that stands for the other end, if there is only one.
    pub partner: Option<SocketAddr>,
}

impl PortLayout {
    /// Where the vehicle of an index sends telemetry unasked; `None` where that is nobody's rule but the settings' own.
    pub fn grounds(self, host: IpAddr, vehicle: usize) -> Option<Vec<SocketAddr>> {
        // Who listens at every address of the machine sends to the machine itself.
        let host = if host.is_unspecified() { IpAddr::V4(Ipv4Addr::LOCALHOST) } else { host };
        let at = |port: Option<u16>| port.map(|port| SocketAddr::new(host, port));
        match self {
            Self::Columba => None,
            Self::ArduPilot { instance } => Some(at(port(14_550, 10, instance, vehicle)).into_iter().collect()),
            Self::Px4 { instance } => {
                let api = port(14_540, 1, instance, vehicle).map(|port| port.min(14_549));
                Some([at(api), at(Some(14_550))].into_iter().flatten().collect())
            }
        }
    }

    /// What the addresses of [`grounds`](Self::grounds) are for, where the autopilot's simulator tells them apart.
    pub(crate) fn link_uses(self, host: IpAddr, vehicle: usize) -> Vec<(SocketAddr, LinkUse)> {
        match self {
            Self::Columba | Self::ArduPilot { .. } => Vec::new(),
            Self::Px4 { .. } => {
                let uses = [LinkUse::Companion, LinkUse::GroundStation];
                self.grounds(host, vehicle).into_iter().flatten().zip(uses).collect()
            }
        }
    }

    /// What every other link is for, where the autopilot's simulator has one kind alone.
    pub(crate) fn other_link_use(self) -> Option<LinkUse> {
        matches!(self, Self::ArduPilot { .. }).then_some(LinkUse::GroundStation)
    }

    /// How many vehicles have ports.
    pub fn vehicles_max(self) -> usize {
        match self {
            Self::Columba => usize::MAX,
            // The ports of telemetry end first.
            Self::ArduPilot { instance } => ((65_535 - 14_550) / 10 + 1_usize).saturating_sub(instance.into()),
            // All vehicles speak to one ground station, which knows them by their system ids.
            Self::Px4 { .. } => crate::NETWORK_VEHICLES_MAX,
        }
    }

    /// The ports of the group of an index; `base_port` counts for Columba's own, and is 0 for any free ports.
    pub(crate) fn ports(self, host: IpAddr, base_port: u16, group: usize) -> Result<PortSet, HostError> {
        let at = |port: Option<u16>| {
            let too_many = HostError::TooManyPorts { base_port, count: group + 1 };
            let port = if base_port == 0 { Some(0) } else { port };
            port.map(|port| SocketAddr::new(host, port)).ok_or(too_many)
        };
        match self {
            Self::Columba => {
                let bind = at(port(base_port, 1, 0, group))?;
                Ok(PortSet { udp: vec![UdpPort { bind, partner: None }], tcp: Vec::new(), transmitter: None })
            }
            Self::ArduPilot { instance } => {
                let serial = |base: u16| at(port(base, 10, instance, group));
                let udp = vec![UdpPort { bind: SocketAddr::new(host, 0), partner: None }];
                // Nobody would find one that is any free port.
                let transmitter = if base_port == 0 { None } else { Some(serial(5_501)?) };
                Ok(PortSet { udp, tcp: vec![serial(5_760)?, serial(5_762)?, serial(5_763)?], transmitter })
            }
            Self::Px4 { instance } => {
                let grounds = self.grounds(host, group).unwrap_or_default();
                let link = |(base, partner): (u16, SocketAddr)| {
                    Ok(UdpPort { bind: at(port(base, 1, instance, group))?, partner: Some(partner) })
                };
                let udp = [14_580, 18_570].into_iter().zip(grounds).map(link).collect::<Result<_, HostError>>()?;
                Ok(PortSet { udp, tcp: Vec::new(), transmitter: None })
            }
        }
    }

    /// The group of a vehicle: with an autopilot's ports each is alone.
    pub(crate) fn group(self, vehicle: usize, vehicles_per_port: usize) -> usize {
        if self == Self::Columba { port_index(vehicle, vehicles_per_port) } else { vehicle }
    }
}

/// A port of the vehicle of an index; none beyond the last port.
fn port(base: u16, stride: usize, instance: u16, vehicle: usize) -> Option<u16> {
    u16::try_from(usize::from(base) + stride * (usize::from(instance) + vehicle)).ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    const HOST: IpAddr = IpAddr::V4(Ipv4Addr::LOCALHOST);

    fn at(port: u16) -> SocketAddr {
        SocketAddr::new(HOST, port)
    }

    #[test]
    fn an_ardupilots_ports_are_ten_apart() {
        let layout = PortLayout::ArduPilot { instance: 1 };
        assert_eq!(layout.ports(HOST, 14_600, 1).unwrap().tcp, [at(5_780), at(5_782), at(5_783)]);
        assert_eq!(layout.ports(HOST, 14_600, 1).unwrap().transmitter, Some(at(5_521)));
        assert_eq!(layout.ports(HOST, 0, 1).unwrap().transmitter, None);
        assert_eq!(layout.grounds(HOST, 1), Some(vec![at(14_570)]));
        let last = layout.vehicles_max() - 1;
        assert_eq!(layout.grounds(HOST, last), Some(vec![at(65_530)]));
        assert!(layout.ports(HOST, 14_600, last).is_ok());
    }

    #[test]
    fn a_px4_has_two_links_and_the_tenth_port_is_the_last() {
        let layout = PortLayout::Px4 { instance: 0 };
        let udp = layout.ports(HOST, 14_600, 2).unwrap().udp;
        let links: Vec<_> = udp.iter().map(|port| (port.bind, port.partner.unwrap())).collect();
        assert_eq!(links, [(at(14_582), at(14_542)), (at(18_572), at(14_550))]);
        assert_eq!(layout.grounds(HOST, 12).unwrap()[0], at(14_549));
    }

    #[test]
    fn columbas_own_ports_follow_one_another() {
        let ports = |base, group| PortLayout::Columba.ports(HOST, base, group).map(|set| set.udp[0].bind.port());
        assert_eq!((ports(14_600, 3).unwrap(), ports(0, 3).unwrap()), (14_603, 0));
        assert!(ports(65_535, 1).is_err());
    }
}
