//! The tests of the crate from outside, in one program: the scenes are simulated, the results are
//! compared with the truth and with each other.
#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    reason = "test helpers fail loudly"
)]

mod bend_tunnel;
mod brackets;
mod far_views;
mod grow;
mod looked_through;
mod next_view;
mod objects;
mod people;
mod pipeline;
mod pose_error;
mod poses;
mod refine;
mod registered_store;
mod unseen;
mod version_7;
