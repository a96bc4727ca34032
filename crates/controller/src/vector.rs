//! Two-dimensional vectors in the horizontal plane (x north, y east).

use std::ops::{Add, Mul, Sub};

/// A horizontal vector: x north, y east.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Vec2 {
    /// North.
    pub x: f64,
    /// East.
    pub y: f64,
}

impl Vec2 {
    /// No length.
    pub const ZERO: Self = Self { x: 0.0, y: 0.0 };

    /// From north and east.
    pub const fn new(x: f64, y: f64) -> Self {
        Self { x, y }
    }

    /// Scalar product.
    pub fn dot(self, other: Self) -> f64 {
        self.x * other.x + self.y * other.y
    }

    /// The part of `other` to the right of `self`, scaled by both lengths: positive when `other` is clockwise of it.
    pub fn cross(self, other: Self) -> f64 {
        self.x * other.y - self.y * other.x
    }

    /// Least length on the straight way from this vector to another.
    pub fn nearest_to(self, other: Self) -> f64 {
        let way = other - self;
        let share = (-self.dot(way) / way.dot(way).max(1e-12)).clamp(0.0, 1.0);
        (self + way * share).norm()
    }

    /// Length.
    pub fn norm(self) -> f64 {
        self.dot(self).sqrt()
    }
}

impl Add for Vec2 {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        Self::new(self.x + other.x, self.y + other.y)
    }
}

impl Sub for Vec2 {
    type Output = Self;
    fn sub(self, other: Self) -> Self {
        Self::new(self.x - other.x, self.y - other.y)
    }
}

impl Mul<f64> for Vec2 {
    type Output = Self;
    fn mul(self, factor: f64) -> Self {
        Self::new(self.x * factor, self.y * factor)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn two_that_cross_are_nearest_between_their_samples() {
        assert!((Vec2::new(-3.0, 1.0).nearest_to(Vec2::new(5.0, 1.0)) - 1.0).abs() < 1e-12);
        assert_eq!(Vec2::new(3.0, 4.0).nearest_to(Vec2::new(6.0, 8.0)), 5.0);
        assert_eq!(Vec2::new(3.0, 4.0).nearest_to(Vec2::new(3.0, 4.0)), 5.0);
    }
}
