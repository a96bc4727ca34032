//! Constrained dominance (Eq. 16 with Deb's rule for constraints) and the fast non-dominated sort.

use std::cmp::Ordering;

/// The costs of a set of candidates: a table of objectives, column after column, and one violation each.
#[derive(Clone, Copy, Debug)]
pub struct Costs<'a> {
    objectives: &'a [f64],
    violation: &'a [f64],
    count: usize,
}

impl<'a> Costs<'a> {
    /// As many candidates as `violation` is long; objective `k` of candidate `i` is `objectives[k * len + i]`.
    /// No value may be NaN and no violation negative: the sort would not fail, but its ranks would be meaningless.
    pub fn new(objectives: &'a [f64], violation: &'a [f64]) -> Self {
        Self { objectives, violation, count: objectives.len().checked_div(violation.len()).unwrap_or(0) }
    }

    /// The number of candidates.
    pub fn len(&self) -> usize {
        self.violation.len()
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.violation.is_empty()
    }

    /// The number of objectives.
    pub fn objectives(&self) -> usize {
        self.count
    }

    /// Objective `objective` of every candidate. Panics if there is no such objective, as an index does.
    pub fn objective(&self, objective: usize) -> &'a [f64] {
        &self.objectives[objective * self.len()..][..self.len()]
    }

    /// The total constraint violation of every candidate; 0 is feasible.
    pub fn violation(&self) -> &'a [f64] {
        self.violation
    }

    /// One candidate's objective.
    pub(crate) fn cost(&self, candidate: usize, objective: usize) -> f64 {
        self.objectives[objective * self.violation.len() + candidate]
    }

    /// Whether `a` dominates `b`: its violation is less, or it is equal and `a` is at least as good in every objective
    /// and better in one (Eq. 16). A strict partial order.
    pub fn dominates(&self, a: usize, b: usize) -> bool {
        if self.violation[a] != self.violation[b] {
            return self.violation[a] < self.violation[b];
        }
        let mut better = false;
        for k in 0..self.count {
            let (cost_a, cost_b) = (self.cost(a, k), self.cost(b, k));
            if cost_a > cost_b {
                return false;
            }
            better |= cost_a < cost_b;
        }
        better
    }

    /// Whether two candidates have the same violation and the same costs.
    pub(crate) fn equal(&self, a: usize, b: usize) -> bool {
        (0..self.count).all(|k| self.cost(a, k) == self.cost(b, k)) && self.violation[a] == self.violation[b]
    }

    /// By violation, then objective by objective: a candidate comes before the candidates that it dominates.
    fn lexicographic(&self, a: usize, b: usize) -> Ordering {
        let objectives = (0..self.count).map(|k| compare(self.cost(a, k), self.cost(b, k)));
        let violation = compare(self.violation[a], self.violation[b]);
        std::iter::once(violation).chain(objectives).find(|order| order.is_ne()).unwrap_or(Ordering::Equal)
    }
}

/// A total order of floats in which 0 and -0 are equal.
pub(crate) fn compare(a: f64, b: f64) -> Ordering {
    (a + 0.0).total_cmp(&(b + 0.0))
}

/// Bits that are ordered as the floats are, with 0 and -0 equal.
pub(crate) fn ordered_bits(value: f64) -> u64 {
    let bits = (value + 0.0).to_bits();
    if bits >> 63 == 0 { bits | 1 << 63 } else { !bits }
}

/// How many of some ascending values are at most `limit`. For few values, counting all is faster than bisection: no
/// step depends on another.
fn count_below(ascending: &[f64], limit: f64) -> usize {
    if ascending.len() <= 32 {
        ascending.iter().map(|&value| u64::from(value <= limit)).sum::<u64>() as usize
    } else {
        ascending.partition_point(|&value| value <= limit)
    }
}

const NOBODY: u32 = u32::MAX;

/// The fast non-dominated sort: divides candidates into fronts, of which each dominates the next. Keeps its buffers.
///
/// Candidates are taken in lexicographic order (violation, then objective by objective, ties by lowest index), so that
/// no candidate is dominated by a later one. Each joins the first front of which no member dominates it, found by
/// bisection (the efficient sort of Zhang, Tian, Cheng and Jin, 2015). With one or two objectives it is enough to
/// compare with the front's last member: O(n log n). With more, every member is compared: O(n^2) at worst. Equal
/// candidates share a front.
#[derive(Clone, Debug, Default)]
pub struct NonDominatedSort {
    order: Entries,
    ranks: Vec<u32>,
    /// The last member of each front and its last objective; of each candidate, the one that joined its front before
    /// it.
    last: Vec<u32>,
    last_cost: Vec<f64>,
    previous: Vec<u32>,
    /// Candidates, front after front, and where each front ends.
    members: Vec<u32>,
    ends: Vec<u32>,
}

/// The candidates as keys that decide most comparisons without the costs: the highest bit is whether the candidate
/// violates, then its violation or else its first objective, and the last bits are the candidate's number. Keys sort as
/// numbers do; only runs of keys that differ only in the candidate's number need the costs.
#[derive(Clone, Debug, Default)]
struct Entries {
    keys: Vec<u64>,
    /// The bits that are a candidate's number.
    number: u64,
}

impl Entries {
    /// All candidates in lexicographic order, ties by lowest index.
    fn order(&mut self, costs: &Costs<'_>) {
        let first_objective = if costs.objectives() > 0 { costs.objective(0) } else { costs.violation };
        let number = (costs.len() as u64).next_power_of_two() - 1;
        self.number = number;
        self.keys.clear();
        self.keys.extend(first_objective.iter().zip(costs.violation).zip(0..).map(
            |((&first_objective, &violation), candidate)| {
                let key = if violation > 0.0 {
                    1 << 63 | ordered_bits(violation) >> 1
                } else {
                    ordered_bits(first_objective) >> 1
                };
                key & !number | candidate
            },
        ));
        self.keys.sort_unstable();
        for ties in self.keys.chunk_by_mut(|a, b| a & !number == b & !number).filter(|ties| ties.len() > 1) {
            ties.sort_unstable_by(|a, b| {
                costs.lexicographic((a & number) as usize, (b & number) as usize).then(a.cmp(b))
            });
        }
    }

    fn candidate(&self, key: u64) -> usize {
        (key & self.number) as usize
    }

    /// Whether two candidates can be told apart only by their costs.
    fn tied(&self, a: u64, b: u64) -> bool {
        (a ^ b) & !self.number == 0
    }
}

impl NonDominatedSort {
    /// Makes room for `candidates`, so that sorting up to so many allocates nothing.
    pub fn reserve(&mut self, candidates: usize) {
        self.order.keys.clear();
        self.order.keys.reserve(candidates);
        self.last_cost.clear();
        self.last_cost.reserve(candidates);
        for buffer in [&mut self.ranks, &mut self.last, &mut self.previous, &mut self.members, &mut self.ends] {
            buffer.clear();
            buffer.reserve(candidates);
        }
    }

    /// Sorts. Results stay readable until the next call.
    pub fn sort(&mut self, costs: &Costs<'_>) {
        self.order.order(costs);
        self.assign_ranks(costs);
        self.collect_fronts();
    }

    fn assign_ranks(&mut self, costs: &Costs<'_>) {
        self.ranks.clear();
        self.ranks.resize(costs.len(), 0);
        self.previous.clear();
        self.previous.resize(costs.len(), NOBODY);
        self.last.clear();
        self.last_cost.clear();
        let mut least_rank = 0;
        let mut before = None::<u64>;
        for &key in &self.order.keys {
            let candidate = self.order.candidate(key);
            let cost = costs.cost(candidate, costs.objectives().saturating_sub(1));
            let rank = match before.map(|before| (self.order.candidate(before), self.order.tied(before, key))) {
                Some((before, true)) if costs.equal(before, candidate) => self.ranks[before] as usize,
                before => {
                    if before.is_some_and(|(before, _)| costs.violation[before] < costs.violation[candidate]) {
                        least_rank = self.last.len();
                    }
                    if costs.objectives() <= 2 {
                        least_rank + count_below(&self.last_cost[least_rank..], cost)
                    } else {
                        let dominates = |&last: &u32| self.front_dominates(costs, last, candidate);
                        least_rank + self.last[least_rank..].partition_point(dominates)
                    }
                }
            };
            if rank < self.last.len() {
                self.previous[candidate] = self.last[rank];
                self.last[rank] = candidate as u32;
                self.last_cost[rank] = cost;
            } else {
                self.last.push(candidate as u32);
                self.last_cost.push(cost);
            }
            self.ranks[candidate] = rank as u32;
            before = Some(key);
        }
    }

    /// Whether the front that ends in `last` dominates a candidate that comes after it in the order.
    fn front_dominates(&self, costs: &Costs<'_>, last: u32, candidate: usize) -> bool {
        let mut member = last;
        while member != NOBODY {
            if costs.dominates(member as usize, candidate) {
                return true;
            }
            member = self.previous[member as usize];
        }
        false
    }

    /// A counting sort of the order by rank: within a front the lexicographic order stays.
    fn collect_fronts(&mut self) {
        self.ends.clear();
        self.ends.resize(self.last.len(), 0);
        for &rank in &self.ranks {
            self.ends[rank as usize] += 1;
        }
        let mut start = 0;
        for end in &mut self.ends {
            // Where the front starts, for now; filling it moves this to its end.
            start += std::mem::replace(end, start);
        }
        self.members.clear();
        self.members.resize(self.ranks.len(), 0);
        for &key in &self.order.keys {
            let candidate = self.order.candidate(key);
            let slot = &mut self.ends[self.ranks[candidate] as usize];
            self.members[*slot as usize] = candidate as u32;
            *slot += 1;
        }
    }

    /// The number of fronts.
    pub fn fronts(&self) -> usize {
        self.ends.len()
    }

    /// The members of front `rank` (0 is the Pareto front) in lexicographic order of their costs, ties by lowest index.
    /// Panics if there is no such front, as an index does.
    pub fn front(&self, rank: usize) -> &[u32] {
        let start = if rank == 0 { 0 } else { self.ends[rank - 1] };
        &self.members[start as usize..self.ends[rank] as usize]
    }

    /// All candidates in fronts before front `rank`, best first. Panics if there is no such front, as an index does.
    pub fn before(&self, rank: usize) -> &[u32] {
        let end = if rank == 0 { 0 } else { self.ends[rank - 1] };
        &self.members[..end as usize]
    }

    /// The rank of every candidate, counted from 0: one more than the worst rank among those that dominate it.
    pub fn ranks(&self) -> &[u32] {
        &self.ranks
    }
}
