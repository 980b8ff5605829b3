//! The integration tests of the crate, in one program.
#![allow(clippy::unwrap_used, reason = "tests and their helpers may fail loudly")]

mod alignment;
mod depth_offsets;
mod halved;
mod laws;
mod lookup_table;
mod noise;
mod ray_table;
mod separable;
mod tables;
