//! Programs of the documentation, compiled and run by `cargo test --doc`.

/// A sensor, added step by step.
#[doc = include_str!("../docs/add-a-sensor.md")]
struct AddASensor;

/// The program on the first page.
#[doc = include_str!("../README.md")]
struct Readme;
