//! One port and the vehicles behind it.

use crate::counters::VehicleCounters;
use crate::host::clock::{Advance, Clock, HostError, Observer, RealTime};
use crate::host::lines::{Arrival, Lines};
use crate::host::system_ids::SystemIds;
use crate::parameters::file;
use crate::protocol::mission::file as plan_file;
use crate::vehicle::Vehicle;
use flight_model::State;
use mavlink_bridge::{Counters, LinkError, incoming};
use std::collections::HashMap;
use std::net::SocketAddr;
use std::path::PathBuf;
use std::sync::Arc;
use std::time::Duration;
use tokio::sync::watch;
use tokio::time::Instant;

pub(crate) struct Endpoint {
    lines: Lines,
    vehicles: Vec<Vehicle>,
    /// Index of the first vehicle among all of the host's.
    first: usize,
    /// Where parameters that are set and plans are kept.
    pub state_folder: Option<PathBuf>,
    frames: Counters,
    track: Vec<State>,
}

pub(crate) struct EndpointReport {
    pub wire: Counters,
    pub vehicles: Vec<(usize, VehicleCounters)>,
}

/// What the vehicles do not have: a clock, and somebody who looks on.
pub(crate) struct Shell {
    pub started: Instant,
    pub clock: Clock,
    pub time: RealTime,
    pub observer: Observer,
    /// Whether the flight has begun; none where the flight begins at once.
    pub begins: Option<watch::Receiver<bool>>,
}

impl Shell {
    /// Whether vehicles stay at their starts. Nobody is left to let them go where the sender is gone.
    fn holds(&self) -> bool {
        self.begins.as_ref().is_some_and(|begins| !*begins.borrow() && begins.has_changed().is_ok())
    }
}

/// Waits until `stop` holds true or its sender is gone.
pub(crate) async fn stopped(stop: &mut watch::Receiver<bool>) {
    // A closed channel is as good as a true one: nobody is left to stop us later.
    let _ = stop.wait_for(|stop| *stop).await;
}

/// Most datagrams taken in a row before the vehicles are attended to again.
const DATAGRAMS_IN_A_ROW: usize = 64;

impl Endpoint {
    pub fn new(lines: Lines, mut vehicles: Vec<Vehicle>, first: usize) -> Result<Self, HostError> {
        let mut by_system = HashMap::new();
        for (index, vehicle) in vehicles.iter().enumerate() {
            let system_id = vehicle.settings().system_id;
            if let Some(other) = by_system.insert(system_id, index) {
                return Err(HostError::DuplicateSystemId { first: first + other, second: first + index, system_id });
            }
        }
        let ids = Arc::new(SystemIds::new(vehicles.iter().map(|vehicle| vehicle.settings().system_id).collect()));
        for (place, vehicle) in vehicles.iter_mut().enumerate() {
            vehicle.parameter_service().share_port(Arc::clone(&ids), place);
        }
        Ok(Self { lines, vehicles, first, state_folder: None, frames: Counters::default(), track: Vec::new() })
    }

    /// All ways in and out.
    pub fn lines(&self) -> &Lines {
        &self.lines
    }

    /// The vehicles behind this port.
    pub fn vehicles(&self) -> impl Iterator<Item = &Vehicle> {
        self.vehicles.iter()
    }

    pub async fn run(
        mut self,
        shell: Arc<Shell>,
        mut stop: watch::Receiver<bool>,
    ) -> Result<EndpointReport, LinkError> {
        let mut datagram = Vec::new();
        loop {
            self.transmit().await;
            let wake = shell.started + self.next_wake(&shell.clock, shell.started.elapsed());
            tokio::select! {
                () = stopped(&mut stop) => break,
                arrival = self.lines.recv(&mut datagram) => {
                    let mut arrival = Some(arrival?);
                    let mut taken = 0;
                    while let Some(next) = arrival {
                        self.take(&shell, next, &datagram);
                        taken += 1;
                        arrival = if taken < DATAGRAMS_IN_A_ROW { self.lines.try_recv(&mut datagram)? } else { None };
                    }
                }
                () = tokio::time::sleep_until(wake) => {}
            }
            (0..self.vehicles.len()).for_each(|index| self.fly(index, &shell));
        }
        let vehicles = self.vehicles.iter().enumerate().map(|(index, v)| (self.first + index, v.counters())).collect();
        let wire = self.lines.counters() + self.frames;
        self.lines.close().await;
        Ok(EndpointReport { wire, vehicles })
    }

    /// Host time at which somebody wants attention.
    fn next_wake(&self, clock: &Clock, now: Duration) -> Duration {
        match clock {
            // Whole multiples of the tick: a late wake does not shift the next.
            Clock::RealTime { tick, .. } => {
                let ticks = u32::try_from(now.as_nanos() / tick.as_nanos()).unwrap_or(u32::MAX);
                tick.saturating_mul(ticks.saturating_add(1))
            }
            Clock::Lockstep(_) => {
                let earliest = self.vehicles.iter().filter_map(Vehicle::poll_timeout).min();
                earliest.unwrap_or(now + Duration::from_secs(1)).max(now)
            }
        }
    }

    fn take(&mut self, shell: &Shell, arrival: Arrival, datagram: &[u8]) {
        match arrival {
            Arrival::Datagram(from) => self.receive(shell, datagram, from),
            Arrival::Pulses => {
                for index in 0..self.vehicles.len() {
                    self.fly(index, shell);
                    self.vehicles[index].receive(datagram);
                }
            }
            Arrival::Opened(peer) => {
                for index in 0..self.vehicles.len() {
                    self.fly(index, shell);
                    self.vehicles[index].connect(shell.started.elapsed(), peer);
                }
            }
            Arrival::Closed(peer) => self.vehicles.iter_mut().for_each(|vehicle| vehicle.disconnect(peer)),
        }
    }

    /// Hands each frame to the vehicles that it is for.
    fn receive(&mut self, shell: &Shell, datagram: &[u8], from: SocketAddr) {
        let mut counters = self.frames;
        for request in incoming(datagram, &mut counters) {
            let target = request.target.system_id;
            for index in 0..self.vehicles.len() {
                // A lone vehicle counts what is not for it. System ids may change in flight.
                let ours = target == 0 || target == self.vehicles[index].settings().system_id;
                if !ours && self.vehicles.len() > 1 {
                    continue;
                }
                self.fly(index, shell);
                self.vehicles[index].handle_incoming(shell.started.elapsed(), &request, from);
                self.fly(index, shell);
                self.keep_parameters(index);
                self.keep_plans(index);
            }
        }
        self.frames = counters;
    }

    /// A vehicle flies on when its parameters cannot be kept, as an autopilot with a broken card does.
    fn keep_parameters(&mut self, index: usize) {
        let vehicle = &mut self.vehicles[index];
        let Some(folder) = self.state_folder.as_ref().filter(|_| vehicle.take_parameters_changed()) else {
            return;
        };
        let path = file::path(folder, self.first + index);
        if let Err(error) = file::write(&path, vehicle.set_parameters()) {
            tracing::warn!(path = %path.display(), %error, "cannot keep parameters");
        }
    }

    /// The same for its plans.
    fn keep_plans(&mut self, index: usize) {
        let vehicle = &mut self.vehicles[index];
        let Some(folder) = &self.state_folder else { return };
        for kind in vehicle.take_changed_plans() {
            let path = plan_file::path(folder, self.first + index, kind);
            if let Err(error) = plan_file::write(&path, vehicle.plan(kind)) {
                tracing::warn!(path = %path.display(), %error, "cannot keep a plan");
            }
        }
    }

    /// Lets a vehicle fly as far as its clock has come.
    fn fly(&mut self, index: usize, shell: &Shell) {
        let vehicle = &mut self.vehicles[index];
        let now = shell.started.elapsed();
        vehicle.handle_timeout(now);
        let until = match shell.clock {
            Clock::RealTime { .. } => {
                match vehicle.take_speedup() {
                    Some(speedup) => shell.time.set_speed(now, speedup),
                    None => vehicle.note_speedup(shell.time.speed()),
                }
                shell.time.until(now, vehicle.time())
            }
            Clock::Lockstep(_) => match vehicle.released_until() {
                Some(until) => until,
                None => return,
            },
        };
        let start = vehicle.time();
        vehicle.hold(shell.holds());
        self.track.clear();
        vehicle.advance(until, &mut self.track);
        if !self.track.is_empty() {
            let step = vehicle.settings().step;
            let craft: &Vehicle = vehicle;
            (shell.observer)(Advance { vehicle: self.first + index, start, step, track: &self.track, craft });
        }
    }

    async fn transmit(&mut self) {
        for vehicle in &mut self.vehicles {
            while let Some(transmit) = vehicle.poll_transmit() {
                self.lines.send_to(&transmit.datagram, transmit.to).await;
            }
        }
    }
}
