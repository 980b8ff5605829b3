//! The tests of fusion through its public interface, as one program.
#![allow(clippy::unwrap_used, reason = "test code; shared helpers are outside test functions")]

mod bridges;
mod consensus;
mod corners;
mod displaced;
mod draws;
mod drift;
mod incidence;
mod invariants;
mod marks;
mod near_and_far;
mod noise;
mod overlap_rules;
mod page;
mod pairwise;
mod planar;
mod scene;
mod sheets;
mod table;
mod topology;
