//! What a comparison flies: every scenario by every contender with every seed, each flight with its key.

use crate::config::{ConfigError, Contender, Entry, Layer, Scenario};
use optimizer::OptimizerSettings;
use siphasher::sip128::SipHasher13;
use std::path::PathBuf;

/// The flights of a comparison, in the order scenario, contender, seed.
pub struct Plan {
    /// The contenders' names; the first is the one that the others are compared with.
    pub contenders: Vec<String>,
    /// The scenarios' names.
    pub scenarios: Vec<String>,
    /// The seeds.
    pub seeds: Vec<u64>,
    /// What was laid over the scenarios as TOML, and who laid it: for all contenders, if anything, then each.
    pub laid: Vec<(String, String)>,
    /// By scenario, then contender.
    entries: Vec<Entry>,
    /// A hash of all that decides the flights of each entry, but for the seed.
    identities: Vec<u128>,
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

/// Who lays what the command line changes.
const ALL: &str = "all contenders";

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
        let for_all: Vec<String> = changes.iter().map(Layer::toml).collect();
        let for_all = (!for_all.is_empty()).then(|| (ALL.to_owned(), for_all.join("\n")));
        let by_each = contenders.iter().map(|contender| (contender.name.clone(), contender.toml()));
        let laid = for_all.into_iter().chain(by_each).collect();
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
            .map(|entry| Ok(hash(format!("{program}\n{}", entry.identity()?).as_bytes())))
            .collect::<Result<_, serde_json::Error>>()?;
        let plan = Self { contenders, scenarios, seeds: seeds.to_vec(), laid, entries, identities };
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
            Planned { scenario, contender, seed, key: key(self.identities[entry], seed) }
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

fn key(identity: u128, seed: u64) -> String {
    let bytes = [&identity.to_le_bytes()[..], &seed.to_le_bytes()].concat();
    format!("{:032x}", hash(&bytes))
}

/// The same on every platform and with every version of the compiler, as a journal needs it.
fn hash(bytes: &[u8]) -> u128 {
    SipHasher13::new().hash(bytes).as_u128()
}

/// The program that flies: its version, and a hash of its bytes where they can be read, so that whoever changes an
/// optimiser and builds anew does not get the flights of the old one.
fn program() -> String {
    let bytes = std::env::current_exe().and_then(std::fs::read).unwrap_or_default();
    format!("{} {:032x}", env!("CARGO_PKG_VERSION"), hash(&bytes))
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use optimizer::Algorithm;
    use std::path::Path;

    /// The paper's flight by these optimisers, changed as `--set` changes it.
    pub fn plan(names: &[&str], settings: &[&str], seeds: &[u64]) -> Result<Plan, PlanError> {
        let settings: Vec<Layer> = settings.iter().map(|text| crate::config::flags::setting(text).unwrap()).collect();
        let algorithms = [Algorithm::Mslpio, Algorithm::Mpio, Algorithm::Nsga2];
        let contenders = names.iter().zip(algorithms);
        let contenders: Vec<Contender> =
            contenders.map(|(name, algorithm)| Contender::with_optimizer(algorithm, name).unwrap()).collect();
        Plan::new(&[], &settings, &contenders, seeds)
    }

    fn keys(names: &[&str], settings: &[&str], seeds: &[u64]) -> Vec<String> {
        plan(names, settings, seeds).unwrap().flights().map(|planned| planned.key).collect()
    }

    #[test]
    fn flights_are_in_the_order_scenario_contender_seed() {
        let plan = plan(&["one", "two"], &[], &[7, 3]).unwrap();
        let flights: Vec<_> = plan.flights().map(|flight| (flight.scenario, flight.contender, flight.seed)).collect();
        assert_eq!(flights, [(0, 0, 7), (0, 0, 3), (0, 1, 7), (0, 1, 3)]);
        assert_eq!(
            (plan.scenarios.as_slice(), plan.contenders.as_slice()),
            (&["paper".to_owned()][..], &["one".to_owned(), "two".to_owned()][..])
        );
        let scenario = plan.scenario(0, 1, 3).unwrap();
        assert_eq!((scenario.seed, scenario.optimizer.algorithm), (3, Algorithm::Mpio));
        assert_eq!(plan.optimizer(0, 1).algorithm, Algorithm::Mpio);
    }

    #[test]
    fn a_key_is_of_all_that_decides_a_flight_and_of_nothing_else() {
        let base = keys(&["one"], &[], &[1]);
        assert_eq!(base, keys(&["another name"], &[], &[1]));
        assert_eq!(
            base,
            keys(&["one"], &["link.loss=0.5", "output.folder=elsewhere"], &[1]),
            "in memory nothing is lost"
        );
        assert_eq!(base, keys(&["one"], &["look_ahead.horizon_s=3"], &[1]), "what it is by default");
        for (settings, seed) in [
            (&["look_ahead.horizon_s=3.5"][..], 1),
            (&["law.formation_gain=0.21"], 1),
            (&["optimizer.mslpio.iterations=11"], 1),
            (&["flock.expected_speed_mps=10.5"], 1),
            (&["scenario.control_period_s=0.25"], 1),
            (&["preset=paper"], 1),
            (&[], 2),
        ] {
            assert_ne!(base, keys(&["one"], settings, &[seed]), "{settings:?} {seed}");
        }
        let all = keys(&["one", "two", "three"], &[], &[1, 2, 3]);
        assert!(all.iter().enumerate().all(|(index, key)| !all[..index].contains(key)));
    }

    #[test]
    fn two_of_one_name_cannot_be_told_apart() {
        assert!(matches!(plan(&["one", "one"], &[], &[1]), Err(PlanError::SameContender(_))));
        let twice = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../config/paper.toml");
        let contender = Contender::with_optimizer(Algorithm::Mpio, "one").unwrap();
        let refused = Plan::new(&[twice.clone(), twice], &[], &[contender], &[1]);
        assert!(matches!(refused, Err(PlanError::SameScenario(name)) if name == "paper"));
    }
}
