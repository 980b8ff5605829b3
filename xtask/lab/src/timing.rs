//! Fair times on a machine that others use, too.
//!
//! Variants take turns, round by round, so that a slow minute slows all of them. Each counts the
//! time its thread was running rather than the time that passed. The result is the median of the
//! rounds.

use crate::statistics::median;
use std::time::Instant;

/// One thing to be timed.
pub struct Variant<'a> {
    pub name: &'static str,
    /// Factor of its time: for those that do a part of the work.
    pub scale: f64,
    pub run: Box<dyn FnMut() + 'a>,
}

impl<'a> Variant<'a> {
    pub fn new(name: &'static str, run: impl FnMut() + 'a) -> Self {
        Self { name, scale: 1.0, run: Box::new(run) }
    }
}

/// Median seconds of every variant.
pub fn time(variants: &mut [Variant<'_>], rounds: usize) -> Vec<f64> {
    let mut seconds = vec![Vec::new(); variants.len()];
    for round in 0..=rounds {
        for (variant, seconds) in variants.iter_mut().zip(&mut seconds) {
            let took = once(&mut variant.run);
            // The first round warms up.
            if round > 0 {
                seconds.push(took * variant.scale);
            }
        }
    }
    seconds.iter().map(|s| median(s)).collect()
}

/// Seconds that something took once: those its thread was running, where the system tells.
pub fn once(run: impl FnOnce()) -> f64 {
    let (began, running) = (Instant::now(), thread_seconds());
    run();
    let ran = thread_seconds().zip(running).map(|(end, start)| end - start);
    ran.unwrap_or_else(|| began.elapsed().as_secs_f64())
}

/// How long this thread has been running, where the system tells.
#[cfg(unix)]
fn thread_seconds() -> Option<f64> {
    let time = rustix::time::clock_gettime(rustix::time::ClockId::ThreadCPUTime);
    Some(time.tv_sec as f64 + 1e-9 * time.tv_nsec as f64)
}

#[cfg(not(unix))]
fn thread_seconds() -> Option<f64> {
    None
}
