//! Flying a plan: in memory, in parallel, from where its journal ends.

use super::journal::{Flown, Journal};
use super::plan::{Plan, Planned};
use crate::config::Scenario;
use crate::flight::{Flight, Summary};
use crate::flying::{self, Progress, Stop};
use anyhow::{Context, anyhow};
use std::collections::HashSet;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::{Mutex, PoisonError};

/// How far a plan is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Census {
    /// Flights that it asks for; those that are the same are one.
    pub asked: usize,
    /// Those of them that are flown.
    pub flown: usize,
    /// Flights in the journal that it does not ask for.
    pub others: usize,
}

/// Counts what is flown of a plan.
pub fn census(plan: &Plan, flown: &Flown) -> Census {
    let keys: HashSet<String> = plan.flights().map(|planned| planned.key).collect();
    let there = keys.iter().filter(|key| flown.contains_key(*key)).count();
    Census { asked: keys.len(), flown: there, others: flown.len() - there }
}

/// Flies what is not flown yet and adds it to the journal and to `flown`. When it returns without an error, all is
/// flown or `stop` is true.
pub fn fly(plan: &Plan, journal: Journal, flown: &mut Flown, crew: &Crew) -> anyhow::Result<()> {
    let mut seen = HashSet::new();
    let left: Vec<Planned> = plan
        .flights()
        .filter(|planned| !flown.contains_key(&planned.key) && seen.insert(planned.key.clone()))
        .collect();
    let bar = flying::progress_over(left.len(), "flights", crew.quiet);
    let kept = Mutex::new((journal, flown));
    crew.work(left.len(), |index| {
        let planned = &left[index];
        let scenario = plan.scenario(planned.scenario, planned.contender, planned.seed)?;
        let Some(Flight { summary, .. }) = fly_once(&scenario, &crew.stop).with_context(|| {
            format!("{}, {}, seed {}", scenario.name, plan.contenders[planned.contender], planned.seed)
        })?
        else {
            return Ok(());
        };
        let mut kept = kept.lock().unwrap_or_else(PoisonError::into_inner);
        let (journal, flown) = &mut *kept;
        let summary: Summary = journal.add(&planned.key, &summary)?;
        flown.insert(planned.key.clone(), summary);
        bar.inc(1);
        Ok(())
    })?;
    bar.finish_and_clear();
    Ok(())
}

/// One flight for its figures; none where `stop` ended it.
pub fn fly_once(scenario: &Scenario, stop: &Stop) -> anyhow::Result<Option<Flight>> {
    let silent = Progress::new(scenario.ticks(), scenario.control_period, true);
    let flight = flying::fly_in_memory(scenario, &silent, stop)?;
    let Summary { completed, interrupted, failure, .. } = &flight.summary;
    match failure {
        // A collision is a result; a flight that could not go on is none.
        Some(failure) if !completed && !interrupted => Err(anyhow!("{failure}")),
        _ => Ok((!interrupted).then_some(flight)),
    }
}

/// Who does the work.
pub struct Crew {
    /// So many threads.
    pub threads: usize,
    /// Without a progress bar.
    pub quiet: bool,
    /// Holds true once someone asks them to end.
    pub stop: Stop,
}

impl Crew {
    /// Calls `task` with every number below `count`, each once, until one fails or someone asks to stop.
    pub fn work(&self, count: usize, task: impl Fn(usize) -> anyhow::Result<()> + Sync) -> anyhow::Result<()> {
        let (next, failed) = (AtomicUsize::new(0), AtomicBool::new(false));
        let task_after_task = || -> anyhow::Result<()> {
            while !failed.load(Ordering::Relaxed) && !*self.stop.borrow() {
                let index = next.fetch_add(1, Ordering::Relaxed);
                if index >= count {
                    break;
                }
                task(index).inspect_err(|_| failed.store(true, Ordering::Relaxed))?;
            }
            Ok(())
        };
        let task_after_task = &task_after_task;
        std::thread::scope(|scope| {
            let mut workers = Vec::new();
            for _ in 0..self.threads.min(count) {
                // A flock is solved in parallel, too. In a pool of one thread that stays on this one, so that no flight
                // waits for another and nothing but its own work is in its times.
                let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build()?;
                workers.push(scope.spawn(move || pool.install(task_after_task)));
            }
            workers.into_iter().try_for_each(|worker| worker.join().map_err(|_| anyhow!("a flight's thread failed"))?)
        })
    }
}

#[cfg(test)]
mod tests {
    use super::super::plan::tests::plan;
    use super::*;
    use std::collections::HashMap;
    use tokio::sync::watch;

    fn crew(threads: usize, stopped: bool) -> Crew {
        Crew { threads, quiet: true, stop: watch::channel(stopped).1 }
    }

    #[test]
    fn every_task_is_done_once_by_any_number_of_threads() {
        for threads in [1, 2, 7] {
            let done: Vec<AtomicUsize> = (0..50).map(|_| AtomicUsize::new(0)).collect();
            let count = |index: usize| {
                done[index].fetch_add(1, Ordering::Relaxed);
                Ok(())
            };
            crew(threads, false).work(50, count).unwrap();
            assert!(done.iter().all(|times| times.load(Ordering::Relaxed) == 1));
        }
    }

    #[test]
    fn a_failure_ends_the_work_and_is_told_and_so_does_a_wish_to_stop() {
        let done = AtomicUsize::new(0);
        let fail = |index| {
            done.fetch_add(1, Ordering::Relaxed);
            if index == 3 { Err(anyhow!("the third")) } else { Ok(()) }
        };
        assert_eq!(crew(1, false).work(50, fail).unwrap_err().to_string(), "the third");
        assert_eq!(done.load(Ordering::Relaxed), 4);
        crew(2, true).work(50, |_| Err(anyhow!("nothing should be done"))).unwrap();
    }

    #[test]
    fn flights_are_flown_once_and_gone_on_with() {
        let short = &["scenario.duration_s=1"];
        let folder = tempfile::tempdir().unwrap();
        let fly_all = |seeds: &[u64], threads: usize| {
            let plan = plan(&["one", "two"], short, seeds).unwrap();
            let (journal, mut flown) = Journal::open(folder.path()).unwrap();
            let before = census(&plan, &flown);
            fly(&plan, journal, &mut flown, &crew(threads, false)).unwrap();
            (before, flown)
        };
        let (before, first) = fly_all(&[1, 2], 1);
        assert_eq!(before, Census { asked: 4, flown: 0, others: 0 });
        assert_eq!(first.len(), 4);
        let (before, second) = fly_all(&[2, 3], 2);
        assert_eq!(before, Census { asked: 4, flown: 2, others: 2 });
        assert_eq!(second.len(), 6);
        // What was flown is as it was, wall times and all: nothing was flown again.
        assert!(first.iter().all(|(key, summary)| second[key] == *summary));

        let nothing = HashMap::new();
        let stopped = plan(&["one"], short, &[9]).unwrap();
        let (journal, mut flown) = Journal::open(folder.path()).unwrap();
        fly(&stopped, journal, &mut flown, &crew(1, true)).unwrap();
        assert_eq!(census(&stopped, &flown).flown, census(&stopped, &nothing).flown);
    }
}
