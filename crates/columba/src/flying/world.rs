//! The tick loop, written once: a flock sees, decides and commands, in whatever world it flies.
//!
//! A [`World`] holds the vehicles and the clock: in memory, over a link in simulated time, or over a link in real time.

use super::{FlightError, Log, Progress, Recorder, Stop, Watch, stopped};
use crate::config::Scenario;
use crate::flight::Flight;
use controller::{Decision, Flock};
use flight_model::State;
use std::time::{Duration, Instant};

/// Vehicles that can be seen and commanded, and their clock.
///
/// [`fly`] calls `prepare` once; then, for each control period, `send` and `advance`; then `close`. It drops the future
/// of `prepare`, `send` or `advance` when the flight is interrupted, and calls only `states`, `now` and `close` after
/// that.
pub trait World {
    /// The name of this kind of world in `summary.json`.
    fn transport(&self) -> &'static str;

    /// Waits until every vehicle can be seen and follows setpoints. Time zero of the flight is when this returns.
    ///
    /// # Errors
    /// A vehicle is missing or cannot be commanded.
    fn prepare(&mut self) -> impl Future<Output = Result<(), FlightError>>;

    /// Flight time of [`states`](Self::states).
    fn now(&self) -> Duration;

    /// The states of all vehicles as the controller knows them; the planned starts before the first are known.
    fn states(&self) -> &[State];

    /// What the ground knows of vehicles that do not act at once, because they are behind a link, or slow to answer;
    /// none: [`states`](Self::states) are where its commands act.
    fn watch(&self) -> Option<&Watch> {
        None
    }

    /// Whether vehicles are told speeds over ground, and not through the air.
    fn tells_ground_speeds(&self) -> bool;

    /// The states at time zero by which the flight is judged: those that the controller knows, unless better ones
    /// exist.
    fn starts(&self) -> Vec<State> {
        self.states().to_vec()
    }

    /// Sends each vehicle its setpoint.
    ///
    /// # Errors
    /// A vehicle or its link cannot take the setpoint.
    fn send(&mut self, decisions: &[Decision]) -> impl Future<Output = Result<(), FlightError>>;

    /// Lets the vehicles fly until a flight time; [`now`](Self::now) and [`states`](Self::states) are those of then.
    ///
    /// # Errors
    /// A vehicle or its link is lost.
    fn advance(&mut self, until: Duration) -> impl Future<Output = Result<(), FlightError>>;

    /// How the vehicles flew since this was last asked, or since time zero.
    fn ground_truth(&mut self) -> Interval<'_>;

    /// Ends the flight.
    fn close(self) -> Closed;
}

/// What is left of a world when the flight is over.
#[derive(Default)]
pub struct Closed {
    /// The counters of the link as JSON; `null` without a link.
    pub counters: serde_json::Value,
    /// What the controller knew of the present as JSON; `null` where it knew everything.
    pub present: serde_json::Value,
    /// The log of the link, if any.
    pub log: Option<Log>,
}

/// A stretch of the flights of all vehicles, side by side.
#[derive(Clone, Copy, Debug)]
pub struct Interval<'a> {
    /// Flight time at which the interval begins.
    pub start: Duration,
    /// Time between two states.
    pub step: Duration,
    /// The states of each vehicle after each step; all tracks are equally long.
    pub tracks: &'a [Vec<State>],
}

/// Flies a scenario from beginning to end, or until `stop`. A flight that fails is recorded as far as it went.
///
/// # Errors
/// The settings of the optimiser are out of their range, or the counters cannot be written as JSON.
pub async fn fly<W: World>(
    scenario: &Scenario,
    mut world: W,
    progress: &Progress,
    mut stop: Stop,
) -> anyhow::Result<(Flight, Option<Log>)> {
    let over_ground = world.tells_ground_speeds();
    let settings = if over_ground { scenario.flock_settings_over_ground() } else { scenario.flock_settings() };
    let delay_s = 1e-3 * scenario.link.impairment.delay_ms;
    let settings = if world.watch().is_some() { settings.behind_a_link(delay_s) } else { settings };
    let dynamics = settings.dynamics.clone();
    let mut flock = Flock::new(settings, scenario.starts.len())?;
    let prepared = unless_stopped(&mut stop, world.prepare()).await;
    tracing::debug!(
        transport = world.transport(),
        vehicles = world.states().len(),
        ready = prepared.is_ok(),
        "prepared"
    );
    let mut recorder = Recorder::new(scenario, &world.starts());
    let started = Instant::now();
    let clock = move || started.elapsed();
    let flown = async {
        prepared?;
        for tick in 0..scenario.ticks() {
            let states = match world.watch() {
                Some(watch) => {
                    flock.set_margins(watch.margins_m());
                    flock.set_reference_speeds(watch.reference_speeds_mps());
                    flock.set_winds(watch.winds());
                    watch.foreseen()
                }
                None => world.states(),
            };
            progress.watch(&mut flock, scenario.starts.len());
            let decisions = flock.tick(tick, states, &clock);
            recorder.tick(world.now(), world.states(), decisions);
            unless_stopped(&mut stop, world.send(decisions)).await?;
            progress.decided(world.now(), world.states(), decisions, &recorder);
            progress.chosen(world.now(), &flock);
            let until = scenario.control_period * u32::try_from(tick + 1).unwrap_or(u32::MAX);
            unless_stopped(&mut stop, world.advance(until)).await?;
            let minima = recorder.judge(world.ground_truth());
            tracing::debug!(
                tick,
                t_s = world.now().as_secs_f64(),
                separation_m = minima.separation_m,
                clearance_m = minima.clearance_m,
                "tick"
            );
            progress.flown(tick + 1);
        }
        Ok(())
    };
    let flown = flown.await;
    recorder.last(world.now(), world.states());
    let transport = world.transport();
    let mut closed = world.close();
    let log = closed.log.take();
    tracing::debug!(counters = %closed.counters, "closed");
    Ok((recorder.finish(scenario, transport, dynamics, flown.into(), closed), log))
}

/// The result of `work`, unless the flight is interrupted first.
async fn unless_stopped(
    stop: &mut Stop,
    work: impl Future<Output = Result<(), FlightError>>,
) -> Result<(), FlightError> {
    tokio::select! {
        biased;
        () = stopped(stop) => Err(FlightError::Interrupted),
        done = work => done,
    }
}
