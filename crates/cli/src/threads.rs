//! The number of threads: that of an option, or that of the environment.

use crate::failure::Failure;

/// The variable that rayon takes the number of threads from, where no option states it.
const VARIABLE: &str = "RAYON_NUM_THREADS";

/// Most threads per core of the machine. No unit. Chosen by hand: threads beyond the cores only
/// wait for each other, and tests of equal results on few cores need some of them. Doubled,
/// 128 threads per core are started before any work. A run with 100 000 threads did not end.
const THREADS_PER_CORE: usize = 64;

/// Refuses more threads than the machine can use. `option` is the value of `--threads`; with 0 the
/// environment counts. Rayon takes one thread per core for text that is no number, so it passes.
pub fn check(option: usize) -> Result<(), Failure> {
    if option > 0 {
        let instead = "Leave the option out, or pass 0, for one thread per core";
        return check_number(option, &format!("--threads {option}"), instead);
    }
    let text = std::env::var(VARIABLE).unwrap_or_default();
    let instead = "Unset the variable, or set it to 0, for one thread per core";
    let number = text.parse().unwrap_or_default();
    check_number(number, &format!("the environment variable {VARIABLE}={number}"), instead)
}

fn check_number(threads: usize, source: &str, instead: &str) -> Result<(), Failure> {
    let cores = std::thread::available_parallelism().map_or(1, usize::from);
    let most = THREADS_PER_CORE * cores;
    if threads <= most {
        return Ok(());
    }
    Err(Failure::Usage(format!(
        "{source}: this machine has {cores} cores; expected at most {most} threads \
         ({THREADS_PER_CORE} per core). {instead}"
    )))
}
