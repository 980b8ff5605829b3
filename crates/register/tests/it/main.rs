//! The integration tests of the crate, in one program.
#![allow(clippy::unwrap_used, reason = "tests and their helpers may fail loudly")]

mod common;
mod depth_cameras;
mod judging;
mod narrow_things;
mod priors;
mod readings;
mod refining;
mod thin_things;
mod wrong_views;
