//! Tests of partial modelling, in one program.
#![allow(clippy::unwrap_used, reason = "test code; helpers are outside test functions")]
#![allow(clippy::panic, reason = "test code")]

#[macro_use]
mod gaps;
mod along_guide;
mod common;
mod dissertation;
mod dissertation_gaps;
mod dissertation_scene;
mod dissertation_subpixel;
mod kernel;
mod near_planes;
mod near_tangent;
mod nodes;
mod one_pass;
mod one_pass_gaps;
mod one_pass_sigma;
mod one_pass_subpixel;
mod oracle;
#[allow(dead_code, reason = "the tests of transect-image use the rest")]
#[path = "../../../image/tests/it/surfaces.rs"]
mod surfaces;
