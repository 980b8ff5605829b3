//! Random lookup-table scanners of 12 rows and 17 columns, `p` from about 20 to 80.

use proptest::prelude::*;
use transect_sensors::LookupTable;
use transect_sensors::lookup_table::{
    CalibrationOptions, CalibrationSweep, LinearSteps, Mounting, ScanPlane, SynchronizedScanner,
    ThetaSteps, Viewpoints, digitize,
};

/// Base line, focal length, convergence of a scanner.
fn scanners() -> impl Strategy<Value = SynchronizedScanner> {
    (40.0..80.0_f64, 40.0..80.0_f64, 0.3..0.5_f64).prop_map(|(base, focal_length, convergence)| {
        SynchronizedScanner {
            base,
            focal_length,
            convergence_rad: convergence,
            detector_axis: 50.0,
        }
    })
}

/// Noise-free sweeps at 2 to 9 unequal depths over a table that leans; mirrored if asked for.
fn sweeps(
    scanner: SynchronizedScanner,
    columns: ThetaSteps,
    (depths, slope, mirrored): (usize, f64, bool),
) -> Vec<CalibrationSweep> {
    let sign = if mirrored { -1.0 } else { 1.0 };
    let depth = |k: usize| 110.0 + 90.0 * (k as f64 / (depths - 1) as f64).powf(1.3);
    let mut sweeps: Vec<_> =
        (0..depths).map(|k| scanner.sweep(&columns, depth(k), slope)).collect();
    sweeps.iter_mut().flat_map(|s| &mut s.samples).for_each(|s| s.u *= sign);
    sweeps
}

/// Tables of every mounting, either way round, with and without known viewpoints.
pub fn tables() -> impl Strategy<Value = LookupTable> {
    let columns =
        (-0.2..0.1_f64, 0.01..0.02_f64).prop_map(|(t, d)| ThetaSteps::from_radians(t, d, 17));
    let sweep_options = (2..10_usize, -0.1..0.1_f64, any::<bool>());
    let rows = (-50.0..50.0_f64, prop_oneof![-3.0..-0.2_f64, 0.2..3.0_f64]);
    let mounting = (any::<bool>(), -60.0..60.0_f64);
    let all = (scanners(), columns, sweep_options, rows, mounting, any::<bool>());
    all.prop_map(|(scanner, columns, options, (start, step), (xz, tilt), known)| {
        let sweeps = sweeps(scanner, columns, options);
        let field = digitize(&sweeps, &columns, CalibrationOptions::EXACT).unwrap();
        let plane = if xz { ScanPlane::Xz } else { ScanPlane::Yz };
        let mounting = Mounting::from_degrees(plane, tilt);
        let table = LookupTable::new(field, LinearSteps::new(start, step, 12), mounting).unwrap();
        let sign = if options.2 { -1.0 } else { 1.0 };
        let (mut projector, mut receiver) = (scanner.projector(), scanner.receiver());
        projector.x *= sign;
        receiver.x *= sign;
        let viewpoints = Viewpoints { projector, receiver };
        if known { table.with_viewpoints(viewpoints).unwrap() } else { table }
    })
}
