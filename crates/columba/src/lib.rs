//! The rooms of the program that can be tested without it: what a flight was, how it is recorded, how it is reported.

pub mod flight;
pub mod record;
pub mod report;
