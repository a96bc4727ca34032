//! The autopilot: how it flies, what it watches over and what it does about it.

pub(crate) mod arming;
pub(crate) mod failsafe;
pub(crate) mod fence;
pub(crate) mod flight;
pub(crate) mod home;
pub(crate) mod manual_control;
pub(crate) mod mission;
pub(crate) mod rally;
