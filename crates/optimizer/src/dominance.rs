//! Constrained dominance (Eq. 16 with Deb's rule for constraints) and the fast non-dominated sort that stands on it.

use std::cmp::Ordering;

/// What a set of candidates costs: a table of objectives, column after column, and one violation each.
#[derive(Clone, Copy, Debug)]
pub struct Costs<'a> {
    objectives: &'a [f64],
    violation: &'a [f64],
}

impl<'a> Costs<'a> {
    /// As many candidates as `violation` is long; objective `k` of candidate `i` is `objectives[k * len + i]`.
    /// No value may be NaN: it would have no place in any order (the sort stays safe, but its ranks mean nothing).
    pub fn new(objectives: &'a [f64], violation: &'a [f64]) -> Self {
        Self { objectives, violation }
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
        self.objectives.len().checked_div(self.len()).unwrap_or(0)
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

    /// Whether `a` dominates `b`: it violates less, or it violates as much and is at least as good in every objective and
    /// better in one (Eq. 16). A strict partial order.
    pub fn dominates(&self, a: usize, b: usize) -> bool {
        match compare(self.violation[a], self.violation[b]) {
            Ordering::Less => true,
            Ordering::Greater => false,
            Ordering::Equal => {
                let mut better = false;
                for k in 0..self.objectives() {
                    match compare(self.cost(a, k), self.cost(b, k)) {
                        Ordering::Less => better = true,
                        Ordering::Greater => return false,
                        Ordering::Equal => {}
                    }
                }
                better
            }
        }
    }

    /// By violation, then objective after objective: who dominates comes before whom it dominates.
    fn lexicographic(&self, a: usize, b: usize) -> Ordering {
        (0..self.objectives())
            .map(|k| compare(self.cost(a, k), self.cost(b, k)))
            .fold(compare(self.violation[a], self.violation[b]), Ordering::then)
    }
}

/// A total order of floats in which 0 and -0 are equal.
pub(crate) fn compare(a: f64, b: f64) -> Ordering {
    (a + 0.0).total_cmp(&(b + 0.0))
}

const NOBODY: u32 = u32::MAX;

/// The fast non-dominated sort: divides candidates into fronts, of which each dominates the next. Keeps its buffers.
///
/// Candidates are taken in lexicographic order (violation, then objective after objective, ties by lowest index), so that
/// nobody is dominated by who comes later, and each joins the first front of which no member dominates it, found by
/// bisection (the efficient sort of Zhang, Tian, Cheng and Jin, 2015). With one or two objectives it is enough to ask the
/// front's last member: O(n log n). With more, every member is asked: O(n^2) at worst. Equal candidates share a front.
#[derive(Clone, Debug, Default)]
pub struct NonDominatedSort {
    order: Vec<u32>,
    ranks: Vec<u32>,
    /// The last member of each front, and of each candidate the one that joined its front before it.
    last: Vec<u32>,
    previous: Vec<u32>,
    /// Candidates, front after front, and where each front ends.
    members: Vec<u32>,
    ends: Vec<u32>,
}

impl NonDominatedSort {
    /// Makes room for `candidates`, so that sorting up to so many allocates nothing.
    pub fn reserve(&mut self, candidates: usize) {
        for buffer in
            [&mut self.order, &mut self.ranks, &mut self.last, &mut self.previous, &mut self.members, &mut self.ends]
        {
            buffer.clear();
            buffer.reserve(candidates);
        }
    }

    /// Sorts. Results stay readable until the next call.
    pub fn sort(&mut self, costs: &Costs<'_>) {
        let candidates = costs.len() as u32;
        self.order.clear();
        self.order.extend(0..candidates);
        self.order.sort_unstable_by(|&a, &b| costs.lexicographic(a as usize, b as usize).then(a.cmp(&b)));
        self.assign_ranks(costs);
        self.collect_fronts();
    }

    fn assign_ranks(&mut self, costs: &Costs<'_>) {
        let candidates = costs.len();
        self.ranks.clear();
        self.ranks.resize(candidates, 0);
        self.previous.clear();
        self.previous.resize(candidates, NOBODY);
        self.last.clear();
        let mut violation = f64::NEG_INFINITY;
        let mut least_rank = 0;
        for &candidate in &self.order {
            let index = candidate as usize;
            if costs.violation[index] > violation {
                violation = costs.violation[index];
                least_rank = self.last.len();
            }
            let rank =
                least_rank + self.last[least_rank..].partition_point(|&last| self.front_dominates(costs, last, index));
            match self.last.get_mut(rank) {
                Some(last) => self.previous[index] = std::mem::replace(last, candidate),
                None => self.last.push(candidate),
            }
            self.ranks[index] = rank as u32;
        }
    }

    /// Whether the front that ends in `last` dominates a candidate that comes after it in the order.
    fn front_dominates(&self, costs: &Costs<'_>, last: u32, candidate: usize) -> bool {
        if costs.objectives() <= 2 {
            return costs.dominates(last as usize, candidate);
        }
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
        self.members.resize(self.order.len(), 0);
        for &candidate in &self.order {
            let slot = &mut self.ends[self.ranks[candidate as usize] as usize];
            self.members[*slot as usize] = candidate;
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

    /// The rank of every candidate, counted from 0: one more than the worst rank among those that dominate it.
    pub fn ranks(&self) -> &[u32] {
        &self.ranks
    }
}
