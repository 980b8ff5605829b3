//! The time and memory of a run, by stage.

use crate::table::Row;
use serde::Serialize;
use std::time::{Duration, Instant};
use transect::Timings;

/// The cost of a stage.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct StageCost {
    /// Its name.
    pub stage: String,
    /// Time by the clock.
    pub seconds: f64,
    /// Largest resident memory of the process up to the stage's end; `None` where it is not known.
    pub peak_memory_mib: Option<f64>,
}

/// The stages of a run in the order in which they ended.
#[derive(Debug, Clone, Default, PartialEq, Serialize)]
#[serde(transparent)]
pub struct Costs(Vec<StageCost>);

impl Costs {
    /// Does the work of a stage and notes its cost.
    pub fn stage<T>(&mut self, stage: &str, work: impl FnOnce() -> T) -> T {
        let began = Instant::now();
        let done = work();
        self.push(stage, began.elapsed(), peak_memory_mib());
        done
    }

    /// Puts earlier stages before these.
    pub fn begin_with(&mut self, earlier: Self) {
        self.0.splice(..0, earlier.0);
    }

    /// Notes the stages of the modeler, which measures them itself.
    pub(crate) fn modelled(&mut self, timings: &Timings) {
        let busy = (timings.reading + timings.modelling).as_secs_f64();
        // Reading and finding curves run side by side: the clock's time is shared by their work.
        let share = |part: Duration| {
            if busy > 0.0 {
                timings.views.mul_f64(part.as_secs_f64() / busy)
            } else {
                Duration::ZERO
            }
        };
        if !timings.poses.is_zero() {
            self.push("judging and refining poses", timings.poses, None);
        }
        self.push("reading", share(timings.reading), None);
        self.push("finding curves", share(timings.modelling), None);
        // The others have ended before, and their peaks are no longer known.
        self.push("fusing", timings.fusion, peak_memory_mib());
    }

    fn push(&mut self, stage: &str, time: Duration, peak_memory_mib: Option<f64>) {
        let (stage, seconds) = (stage.to_owned(), time.as_secs_f64());
        self.0.push(StageCost { stage, seconds, peak_memory_mib });
    }

    /// One row per stage and their sum.
    pub fn rows(&self) -> Vec<Row> {
        let row = |c: &StageCost| {
            let peak = c.peak_memory_mib.map_or(String::new(), |m| format!(", peak {m:.0} MiB"));
            Row::new(format!("time {}", c.stage), format!("{:.3}", c.seconds), format!("s{peak}"))
        };
        let total: f64 = self.0.iter().map(|c| c.seconds).sum();
        let total = Row::new("time in all", format!("{total:.3}"), "s");
        self.0.iter().map(row).chain([total]).collect()
    }
}

/// Largest resident memory of this process so far, in MiB; `None` where the system does not tell.
pub fn peak_memory_mib() -> Option<f64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find(|l| l.starts_with("VmHWM:"))?;
    let kib: f64 = line.split_whitespace().nth(1)?.parse().ok()?;
    Some(kib / 1024.0)
}
