//! What a comparison flies: every scenario by every contender with every seed, each flight with its key.

use crate::config::{ConfigError, Contender, Entry, Layer, Scenario};
use optimizer::OptimizerSettings;
use siphasher::sip128::{Hasher128, SipHasher13};
use std::hash::Hasher;
use std::path::PathBuf;

/// The flights of a comparison, in the order scenario, contender, seed.
pub struct Plan {
    /// The contenders' names; the first is the one that the others are compared with.
    pub contenders: Vec<String>,
    /// The scenarios' names.
    pub scenarios: Vec<String>,
    /// The seeds.
    pub seeds: Vec<u64>,
    /// By scenario, then contender.
    entries: Vec<Entry>,
    /// What decides the flights of each entry, but for the seed.
    identities: Vec<String>,
}

/// A flight of a plan.
#[derive(Clone, Debug)]
pub struct Planned {
    /// Which scenario.
    pub scenario: usize,
    /// Which contender.
    pub contender: usize,
    /// Which seed it flies with.
    pub seed: u64,
    /// A hash of everything that decides the flight: flights of one key are the same flight.
    pub key: String,
}

/// Why there is nothing to compare.
#[derive(Debug, thiserror::Error)]
pub enum PlanError {
    /// A scenario is wrong, or a contender of it.
    #[error(transparent)]
    Config(#[from] ConfigError),
    /// Two scenarios cannot be told apart.
    #[error("two scenarios are named {0:?}: each must have a name of its own ([scenario] name)")]
    SameScenario(String),
    /// Two contenders cannot be told apart.
    #[error("two contenders are named {0:?}: each must have a name of its own")]
    SameContender(String),
    /// A setting cannot be written.
    #[error("cannot encode a scenario: {0}")]
    Encode(#[from] serde_json::Error),
}

impl Plan {
    /// Of these scenario files, or of the paper's flight where there are none, with changes for all contenders.
    ///
    /// # Errors
    /// A file or a contender is wrong, or a name is there twice.
    pub fn new(
        files: &[PathBuf],
        changes: &[Layer],
        contenders: &[Contender],
        seeds: &[u64],
    ) -> Result<Self, PlanError> {
        let files = if files.is_empty() { vec![None] } else { files.iter().map(|path| Some(path.as_path())).collect() };
        let mut entries = Vec::new();
        for file in files {
            entries.extend(Entry::of_all(file, changes, contenders)?);
        }
        let names = |of: &[Entry]| of.iter().map(|entry| entry.name().to_owned()).collect::<Vec<_>>();
        let scenarios: Vec<String> = names(&entries).into_iter().step_by(contenders.len().max(1)).collect();
        let contenders: Vec<String> = contenders.iter().map(|contender| contender.name.clone()).collect();
        if let Some(name) = repeated(&scenarios) {
            return Err(PlanError::SameScenario(name));
        }
        if let Some(name) = repeated(&contenders) {
            return Err(PlanError::SameContender(name));
        }
        let program = program();
        let identities = entries
            .iter()
            .map(|entry| Ok(format!("{program}\n{}", entry.identity()?)))
            .collect::<Result<_, serde_json::Error>>()?;
        let plan = Self { contenders, scenarios, seeds: seeds.to_vec(), entries, identities };
        // Whatever will not fly is told before the first flight, not after an hour.
        for planned in plan.flights() {
            plan.scenario(planned.scenario, planned.contender, planned.seed)?;
        }
        Ok(plan)
    }

    /// Every flight, in order.
    pub fn flights(&self) -> impl Iterator<Item = Planned> {
        let seeds = self.seeds.len().max(1);
        (0..self.entries.len() * self.seeds.len()).map(move |index| {
            let (entry, seed) = (index / seeds, self.seeds[index % seeds]);
            let (scenario, contender) = (entry / self.contenders.len(), entry % self.contenders.len());
            Planned { scenario, contender, seed, key: key(&self.identities[entry], seed) }
        })
    }

    /// Who picks the weights.
    pub fn optimizer(&self, scenario: usize, contender: usize) -> &OptimizerSettings {
        self.entries[scenario * self.contenders.len() + contender].optimizer()
    }

    /// What flies.
    ///
    /// # Errors
    /// With this seed, a vehicle of a random pattern starts where it must not.
    pub fn scenario(&self, scenario: usize, contender: usize, seed: u64) -> Result<Scenario, ConfigError> {
        self.entries[scenario * self.contenders.len() + contender].scenario(seed)
    }
}

fn repeated(names: &[String]) -> Option<String> {
    let twice = |&(index, name): &(usize, &String)| names[..index].contains(name);
    names.iter().enumerate().find(twice).map(|(_, name)| name.clone())
}

fn key(identity: &str, seed: u64) -> String {
    let mut hasher = SipHasher13::new();
    hasher.write(identity.as_bytes());
    hasher.write(&seed.to_le_bytes());
    format!("{:032x}", hasher.finish128().as_u128())
}

/// The program that flies: its version, and a hash of its bytes where they can be read, so that whoever changes an
/// optimiser and builds anew does not get the flights of the old one.
fn program() -> String {
    let bytes = std::env::current_exe().and_then(std::fs::read).unwrap_or_default();
    format!("{} {:032x}", env!("CARGO_PKG_VERSION"), SipHasher13::new().hash(&bytes).as_u128())
}
