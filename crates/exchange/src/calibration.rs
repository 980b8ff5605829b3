//! Calibration sweeps of a lookup-table scanner, as a text file.
//!
//! ```text
//! # nearest depth first; any line like this is a comment
//! sweep,theta,p,u,v
//! 0,-0.36,21.5,-41.2,110.3
//! 0,-0.35,nan,0,0            no return: left out
//! 1,-0.36,23.9,-42.6,114.0
//! ```
//!
//! | column | meaning |
//! |---|---|
//! | `sweep` | a whole number; lines of one sweep are consecutive; the nearest depth comes first |
//! | `theta` | scanning angle, radians, rising along the sweep |
//! | `p` | place of the spot on the detector, in the detector's unit; empty or `nan`: no return |
//! | `u`, `v` | place of the spot in the scanner's plane; lengths, not read where there is no return |

use crate::input::read_text;
use crate::{Place, ReadError};
use std::io::{self, Write};
use std::path::Path;
use transect_sensors::lookup_table::{CalibrationSample, CalibrationSweep};

/// The columns, in their order.
const HEADER: [&str; 5] = ["sweep", "theta", "p", "u", "v"];

/// Most sweeps that are read. Chosen by hand: forty times the number of a usual calibration. The
/// memory of digitising grows with the square of this number.
const MOST_SWEEPS: usize = 1000;

/// Reads the sweeps of a calibration, nearest depth first: lines `sweep,theta,p,u,v` below that
/// header.
///
/// # Units
/// Radians, the detector's unit, lengths in the scan's unit.
///
/// # Errors
/// [`ReadError`] naming line and column where a number is missing, not finite or out of order, and
/// for fewer than two sweeps or more than a thousand.
pub fn read_calibration(path: &Path) -> Result<Vec<CalibrationSweep>, ReadError> {
    let text = read_text(path)?;
    let mut reader = Reader { path, header: false, sweeps: Vec::new() };
    for (number, line) in text.lines().enumerate() {
        let content = line.split('#').next().unwrap_or_default().trim();
        if !content.is_empty() {
            let read = reader.line(number + 1, content);
            read.map_err(|problem| ReadError::damaged(path, Place::Line(number + 1), problem))?;
        }
    }
    reader.finish()
}

/// A sweep, its number, and the line it begins on.
struct Numbered {
    number: u64,
    line: usize,
    /// The last angle, also of a sample without a return.
    theta: f64,
    sweep: CalibrationSweep,
}

struct Reader<'a> {
    path: &'a Path,
    header: bool,
    sweeps: Vec<Numbered>,
}

impl Reader<'_> {
    fn line(&mut self, line: usize, content: &str) -> Result<(), String> {
        let fields: Vec<&str> = content.split(',').map(str::trim).collect();
        if !self.header {
            self.header = fields == HEADER;
            let wanted = || format!("the header must be \"{}\"", HEADER.join(","));
            return if self.header { Ok(()) } else { Err(wanted()) };
        }
        let &[sweep, theta, p, u, v] = fields.as_slice() else {
            return Err(format!("{} columns, not {}", fields.len(), HEADER.len()));
        };
        let number = sweep.parse();
        let number =
            number.map_err(|_| format!("column \"sweep\": {sweep:?} is no whole number"))?;
        let theta = finite("theta", theta)?;
        let sweep = self.sweep(number, line)?;
        if theta <= sweep.theta {
            return Err(format!("column \"theta\": {theta} does not rise along the sweep"));
        }
        sweep.theta = theta;
        if p.is_empty() || p.eq_ignore_ascii_case("nan") {
            return Ok(());
        }
        let (p, u, v) = (finite("p", p)?, finite("u", u)?, finite("v", v)?);
        if p <= 0.0 {
            return Err(format!("column \"p\": {p} is not positive"));
        }
        sweep.sweep.samples.push(CalibrationSample { theta_rad: theta, p, u, v });
        Ok(())
    }

    /// The sweep of a number: the last one or a new one.
    fn sweep(&mut self, number: u64, line: usize) -> Result<&mut Numbered, String> {
        if self.sweeps.last().is_none_or(|last| last.number != number) {
            if self.sweeps.iter().any(|s| s.number == number) {
                return Err(format!(
                    "column \"sweep\": the lines of sweep {number} do not stand together"
                ));
            }
            if self.sweeps.len() == MOST_SWEEPS {
                return Err(format!("column \"sweep\": more than {MOST_SWEEPS} sweeps"));
            }
            let sweep = CalibrationSweep::default();
            self.sweeps.push(Numbered { number, line, theta: f64::NEG_INFINITY, sweep });
        }
        self.sweeps.last_mut().ok_or_else(|| "there is no sweep".to_owned())
    }

    fn finish(self) -> Result<Vec<CalibrationSweep>, ReadError> {
        if let Some(empty) = self.sweeps.iter().find(|s| s.sweep.samples.is_empty()) {
            let problem = format!("column \"p\": sweep {} has no returns at all", empty.number);
            return Err(ReadError::damaged(self.path, Place::Line(empty.line), problem));
        }
        if self.sweeps.len() < 2 {
            let problem = format!("{} sweeps; at least two depths are needed", self.sweeps.len());
            return Err(ReadError::damaged(self.path, Place::Whole, problem));
        }
        Ok(self.sweeps.into_iter().map(|s| s.sweep).collect())
    }
}

fn finite(column: &str, text: &str) -> Result<f64, String> {
    let number = text.parse().ok().filter(|n: &f64| n.is_finite());
    number.ok_or_else(|| format!("column \"{column}\": {text:?} is no finite number"))
}

/// Writes sweeps that [`read_calibration`] reads, numbered from 0; a `p` that is NaN means no
/// return.
///
/// # Errors
/// An error of `out`, or a required number that is not finite.
pub fn write_calibration(sweeps: &[CalibrationSweep], out: &mut dyn Write) -> io::Result<()> {
    writeln!(out, "{}", HEADER.join(","))?;
    for (number, sweep) in sweeps.iter().enumerate() {
        for CalibrationSample { theta_rad, p, u, v } in &sweep.samples {
            if p.is_nan() && theta_rad.is_finite() {
                writeln!(out, "{number},{theta_rad},nan,,")?;
            } else if [theta_rad, p, u, v].iter().all(|n| n.is_finite()) {
                writeln!(out, "{number},{theta_rad},{p},{u},{v}")?;
            } else {
                let problem = format!("sweep {number}, theta {theta_rad}: a number is not finite");
                return Err(io::Error::other(problem));
            }
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_data::write_to_folder;
    use proptest::prelude::*;

    fn read(text: &str) -> Result<Vec<CalibrationSweep>, ReadError> {
        let (_folder, path) = write_to_folder("table.csv", text.as_bytes());
        read_calibration(&path)
    }

    fn sweeps() -> impl Strategy<Value = Vec<CalibrationSweep>> {
        let sample = (1e-9..1e9_f64, prop::array::uniform2(-1e7..1e7_f64));
        let sweep = prop::collection::vec(sample, 1..9).prop_map(|samples| {
            let with_angle = |(k, (p, [u, v])): (usize, (f64, [f64; 2]))| CalibrationSample {
                theta_rad: k as f64 / 7.0 - 0.3,
                p,
                u,
                v,
            };
            CalibrationSweep { samples: samples.into_iter().enumerate().map(with_angle).collect() }
        });
        prop::collection::vec(sweep, 2..6)
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(48))]

        #[test]
        fn writing_and_reading_returns_the_same_numbers(sweeps in sweeps()) {
            let mut text = Vec::new();
            write_calibration(&sweeps, &mut text).unwrap();
            let back = read(&String::from_utf8(text).unwrap()).unwrap();
            prop_assert_eq!(back, sweeps);
        }
    }

    #[test]
    fn comments_spaces_and_samples_without_a_return_are_passed_over() {
        let text = "# made by hand\r\n\r\n sweep, theta,p, u,v\r\n4, -0.5, 20, -3, 110 # first\r\n\
            4,-0.25,nan,x,\r\n4,0.5,,,\r\n2,-0.5,25,-4,1e2\r\n";
        let read = read(text).unwrap();
        assert_eq!(read.len(), 2);
        let first = CalibrationSample { theta_rad: -0.5, p: 20.0, u: -3.0, v: 110.0 };
        assert_eq!(read[0].samples, [first]);
        assert_eq!(read[1].samples[0].v, 100.0);
    }

    #[test]
    fn missing_returns_are_written_and_left_out() {
        let sample = |theta_rad, p| CalibrationSample { theta_rad, p, u: 1.0, v: 2.0 };
        let sweep = CalibrationSweep { samples: vec![sample(0.0, f64::NAN), sample(0.1, 5.0)] };
        let mut text = Vec::new();
        write_calibration(&[sweep.clone(), sweep.clone()], &mut text).unwrap();
        let back = read(std::str::from_utf8(&text).unwrap()).unwrap();
        assert_eq!(back[1].samples, sweep.samples[1..]);
        let wild = CalibrationSweep { samples: vec![sample(f64::NAN, 5.0)] };
        assert!(write_calibration(&[wild], &mut text).is_err());
    }

    #[test]
    fn what_is_wrong_is_named_by_line_and_column() {
        let sound = "sweep,theta,p,u,v\n0,0,1,2,3\n0,1,1,2,3\n1,0,4,5,6\n";
        assert!(read(sound).is_ok());
        let line = "table.csv, line 4: ";
        for (from, to, wanted) in [
            ("sweep,", "depth,", "line 1: the header must be \"sweep,theta,p,u,v\"".to_owned()),
            ("1,0,4,5,6", "1,0,4,5", format!("{line}4 columns, not 5")),
            ("1,0,4,5,6", "1,0,4,5,6,", format!("{line}6 columns, not 5")),
            ("1,0,4,5,6", "-1,0,4,5,6", format!("{line}column \"sweep\": \"-1\" is no whole")),
            ("1,0,4", "1,,4", format!("{line}column \"theta\": \"\" is no finite number")),
            ("4,5,6", "inf,5,6", format!("{line}column \"p\": \"inf\" is no finite number")),
            ("4,5,6", "4,nan,6", format!("{line}column \"u\": \"nan\" is no finite number")),
            ("4,5,6", "4,5,1e999", format!("{line}column \"v\": \"1e999\" is no finite number")),
            ("4,5,6", "-4,5,6", format!("{line}column \"p\": -4 is not positive")),
            ("1,0,4,5,6", "0,1,4,5,6", format!("{line}column \"theta\": 1 does not rise")),
            ("1,0,4,5,6", "1,0,nan,,", format!("{line}column \"p\": sweep 1 has no returns")),
            ("1,0,4,5,6", "1,0,4,5,6\n0,2,4,5,6", "line 5: column \"sweep\": the lines".to_owned()),
            ("1,0,4,5,6\n", "", "table.csv: 1 sweeps; at least two depths are needed".to_owned()),
        ] {
            let error = read(&sound.replace(from, to)).unwrap_err().to_string();
            assert!(error.contains(&wanted), "{from} → {to}: {error}");
        }
        let many: String = (0..1001).map(|k| format!("{k},0,{k}.5,0,{k}\n")).collect();
        let many = read(&format!("sweep,theta,p,u,v\n{many}")).unwrap_err().to_string();
        assert!(many.ends_with("line 1002: column \"sweep\": more than 1000 sweeps"), "{many}");
        let empty = read("").unwrap_err().to_string();
        assert!(empty.ends_with("0 sweeps; at least two depths are needed"), "{empty}");
    }
}
