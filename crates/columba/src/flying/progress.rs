//! How far a flight is, or many of something, for those who watch: on the terminal, and on the page of `--view`.

use super::Recorder;
use crate::view::FlockView;
use controller::{Decision, Flock};
use flight_model::State;
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use std::io::IsTerminal;
use std::time::Duration;

/// A bar over the ticks of a flight; nothing where nobody watches.
pub struct Progress {
    bar: ProgressBar,
    period: Duration,
    view: Option<FlockView>,
}

impl Progress {
    /// A bar for a flight of `ticks`, drawn only on a terminal and only unless `quiet`.
    pub fn new(ticks: u64, period: Duration, quiet: bool) -> Self {
        Self { bar: bar(ticks, "{msg} {percent:>3} %", quiet), period, view: None }
    }

    /// The same, shown on a page too.
    pub fn with_view(mut self, view: Option<FlockView>) -> Self {
        self.view = view;
        self
    }

    /// A tick: what the controller saw and decided.
    pub fn decided(&self, now: Duration, states: &[State], decisions: &[Decision], recorder: &Recorder) {
        if let Some(view) = &self.view {
            view.tick(now, states, decisions, || recorder.verdict());
        }
    }

    /// Before a tick: of whom it is to tell what there was to choose from.
    pub fn watch(&self, flock: &mut Flock, vehicles: usize) {
        if let Some(view) = &self.view {
            flock.watch(&view.watched(vehicles));
        }
    }

    /// After a tick: what there was to choose from.
    pub fn chosen(&self, now: Duration, flock: &Flock) {
        if let Some(view) = &self.view {
            view.chosen(now, flock);
        }
    }

    /// So many ticks are flown.
    pub fn flown(&self, ticks: u64) {
        if !self.bar.is_hidden() {
            self.bar.set_message(format!("{:.1} s flown", self.period.as_secs_f64() * ticks as f64));
        }
        self.bar.set_position(ticks);
    }
}

/// A bar over many of something, `what` as people call them, drawn as a [`Progress`] is.
pub fn progress_over(count: usize, what: &str, quiet: bool) -> ProgressBar {
    bar(count as u64, &format!("{{pos}} of {{len}} {what}, {{eta}} left"), quiet)
}

fn bar(length: u64, beside: &str, quiet: bool) -> ProgressBar {
    let bar = ProgressBar::new(length);
    if quiet || !std::io::stderr().is_terminal() {
        bar.set_draw_target(ProgressDrawTarget::hidden());
    }
    if let Ok(style) = ProgressStyle::with_template(&format!("  {{bar:32}} {beside}")) {
        bar.set_style(style);
    }
    bar
}

impl Drop for Progress {
    fn drop(&mut self) {
        self.bar.finish_and_clear();
    }
}
