//! The program's rooms: configuration, the three ways to fly, the judge, the record, the report and the comparison. It
//! wires the other crates together and holds no algorithm.

pub mod args;
pub mod chatter;
pub mod commands;
pub mod compare;
pub mod config;
pub mod counted;
pub mod flight;
pub mod flying;
pub mod help;
pub mod identify;
pub mod judge;
pub mod prediction;
pub mod record;
pub mod report;
pub mod share;
pub mod smoothness;
pub mod station;
pub mod suites;
pub mod view;
