//! A page in the browser that shows a flock while it flies, and takes the operator's words.
//!
//! A program that flies something starts a [`LiveView`] and tells its [`Feed`] where the vehicles are. The page's
//! server has a thread of its own: it looks at the feed ten times a second, measures distances, raises alarms, and
//! sends each browser a binary frame. Nothing here can slow the flight: [`Feed::update`] never waits, and a browser
//! that does not read loses frames.
//!
//! ```
//! use live_view::{LiveView, Scene, Settings, VehicleNow};
//!
//! let view = LiveView::start(&Settings::default())?;
//! println!("open {}", view.url());
//! let feed = view.feed();
//! feed.scene(Scene { title: "one vehicle".into(), ..Scene::default() });
//! feed.update(|frame| {
//!     frame.time_s = 12.5;
//!     frame.vehicles = vec![VehicleNow { number: 1, x_m: 30.0, speed_mps: 10.0, ..VehicleNow::default() }];
//! });
//! # Ok::<(), live_view::ViewError>(())
//! ```
//!
//! The crate knows neither MAVLink nor the controller. Words of the operator come out of [`LiveView::take_words`] as
//! text; what they mean is the program's own affair.

pub mod alarms;
pub mod assets;
pub mod choice;
mod connections;
pub mod distances;
pub mod feed;
pub mod guard;
mod http;
pub mod look;
mod page;
mod published;
mod publisher;
pub mod recording;
pub mod scene;
mod server;
mod shared;
pub mod tape;
pub mod wire;

pub use choice::Choice;
pub use feed::Feed;
pub use guard::{Refused, Token};
pub use recording::Recording;
pub use scene::{Circle, Event, Frame, Least, Outline, Scene, Steering, VehicleNow, Weight, Wind};
pub use server::{LiveView, Settings, ViewError};
pub use shared::{Answer, Said};
pub use tape::{Progress, Tape};
