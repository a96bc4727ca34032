//! The archive A: the Pareto front of all candidates offered so far.

use std::cmp::Ordering;

use crate::crowding::Crowding;
use crate::dominance::{Costs, compare};
use crate::optimizer::FrontBuffer;
use crate::problem::Candidates;

/// Mutually non-dominated candidates without duplicates in costs (the first offered stays), in lexicographic order.
///
/// A member is removed when a candidate is offered that dominates it, or when the archive exceeds its capacity. In the
/// second case the most crowded members are removed (Eq. 17, measured once; ties: the last in order), but never the
/// best in an objective. With a capacity of at least the number of candidates offered, the archive is exact.
#[derive(Clone, Debug, Default)]
pub struct Archive {
    dimensions: usize,
    objectives: usize,
    capacity: usize,
    violation: f64,
    /// Objectives, then coordinates of one member after another; a row is a member's as long as it is in `order`.
    rows: Vec<f64>,
    free: Vec<u32>,
    /// The members' rows in lexicographic order, and where the next such order is made.
    order: Vec<u32>,
    merged: Vec<u32>,
    /// Of these, the ones that the current offer brought.
    taken: Vec<u32>,
    crowding: Crowding,
    by_crowding: Vec<u32>,
}

impl Archive {
    /// Empties it for a problem, to hold up to `capacity` members after an offer of at most `offered` at a time. The
    /// capacity is at least two members per objective, the ends of the front.
    pub fn clear(&mut self, dimensions: usize, objectives: usize, capacity: usize, offered: usize) {
        self.dimensions = dimensions;
        self.objectives = objectives;
        self.capacity = capacity.max(2 * objectives);
        let most = self.capacity + offered;
        self.rows.clear();
        self.rows.reserve(most * self.row_len());
        for buffer in [&mut self.free, &mut self.order, &mut self.merged, &mut self.taken, &mut self.by_crowding] {
            buffer.clear();
            buffer.reserve(most);
        }
        self.crowding.reserve(most);
    }

    /// Takes the candidates that the archive neither dominates nor holds, and removes the members that they dominate.
    ///
    /// `front` is a front as [`crate::dominance::NonDominatedSort`] makes it: mutually non-dominated, in lexicographic
    /// order. A front with an infinite violation is rejected.
    pub fn offer(&mut self, candidates: &Candidates<'_>, costs: &Costs<'_>, front: &[u32]) {
        let Some(&first) = front.first() else { return };
        let violation = costs.violation()[first as usize];
        match compare(violation, if self.is_empty() { f64::INFINITY } else { self.violation }) {
            Ordering::Less => self.free.append(&mut self.order),
            Ordering::Equal if violation < f64::INFINITY => {}
            _ => return,
        }
        self.violation = violation;
        self.merge(candidates, costs, front);
        if self.len() > self.capacity {
            self.thin();
        }
    }

    /// Merges two fronts that are both in lexicographic order, so that no member is dominated by a later one.
    fn merge(&mut self, candidates: &Candidates<'_>, costs: &Costs<'_>, front: &[u32]) {
        let mut members = 0;
        for &candidate in front {
            let candidate = candidate as usize;
            while let Some(&row) = self.order.get(members)
                && self.comes_first(row, costs, candidate)
            {
                members += 1;
                self.merge_member(row);
            }
            if !self.is_covered(&self.merged, |k| costs.cost(candidate, k)) {
                let row = self.store(candidates, costs, candidate);
                self.merged.push(row);
                self.taken.push(row);
            }
        }
        while let Some(&row) = self.order.get(members) {
            members += 1;
            self.merge_member(row);
        }
        std::mem::swap(&mut self.order, &mut self.merged);
        self.merged.clear();
        self.taken.clear();
    }

    /// Whether a member is not after a candidate in lexicographic order.
    fn comes_first(&self, row: u32, costs: &Costs<'_>, candidate: usize) -> bool {
        let mut pairs = (0..self.objectives).map(|k| (self.cost(row, k), costs.cost(candidate, k)));
        pairs.find(|(member, candidate)| member != candidate).is_none_or(|(member, candidate)| member < candidate)
    }

    /// Members do not dominate each other: only a member that was taken before can dominate the next one.
    fn merge_member(&mut self, row: u32) {
        if self.is_covered(&self.taken, |k| self.cost(row, k)) {
            self.free.push(row);
        } else {
            self.merged.push(row);
        }
    }

    /// Whether one of the rows that come earlier in lexicographic order is at least as good in every objective. With
    /// two objectives the last of them is the best in the second objective, and none is worse in the first.
    fn is_covered(&self, earlier: &[u32], cost: impl Fn(usize) -> f64) -> bool {
        let covers = |&row: &u32| (0..self.objectives).all(|k| self.cost(row, k) <= cost(k));
        match earlier.last() {
            Some(last) if self.objectives <= 2 => covers(last),
            _ => earlier.iter().any(covers),
        }
    }

    fn store(&mut self, candidates: &Candidates<'_>, costs: &Costs<'_>, candidate: usize) -> u32 {
        let row_len = self.row_len();
        let row = self.free.pop().unwrap_or_else(|| {
            self.rows.resize(self.rows.len() + row_len, 0.0);
            (self.rows.len() / row_len - 1) as u32
        });
        let (objectives, coordinates) = self.rows[row as usize * row_len..][..row_len].split_at_mut(self.objectives);
        for (k, objective) in objectives.iter_mut().enumerate() {
            *objective = costs.cost(candidate, k);
        }
        for (dimension, coordinate) in coordinates.iter_mut().enumerate() {
            *coordinate = candidates.coordinate(dimension)[candidate];
        }
        row
    }

    /// Drops the most crowded members until as many are left as the capacity.
    fn thin(&mut self) {
        let excess = self.order.len() - self.capacity;
        let (rows, order, row_len) = (&self.rows, &self.order, self.row_len());
        let distances =
            self.crowding.distances(order.len(), self.objectives, |i, k| rows[order[i] as usize * row_len + k]);
        self.by_crowding.clear();
        self.by_crowding.extend(0..order.len() as u32);
        self.by_crowding.select_nth_unstable_by(excess - 1, |&a, &b| {
            distances[a as usize].total_cmp(&distances[b as usize]).then(b.cmp(&a))
        });
        for &crowded in &self.by_crowding[..excess] {
            self.free.push(std::mem::replace(&mut self.order[crowded as usize], DROPPED));
        }
        self.order.retain(|&row| row != DROPPED);
    }

    /// The most members that an offer leaves.
    pub fn capacity(&self) -> usize {
        self.capacity
    }

    /// The number of members.
    pub fn len(&self) -> usize {
        self.order.len()
    }

    /// Whether nothing has been taken yet.
    pub fn is_empty(&self) -> bool {
        self.order.is_empty()
    }

    /// One member's coordinates. Panics if there is no such member, as an index does.
    pub fn member(&self, member: usize) -> &[f64] {
        &self.rows[self.order[member] as usize * self.row_len()..][self.objectives..self.row_len()]
    }

    /// Copies the members into a front.
    pub fn write(&self, front: &mut FrontBuffer) {
        front.fill(
            self.len(),
            self.dimensions,
            self.objectives,
            |i, d| self.member(i)[d],
            |i, k| self.cost(self.order[i], k),
            |_| self.violation,
        );
    }

    fn row_len(&self) -> usize {
        self.objectives + self.dimensions
    }

    fn cost(&self, row: u32, objective: usize) -> f64 {
        self.rows[row as usize * self.row_len() + objective]
    }
}

const DROPPED: u32 = u32::MAX;
