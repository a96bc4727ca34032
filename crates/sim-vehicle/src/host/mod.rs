//! The host: sockets and a clock for any number of vehicles. All that they do is in [`crate::vehicle::Vehicle`].

pub(crate) mod clock;
pub(crate) mod endpoint;
pub(crate) mod layout;
pub(crate) mod lines;
pub(crate) mod system_ids;
mod tcp;

use crate::counters::VehicleCounters;
use crate::host::clock::{Clock, HostError, NETWORK_VEHICLES_MAX, Observer, RealTime, port_index};
use crate::host::endpoint::{Endpoint, EndpointReport, Shell, stopped};
use crate::host::layout::PortLayout;
use crate::host::lines::{Lines, Protocol};
use crate::parameters::file::{self, ParameterFileError};
use crate::protocol::mission::file as plan_file;
use crate::protocol::parameter::Pace;
use crate::settings::{SettingsError, VehicleSettings};
use crate::vehicle::Vehicle;
use mavlink_bridge::{Counters, LinkError, LinkSettings, MULTICAST_GROUP, MulticastLink, MulticastScope};
use std::fmt;
use std::net::{IpAddr, Ipv4Addr, SocketAddr};
use std::path::PathBuf;
use std::sync::Arc;
use std::time::Duration;
use tokio::sync::watch;
use tokio::task::JoinSet;
use tokio::time::Instant;

/// Where the vehicles listen and what time they keep.
#[derive(Clone, Debug)]
pub struct HostSettings {
    /// Address of the interface.
    pub bind: IpAddr,
    /// Port of the first vehicle or group; each further one has the next port. 0: any free ports.
    pub base_port: u16,
    /// Vehicles on one port, 1 to 250: the rest go to the next, as each further network of 250 does. Frames find theirs
    /// by the target system.
    pub vehicles_per_port: usize,
    /// Which ports these are; with an autopilot's, `base_port` does not count but for 0, any free ports, and each
    /// vehicle is alone.
    pub layout: PortLayout,
    /// Whether all vehicles are members of [`MULTICAST_GROUP`] too, and how far that reaches.
    pub multicast: Option<MulticastScope>,
    /// The clock.
    pub clock: Clock,
    /// Receive buffer and impairment of every port. Each port draws its own random numbers from the seed.
    pub link: LinkSettings,
    /// Folder of the files in which parameters and plans survive a restart, `vehicle-1.parm`, `vehicle-1-mission.txt`
    /// and so on; none: they do not.
    pub state_folder: Option<PathBuf>,
}

impl Default for HostSettings {
    fn default() -> Self {
        Self {
            bind: IpAddr::V4(Ipv4Addr::LOCALHOST),
            base_port: 14600,
            vehicles_per_port: 1,
            layout: PortLayout::Columba,
            multicast: None,
            clock: Clock::WALL,
            link: LinkSettings::default(),
            state_folder: None,
        }
    }
}

/// What became of a host's vehicles.
#[derive(Clone, Debug, Default, PartialEq, serde::Serialize)]
pub struct HostReport {
    /// Each vehicle's counters, in the order in which the host was given them.
    pub vehicles: Vec<VehicleCounters>,
    /// What all ports together have seen.
    pub wire: Counters,
    /// In real time, vehicle seconds for each second of the wall clock: less than was asked for where the machine did
    /// not keep up.
    pub speed_reached: Option<f64>,
    /// In real time, what was asked for: the mean, where SIM_SPEEDUP changed it on the way.
    pub speed_asked: Option<f64>,
}

/// Vehicles with their ports bound, ready to run.
///
/// ```
/// use sim_vehicle::{Host, HostSettings, VehicleSettings};
/// use std::sync::Arc;
/// use std::time::Duration;
///
/// # tokio::runtime::Builder::new_current_thread().enable_all().build().unwrap().block_on(async {
/// let settings = HostSettings { base_port: 0, ..HostSettings::default() };
/// let vehicles = (1..=2).map(|system_id| VehicleSettings { system_id, ground: None, ..VehicleSettings::default() });
/// let host = Host::bind(&settings, vehicles.collect())?;
/// println!("they listen on {:?}", host.addresses());
///
/// let (stop, stopped) = tokio::sync::watch::channel(false);
/// let running = tokio::spawn(host.run(Arc::new(|advance| assert!(!advance.track.is_empty())), stopped));
/// tokio::time::sleep(Duration::from_millis(50)).await;
/// stop.send_replace(true);
/// let report = running.await.unwrap()?;
/// assert_eq!(report.vehicles.len(), 2);
/// # Ok::<(), sim_vehicle::HostError>(())
/// # }).unwrap();
/// ```
pub struct Host {
    endpoints: Vec<Endpoint>,
    addresses: Vec<SocketAddr>,
    clock: Clock,
    begins: Option<watch::Receiver<bool>>,
}

impl fmt::Debug for Host {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Host").field("addresses", &self.addresses).field("clock", &self.clock).finish_non_exhaustive()
    }
}

impl Host {
    /// Binds the ports of all vehicles, or none of them. Must be called within a Tokio runtime.
    ///
    /// # Errors
    /// A setting is out of its range, a vehicle's settings are not valid, a file of the state folder cannot be read, or
    /// a port cannot be bound.
    pub fn bind(settings: &HostSettings, vehicles: Vec<VehicleSettings>) -> Result<Self, HostError> {
        settings.validate(vehicles.len())?;
        let pace = Arc::new(Pace::default());
        let vehicles: Vec<Vehicle> = vehicles
            .into_iter()
            .enumerate()
            .map(|(vehicle, mut own)| {
                if let Some(folder) = &settings.state_folder {
                    own.kept_parameters = file::read_kept(&file::path(folder, vehicle))?;
                    own.plans = plan_file::read(folder, vehicle, own.personality)?;
                }
                settings.set_grounds(vehicle, &mut own);
                let built = match settings.clock {
                    Clock::Lockstep(lockstep) => Vehicle::in_lockstep(own, lockstep),
                    Clock::RealTime { .. } => Vehicle::new(own),
                };
                let mut built = built.map_err(|source| match source {
                    SettingsError::ParameterFile { place, reason } => {
                        ParameterFileError::Refused { place, reason }.into()
                    }
                    source => HostError::Vehicle { vehicle, source },
                })?;
                built.parameter_service().keep_pace(Arc::clone(&pace));
                Ok(built)
            })
            .collect::<Result<_, HostError>>()?;

        let mut host = Self { endpoints: Vec::new(), addresses: Vec::new(), clock: settings.clock, begins: None };
        let mut vehicles = vehicles.into_iter().enumerate().peekable();
        // An early return drops the endpoints bound so far, and so frees their ports.
        while let Some(&(first, _)) = vehicles.peek() {
            let port = settings.port_of(first);
            let is_of_port = |(vehicle, _): &(usize, Vehicle)| settings.port_of(*vehicle) == port;
            let group: Vec<Vehicle> =
                std::iter::from_fn(|| vehicles.next_if(is_of_port)).map(|(_, vehicle)| vehicle).collect();
            let ports = settings.layout.ports(settings.bind, settings.base_port, port)?;
            let multicast = settings.multicast.map(|scope| MulticastLink::join(MULTICAST_GROUP, scope)).transpose()?;
            let lines = Lines::open(&ports, &settings.link_settings(port), multicast)?;
            let address = lines.local_addr()?;
            host.addresses.resize(first + group.len(), address);
            let mut endpoint = Endpoint::new(lines, group, first)?;
            endpoint.state_folder.clone_from(&settings.state_folder);
            host.endpoints.push(endpoint);
        }
        Ok(host)
    }

    /// The flight begins when `begins` holds true or its sender is gone: until then the vehicles answer and tell where
    /// they are, and stay there.
    #[must_use]
    pub fn beginning_when(mut self, begins: watch::Receiver<bool>) -> Self {
        self.begins = Some(begins);
        self
    }

    /// The address that each vehicle listens on, in the order in which the host was given them.
    pub fn addresses(&self) -> &[SocketAddr] {
        &self.addresses
    }

    /// Every address that each vehicle listens on, in the order in which the host was given them.
    pub fn lines(&self) -> impl Iterator<Item = Vec<(Protocol, SocketAddr)>> {
        let of_endpoint = |endpoint: &Endpoint| vec![endpoint.lines().addresses(); endpoint.vehicles().count()];
        self.endpoints.iter().flat_map(of_endpoint)
    }

    /// The vehicles, in the order in which the host was given them.
    pub fn vehicles(&self) -> impl Iterator<Item = &Vehicle> {
        self.endpoints.iter().flat_map(Endpoint::vehicles)
    }

    /// Runs the vehicles until `stop` holds true or its sender is gone; without vehicles, returns at once. The ports
    /// are free when this returns.
    ///
    /// # Errors
    /// A port fails: then all vehicles stop.
    pub async fn run(self, observer: Observer, mut stop: watch::Receiver<bool>) -> Result<HostReport, HostError> {
        let (stop_all, stop_endpoints) = watch::channel(false);
        let mut tasks: JoinSet<Result<EndpointReport, LinkError>> = JoinSet::new();
        let time = RealTime::new(self.clock.speed());
        let shell = Arc::new(Shell { started: Instant::now(), clock: self.clock, time, observer, begins: self.begins });
        for endpoint in self.endpoints {
            tasks.spawn(endpoint.run(Arc::clone(&shell), stop_endpoints.clone()));
        }
        let mut report =
            HostReport { vehicles: vec![VehicleCounters::default(); self.addresses.len()], ..HostReport::default() };
        let mut failure = None;
        let mut running = true;
        loop {
            tokio::select! {
                () = stopped(&mut stop), if running => {
                    running = false;
                    let is_real_time = matches!(self.clock, Clock::RealTime { .. });
                    let (reached, asked) = shell.time.reached_and_asked(shell.started.elapsed());
                    report.speed_reached = is_real_time.then_some(reached);
                    report.speed_asked = is_real_time.then_some(asked);
                    stop_all.send_replace(true);
                }
                joined = tasks.join_next() => match joined {
                    None => break,
                    Some(Ok(Ok(endpoint))) => {
                        report.wire += endpoint.wire;
                        for (index, counters) in endpoint.vehicles {
                            if let Some(slot) = report.vehicles.get_mut(index) {
                                *slot = counters;
                            }
                        }
                    }
                    Some(Ok(Err(error))) => {
                        // One port that fails stops the flight: the others would fly on without it.
                        failure.get_or_insert(error);
                        running = false;
                        stop_all.send_replace(true);
                    }
                    Some(Err(join_error)) => {
                        if let Ok(panic) = join_error.try_into_panic() {
                            std::panic::resume_unwind(panic);
                        }
                    }
                },
            }
        }
        match failure {
            Some(error) => Err(error.into()),
            None => Ok(report),
        }
    }
}

impl HostSettings {
    fn validate(&self, vehicles: usize) -> Result<(), HostError> {
        if !(1..=NETWORK_VEHICLES_MAX).contains(&self.vehicles_per_port) {
            let value = self.vehicles_per_port as f64;
            return Err(HostError::Setting { name: "vehicles_per_port", value, range: "[1, 250]" });
        }
        if let Clock::RealTime { speed, tick } = self.clock {
            if !(0.001..=1000.0).contains(&speed) {
                return Err(HostError::Setting { name: "speed", value: speed, range: "[0.001, 1000]" });
            }
            if !(Duration::from_millis(1)..=Duration::from_secs(1)).contains(&tick) {
                return Err(HostError::Setting { name: "tick_s", value: tick.as_secs_f64(), range: "[0.001, 1]" });
            }
        }
        let most = if self.multicast.is_some() { NETWORK_VEHICLES_MAX } else { usize::MAX };
        let most = most.min(self.layout.vehicles_max());
        if vehicles > most {
            return Err(HostError::Layout { vehicles, most });
        }
        if self.layout != PortLayout::Columba {
            return Ok(());
        }
        let count = vehicles.checked_sub(1).map_or(0, |last| port_index(last, self.vehicles_per_port) + 1);
        let beyond = self.base_port != 0 && usize::from(self.base_port) + count > 65_536;
        if beyond { Err(HostError::TooManyPorts { base_port: self.base_port, count }) } else { Ok(()) }
    }

    fn port_of(&self, vehicle: usize) -> usize {
        self.layout.group(vehicle, self.vehicles_per_port)
    }

    /// Where a vehicle sends telemetry unasked by the rules of the layout.
    fn set_grounds(&self, vehicle: usize, settings: &mut VehicleSettings) {
        // Who is to send nothing unasked does not.
        let grounds = self.layout.grounds(self.bind, vehicle).filter(|_| settings.ground.is_some());
        if let Some(mut grounds) = grounds.map(Vec::into_iter) {
            settings.ground = grounds.next();
            settings.further_grounds = grounds.collect();
        }
        settings.link_uses = self.layout.link_uses(self.bind, vehicle);
        settings.other_link_use = self.layout.other_link_use();
        if self.multicast.is_some() {
            settings.further_grounds.push(SocketAddr::V4(MULTICAST_GROUP));
        }
    }

    /// Ports with one seed would lose the same datagrams: an odd multiplier spreads them over all seeds.
    fn link_settings(&self, port_index: usize) -> LinkSettings {
        const GOLDEN: u64 = 0x9E37_79B9_7F4A_7C15;
        LinkSettings { seed: self.link.seed.wrapping_add(GOLDEN.wrapping_mul(port_index as u64)), ..self.link }
    }
}
