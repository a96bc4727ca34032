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
