//! The ground station on the page: what it sees and decides, and the operator's words to it.

use super::choices;
use super::craft::place;
use super::flock::shown_least;
use crate::config::Scenario;
use crate::station::Station;
use crate::station::operator::{VERBS, Verb};
use crate::station::phase::Phase;
use crate::station::phase::fly::Fly;
use crate::station::told::Weight;
use live_view::{Answer, Event, LiveView, Said, Scene, Steering, VehicleNow};
use std::sync::Arc;
use std::time::{Duration, Instant};
use tokio::sync::mpsc;

/// The picture is made anew so often, in wall time: twice for each look of the page.
const SHOW: Duration = Duration::from_millis(50);

/// Shows a ground station, and hears its operator.
pub struct StationView {
    view: LiveView,
    words: Option<mpsc::Receiver<Said>>,
    shown: Option<Instant>,
    events: usize,
    /// Decisions whose choices were told.
    told_ticks: u64,
}

impl StationView {
    /// A page for a station that flies a scenario.
    pub fn new(mut view: LiveView, scenario: &Scenario) -> Self {
        view.feed().scene(Scene {
            takes_words: true,
            verbs: VERBS.map(str::to_owned).to_vec(),
            distances_rest_on: "of telemetry, between whose positions the way is interpolated".to_owned(),
            ..super::scene_of(scenario, "columba fly")
        });
        let words = view.take_words();
        Self { view, words, shown: None, events: 0, told_ticks: 0 }
    }

    /// What is said on the page next. Cancel safe.
    pub async fn next_said(&mut self) -> Option<Said> {
        match &mut self.words {
            Some(words) => words.recv().await,
            None => std::future::pending().await,
        }
    }

    /// Hands a word to the station, and answers it.
    pub fn obey(station: &mut Station, said: Said) {
        let verb = said.text.parse::<Verb>();
        let refused = match &verb {
            Ok(verb) => station.refuses(*verb),
            Err(error) => Some(error.clone()),
        };
        let answer = match (verb, refused) {
            (Ok(verb), None) => {
                station.operate(verb, &format!("on the page, {}", said.from));
                let when = match station.phase() {
                    Phase::Fly(_) => "is being done",
                    _ if matches!(verb, Verb::Abort(_)) => "is being done",
                    _ => "taken: it is done when the flock flies",
                };
                Answer { is_done: true, text: when.to_owned() }
            }
            (_, refused) => Answer { is_done: false, text: refused.unwrap_or_default() },
        };
        // A page that is gone needs no answer.
        let _ = said.answer.send(answer);
    }

    /// Of which vehicles the next decision is to tell what there was to choose from.
    pub fn watched(&self, station: &Station) -> Vec<usize> {
        choices::watched(&self.view.feed(), station.vehicles().len())
    }

    /// What was refused on the page, in words, if anything was.
    pub fn refused(&self) -> Option<String> {
        let refused = self.view.refused();
        let all = [
            (refused.host, "with a forged host"),
            (refused.origin, "from other origins"),
            (refused.token, "without the token"),
        ];
        let words: Vec<String> =
            all.iter().filter(|(count, _)| *count > 0).map(|(count, how)| format!("{count} {how}")).collect();
        (!words.is_empty()).then(|| format!("the page refused requests: {}", words.join(", ")))
    }

    /// Shows the station as it is at a time on its clock, if that is due.
    pub fn show(&mut self, station: &Station, now: Duration, wall: Instant, speed: f64) {
        let feed = self.view.feed();
        let began_s = station.told.flight_began_s;
        for event in &station.told.events()[self.events..] {
            feed.tell(Event {
                at_s: event.flight_s.unwrap_or(event.at_s),
                vehicles: event.vehicle.into_iter().collect(),
                weight: match event.weight {
                    Weight::Note => live_view::Weight::Note,
                    Weight::Warning => live_view::Weight::Warning,
                    Weight::Fault => live_view::Weight::Fault,
                },
                text: event.text.clone(),
            });
        }
        self.events = station.told.events().len();
        if self.shown.is_some_and(|shown| wall.saturating_duration_since(shown) < SHOW) {
            return;
        }
        self.shown = Some(wall);
        let fly = match station.phase() {
            Phase::Fly(fly) => Some(&**fly),
            _ => None,
        };
        if let Some(fly) = fly.filter(|fly| fly.ticks() != self.told_ticks) {
            self.told_ticks = fly.ticks();
            let (at_s, insights) = fly.insights();
            insights.for_each(|(index, insight)| choices::tell(&feed, index, insight, at_s));
        }
        feed.update(|frame| {
            frame.time_s = now.as_secs_f64() - began_s.unwrap_or(0.0);
            frame.rate = speed;
            let is_paused = fly.is_some_and(Fly::is_paused);
            frame.phase = if is_paused { "paused".to_owned() } else { station.phase().name().to_owned() };
            frame.vehicles.resize(station.vehicles().len(), VehicleNow::default());
            for (index, (shown, vehicle)) in frame.vehicles.iter_mut().zip(station.vehicles()).enumerate() {
                let last = vehicle.track().last();
                if let Some(state) = station.state_now(index, now).or(last.map(|sample| sample.state)) {
                    place(shown, index, &state);
                }
                shown.number = crate::flight::vehicle_number(index);
                shown.system_id = vehicle.id();
                if shown.kind.is_empty() {
                    shown.kind = Arc::from(vehicle.driver().map_or("", |driver| driver.kind().name()));
                }
                shown.set_mode(&vehicle.mode_name());
                shown.is_armed = vehicle.heard().armed;
                shown.is_in_failsafe = vehicle.heard().critical;
                shown.follows = vehicle.follows();
                shown.is_on_ground = vehicle.on_ground();
                shown.is_out = !vehicle.custody().is_ours();
                let age_s = vehicle.age_s(now.as_secs_f64()).map(|age_s| Duration::from_secs_f64(age_s / speed));
                shown.heard = age_s.and_then(|age| wall.checked_sub(age));
                shown.steering = fly.and_then(|fly| fly.chosen(index)).map(|(setpoint, weights)| Steering {
                    weights: weights.map(|weight| weight as f32),
                    speed_mps: setpoint.speed_mps as f32,
                    course_rad: setpoint.course_rad as f32,
                    altitude_m: setpoint.altitude_m as f32,
                });
            }
            if let Some(fly) = fly {
                let verdict = fly.verdict();
                let zero_s = fly.began().as_secs_f64();
                let since = |least: live_view::Least| live_view::Least { at_s: least.at_s - zero_s, ..least };
                frame.least_separation =
                    verdict.separation.map(|least| since(shown_least(least, |pair| pair.to_vec())));
                frame.least_clearance = verdict.clearance.map(|least| since(shown_least(least, |one| vec![one])));
            }
        });
    }
}
