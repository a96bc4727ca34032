//! Optimisers on test problems whose true fronts are known: how near they come, over many seeds and on equal terms.

mod tables;

pub use tables::{fronts, indicators, markdown, reference_fronts, timings};

use optimizer::indicators::{hypervolume, igd_plus, rows};
use optimizer::suites::{Suite, TestProblem};
use optimizer::{Algorithm, OptimizerSettings, stream};
use rayon::prelude::*;
use std::time::Instant;

/// What is solved by whom, and how much each may spend.
#[derive(Clone, Debug, PartialEq)]
pub struct Plan {
    /// The problems.
    pub problems: Vec<Suite>,
    /// The optimisers. All but SL-PIO, which minimises one objective.
    pub optimizers: Vec<Algorithm>,
    /// Each problem is solved once by each optimiser with each seed.
    pub seeds: Vec<u64>,
    /// Candidates of a generation and the greatest size of a front; even, at least 6.
    pub population: usize,
    /// Generations, the first included; at least 1.
    pub generations: usize,
    /// Variables of every problem, at least 3; without, as many as is customary for each.
    pub dimensions: Option<usize>,
}

/// One solve.
#[derive(Clone, Debug, PartialEq)]
pub struct Solve {
    /// The problem.
    pub problem: Suite,
    /// Who solved it.
    pub optimizer: Algorithm,
    /// With which random numbers.
    pub seed: u64,
    /// The front's costs, a row for each member.
    pub front: Vec<Vec<f64>>,
    /// The volume that the front dominates below the problem's reference point.
    pub hypervolume: f64,
    /// IGD+ to the problem's reference front.
    pub igd_plus: f64,
    /// Wall time, in microseconds.
    pub solve_us: f64,
}

impl Plan {
    /// How many candidates each solve evaluates.
    pub fn evaluations(&self) -> usize {
        self.population * self.generations
    }

    /// How many solves there are.
    pub fn solves(&self) -> usize {
        self.problems.len() * self.optimizers.len() * self.seeds.len()
    }

    /// A problem as it is solved.
    fn problem(&self, suite: Suite) -> TestProblem {
        suite.customary(self.dimensions)
    }

    /// Solves everything on all threads; `solved` is told of each. The order of the solves is that of the plan.
    ///
    /// # Errors
    /// The plan asks for what there is not.
    pub fn run(&self, solved: impl Fn() + Sync) -> anyhow::Result<Vec<Solve>> {
        let mut pairs = Vec::with_capacity(self.solves());
        for &problem in &self.problems {
            for &optimizer in &self.optimizers {
                pairs.extend(self.seeds.iter().map(|&seed| (problem, optimizer, seed)));
            }
        }
        let solve = |&(problem, optimizer, seed): &(Suite, Algorithm, u64)| {
            let solve = self.solve(problem, optimizer, seed);
            solved();
            solve
        };
        pairs.par_iter().map(solve).collect()
    }

    fn solve(&self, suite: Suite, algorithm: Algorithm, seed: u64) -> anyhow::Result<Solve> {
        let mut problem = self.problem(suite);
        let mut optimizer = self.settings(algorithm).build()?;
        let start = Instant::now();
        let front = rows(&optimizer.minimise(&mut problem, &mut stream(seed, 0, 0))?);
        let solve_us = start.elapsed().as_secs_f64() * 1e6;
        Ok(Solve {
            problem: suite,
            optimizer: algorithm,
            seed,
            hypervolume: hypervolume(&front, &problem.reference_point())?,
            igd_plus: igd_plus(&front, &problem.reference_front())?,
            front,
            solve_us,
        })
    }

    /// Every optimiser's default settings, but for what makes them comparable: as many generations of as many
    /// candidates, and a front of at most one generation. So nobody leaves a flock of pigeons.
    fn settings(&self, algorithm: Algorithm) -> OptimizerSettings {
        OptimizerSettings { algorithm, ..OptimizerSettings::default() }.with_budget(self.population, self.generations)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn plan() -> Plan {
        Plan {
            problems: vec![Suite::Zdt3, Suite::Dtlz1],
            optimizers: vec![Algorithm::Nsga2, Algorithm::Mslpio, Algorithm::Mpio],
            seeds: vec![3, 1],
            population: 10,
            generations: 4,
            dimensions: Some(3),
        }
    }

    #[test]
    fn solves_come_in_the_order_of_the_plan_whatever_the_threads() {
        let plan = plan();
        let run = |threads| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            let mut solves = pool.install(|| plan.run(|| {})).unwrap();
            solves.iter_mut().for_each(|solve| solve.solve_us = 0.0);
            solves
        };
        let solves = run(1);
        assert_eq!(solves.len(), plan.solves());
        assert_eq!((solves[1].problem, solves[1].optimizer, solves[1].seed), (Suite::Zdt3, Algorithm::Nsga2, 1));
        assert_eq!((solves[6].problem, solves[6].optimizer, solves[6].seed), (Suite::Dtlz1, Algorithm::Nsga2, 3));
        assert_ne!(solves[0].front, solves[1].front);
        assert_eq!(solves, run(3));
    }
}
