//! Tests of what is known of one range image, in one program.
#![allow(clippy::unwrap_used, reason = "test code; helpers are outside test functions")]

mod edges;
mod noise;
mod smooth;
mod surfaces;
mod twin;
