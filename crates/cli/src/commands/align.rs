//! `transect align`: the pose of a scanner from scans of the machine table and of spheres.

use super::planes::parse_numbers;
use crate::failure::Failure;
use crate::table::{Lengths, Row, print};
use std::path::PathBuf;
use transect_geometry::{LengthUnit, Point3, Vector3};
use transect_workflow::{AlignmentScans, SphereFile};

/// Options of `align`.
#[derive(Debug, clap::Args)]
pub struct Arguments {
    /// Points on the machine table in the sensor frame: one x,y,z per line.
    #[arg(long, value_name = "FILE")]
    table: PathBuf,
    /// The table's normal in the world.
    #[arg(long, value_name = "X,Y,Z", default_value = "0,0,1", allow_hyphen_values = true)]
    table_normal: String,
    /// A point of the table in the world.
    #[arg(long, value_name = "X,Y,Z", default_value = "0,0,0", allow_hyphen_values = true)]
    table_point: String,
    /// Points on a sphere in the sensor frame, its centre in the world and its radius; may be
    /// repeated.
    #[arg(long, value_name = "FILE,X,Y,Z,RADIUS", required = true)]
    sphere: Vec<String>,
    /// A direction known in both frames, such as the machine's linear axis: in the sensor, then in
    /// the world [default: unknown; then two spheres are needed].
    #[arg(long, value_name = "X,Y,Z,X,Y,Z", allow_hyphen_values = true)]
    axis: Option<String>,
    /// Unit of all lengths: m, dm, cm, mm, um, in or ft.
    #[arg(long)]
    unit: LengthUnit,
}

/// Largest residual of a sound alignment, in the noise of the spheres by themselves. No unit.
/// Chosen by hand: sound scans have 1, and what the table does under load adds to it. Doubled,
/// places that err by three times the noise pass.
const MOST_RESIDUAL: f64 = 2.0;

/// Runs the command.
pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let vector = |option: &str, text: &str| numbers::<3>(option, text).map(Vector3::from);
    let axis = arguments.axis.as_deref().map(parse_axis).transpose()?;
    let scans = AlignmentScans {
        table: arguments.table.clone(),
        table_in_world: [
            direction("table-normal", vector("table-normal", &arguments.table_normal)?)?,
            vector("table-point", &arguments.table_point)?,
        ],
        spheres: arguments.sphere.iter().map(|text| sphere(text)).collect::<Result<_, _>>()?,
        axis,
    };
    let found = scans.align()?;
    if found.residual_rms > MOST_RESIDUAL * found.sphere_noise {
        eprintln!(
            "warning: the residual is {:.1} times the noise of the spheres by themselves: the stated \
             places of table and spheres contradict each other, or the scanner errs. Check the \
             places, the radii (not diameters), and which file belongs to which surface",
            found.residual_rms / found.sphere_noise
        );
    }
    let (lengths, mut pose) =
        (Lengths::for_programs(arguments.unit), found.world_from_sensor.to_homogeneous());
    pose.fixed_view_mut::<3, 1>(0, 3).apply(|length| *length = lengths.converted(*length, 1));
    let rows = pose.row_iter().map(|row| {
        let numbers: Vec<String> = row.iter().map(|number| format!("{number:.9}")).collect();
        numbers.join(", ")
    });
    let rows: Vec<String> = rows.collect();
    print(&[
        Row::length("residual, root mean square", found.residual_rms, arguments.unit),
        Row::length("noise of the spheres by themselves", found.sphere_noise, arguments.unit),
        Row::plain("points used", found.used),
        Row::plain("outliers", found.rejected),
        Row::new("pose", format!("[{}]", rows.join(", ")), lengths.unit.symbol()),
    ]);
    Ok(())
}

fn sphere(text: &str) -> Result<SphereFile, Failure> {
    // The path may hold commas.
    let at = text.rmatch_indices(',').nth(3).map(|(at, _)| at);
    let parts = at.map(|at| (&text[..at], &text[at + 1..]));
    let parsed = parts.and_then(|(path, rest)| Some((path, parse_numbers(rest)?)));
    let (path, [x, y, z, radius]) = parsed.ok_or_else(|| {
        let problem = format!(
            "--sphere: found {text:?}; expected FILE,X,Y,Z,RADIUS: a file, the centre of the \
             sphere and its radius"
        );
        Failure::Usage(problem)
    })?;
    Ok(SphereFile { path: PathBuf::from(path), center: Point3::new(x, y, z), radius })
}

/// The axis in the sensor and in the world.
fn parse_axis(text: &str) -> Result<[Vector3; 2], Failure> {
    let [a, b, c, d, e, f] = numbers::<6>("axis", text)?;
    let [in_sensor, in_world] = [Vector3::new(a, b, c), Vector3::new(d, e, f)];
    Ok([direction("axis", in_sensor)?, direction("axis", in_world)?])
}

/// Refuses a vector that has no direction.
fn direction(option: &str, vector: Vector3) -> Result<Vector3, Failure> {
    let length = vector.norm();
    if length.is_finite() && length > 0.0 {
        return Ok(vector);
    }
    let [x, y, z]: [f64; 3] = vector.into();
    Err(Failure::Usage(format!(
        "--{option}: found {x},{y},{z}, which has no direction; expected finite numbers that are \
         not all 0, such as 0,0,1"
    )))
}

fn numbers<const N: usize>(option: &str, text: &str) -> Result<[f64; N], Failure> {
    let wrong = || {
        let problem =
            format!("--{option}: found {text:?}; expected {N} numbers with commas between");
        Failure::Usage(problem)
    };
    parse_numbers(text).ok_or_else(wrong)
}
