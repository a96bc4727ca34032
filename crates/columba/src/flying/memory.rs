//! A world in memory: no sockets, simulated time, as fast as it goes.
//!
//! States and setpoints are rounded as the wire would round them, so that a flight has the same bits as in lockstep.

use super::{
    Closed, FlightError, Interval, LOCKSTEP_EPOCH_US, Progress, Stop, Watch, World, fly, led_vehicle_settings,
};
use crate::config::Scenario;
use crate::flight::Flight;
use controller::Decision;
use flight_model::State;
use mavlink_bridge::{wire_round, wire_round_setpoint};
use sim_vehicle::{SettingsError, Vehicle, VehicleSettings};
use std::pin::pin;
use std::task::{Context, Poll, Waker};
use std::time::Duration;

/// Flies a scenario in memory from beginning to end, or until `stop`.
///
/// # Errors
/// The optimiser or a vehicle refuses its settings.
pub fn fly_in_memory(scenario: &Scenario, progress: &Progress, stop: &Stop) -> anyhow::Result<Flight> {
    at_once(fly(scenario, Memory::new(scenario)?, progress, stop.clone())).map(|(flight, _)| flight)
}

/// The result of a flight that waits for nothing, so that no runtime is needed to wake it.
pub fn at_once<T>(flight: impl Future<Output = T>) -> T {
    let mut flight = pin!(flight);
    let mut context = Context::from_waker(Waker::noop());
    loop {
        if let Poll::Ready(flown) = flight.as_mut().poll(&mut context) {
            return flown;
        }
    }
}

/// The simulated vehicles of a scenario, called directly.
pub struct Memory {
    vehicles: Vec<Vehicle>,
    now: Duration,
    /// As the wire would tell them.
    states: Vec<State>,
    watch: Option<Watch>,
    interval_start: Duration,
    step: Duration,
    tracks: Vec<Vec<State>>,
}

impl Memory {
    /// The vehicles at their starts.
    ///
    /// # Errors
    /// A vehicle refuses its settings.
    pub fn new(scenario: &Scenario) -> Result<Self, SettingsError> {
        let vehicles = led_vehicle_settings(scenario, None, LOCKSTEP_EPOCH_US)
            .into_iter()
            .map(|settings| Vehicle::new(VehicleSettings { ground: None, ..settings }))
            .collect::<Result<Vec<_>, _>>()?;
        let states = vehicles.iter().map(|vehicle| wire_round(vehicle.state())).collect();
        let tracks = vec![Vec::new(); vehicles.len()];
        let step = scenario.integration_step;
        let watch = Watch::without_a_link(scenario);
        Ok(Self { vehicles, now: Duration::ZERO, states, watch, interval_start: Duration::ZERO, step, tracks })
    }

    fn look(&mut self) {
        if let Some(watch) = &mut self.watch {
            watch.hear_states(&self.states, self.now);
            watch.look(self.now);
        }
    }
}

impl World for Memory {
    fn transport(&self) -> &'static str {
        "memory"
    }

    async fn prepare(&mut self) -> Result<(), FlightError> {
        self.look();
        Ok(())
    }

    fn now(&self) -> Duration {
        self.now
    }

    fn states(&self) -> &[State] {
        &self.states
    }

    fn tells_ground_speeds(&self) -> bool {
        true
    }

    fn watch(&self) -> Option<&Watch> {
        self.watch.as_ref()
    }

    fn starts(&self) -> Vec<State> {
        self.vehicles.iter().map(|vehicle| *vehicle.state()).collect()
    }

    async fn send(&mut self, decisions: &[Decision]) -> Result<(), FlightError> {
        if let Some(watch) = &mut self.watch {
            watch.decided(self.now, self.now);
        }
        for (index, (vehicle, decision)) in self.vehicles.iter_mut().zip(decisions).enumerate() {
            let setpoint = match &mut self.watch {
                Some(watch) => watch.command(index, decision, self.now),
                None => decision.setpoint,
            };
            vehicle
                .command(&wire_round_setpoint(&setpoint))
                .map_err(|reason| FlightError::Setpoint { vehicle: index, reason: reason.to_string() })?;
        }
        Ok(())
    }

    async fn advance(&mut self, until: Duration) -> Result<(), FlightError> {
        (self.interval_start, self.now) = (self.now, until);
        for (vehicle, track) in self.vehicles.iter_mut().zip(&mut self.tracks) {
            track.clear();
            vehicle.advance(until, track);
        }
        self.states.clear();
        self.states.extend(self.vehicles.iter().map(|vehicle| wire_round(vehicle.state())));
        self.look();
        if let Some(watch) = &mut self.watch {
            watch.compare(self.interval_start, self.step, &self.tracks);
        }
        Ok(())
    }

    fn ground_truth(&mut self) -> Interval<'_> {
        Interval { start: self.interval_start, step: self.step, tracks: &self.tracks }
    }

    fn close(self) -> Closed {
        Closed { present: self.watch.as_ref().map(Watch::figures).unwrap_or_default(), ..Closed::default() }
    }
}
