//! The records of a scan: the place of each in the grid, and its point.

use e57::{PointCloud, PointCloudReaderRaw, RawValues, RecordDataType, RecordName};
use std::f64::consts::FRAC_PI_2;
use std::io::{Read, Seek};
use transect_device::MISSING_POINT;
use transect_geometry::Point3;

/// Largest elevation in excess of a right angle that is rounding, in radians. Chosen by hand:
/// scaled integers have steps below it. Doubled, elevations in degrees are still refused.
const ELEVATION_ROUNDING: f64 = 1e-3;

/// A record of a structured scan.
#[derive(Debug, Clone, Copy)]
pub(super) struct Cell {
    pub(super) row: i32,
    pub(super) col: i32,
    /// NaN if the record is invalid.
    pub(super) point: Point3,
}

/// All records of a structured scan. An error is a sentence that names the record.
pub(super) fn read<R: Read + Seek>(
    cloud: &PointCloud,
    raw: PointCloudReaderRaw<'_, R>,
) -> Result<Vec<Cell>, String> {
    let fields = Fields::of(cloud).ok_or("the scan has no rows, columns or coordinates")?;
    let mut cells = Vec::new();
    // The announced number is not trusted, so the list grows with the records that are there.
    for values in raw {
        let number = cells.len();
        let cell = match values {
            Ok(values) => fields.cell(&values),
            Err(error) => Err(format!("{error}; copy or export the file again")),
        };
        cells.push(cell.map_err(|problem| format!("record {number}: {problem}"))?);
    }
    Ok(cells)
}

/// A field's place in a record, and its type.
#[derive(Debug)]
struct Field {
    name: RecordName,
    at: usize,
    kind: RecordDataType,
}

/// The fields that make a cell.
#[derive(Debug)]
struct Fields {
    row: Field,
    col: Field,
    /// 0 if the coordinates are valid.
    invalid: Option<Field>,
    coordinates: [Field; 3],
    spherical: bool,
}

impl Fields {
    /// The Cartesian coordinates of a record with both kinds count: they need no conversion.
    fn of(cloud: &PointCloud) -> Option<Self> {
        use RecordName::{
            CartesianInvalidState, CartesianX, CartesianY, CartesianZ, ColumnIndex, RowIndex,
            SphericalAzimuth, SphericalElevation, SphericalInvalidState, SphericalRange,
        };
        let field = |name: RecordName| {
            let at = cloud.prototype.iter().position(|field| field.name == name)?;
            let kind = cloud.prototype.get(at)?.data_type.clone();
            Some(Field { name, at, kind })
        };
        let spherical = !cloud.has_cartesian();
        let ([a, b, c], invalid) = if spherical {
            ([SphericalRange, SphericalAzimuth, SphericalElevation], SphericalInvalidState)
        } else {
            ([CartesianX, CartesianY, CartesianZ], CartesianInvalidState)
        };
        Some(Self {
            row: field(RowIndex)?,
            col: field(ColumnIndex)?,
            invalid: field(invalid),
            coordinates: [field(a)?, field(b)?, field(c)?],
            spherical,
        })
    }

    fn cell(&self, values: &RawValues) -> Result<Cell, String> {
        let (row, col) = (self.row.index(values)?, self.col.index(values)?);
        let valid = match self.invalid.as_ref().map(|field| field.number(values)).transpose()? {
            None | Some(0.0) => true,
            // A direction without a range, or no coordinates at all.
            Some(1.0 | 2.0) => false,
            Some(other) => return Err(format!("the invalid state is {other}; expected 0, 1 or 2")),
        };
        let point = if valid { self.point(values)? } else { MISSING_POINT };
        Ok(Cell { row, col, point })
    }

    fn point(&self, values: &RawValues) -> Result<Point3, String> {
        let [a, b, c] = &self.coordinates;
        let (a, b, c) = (a.number(values)?, b.number(values)?, c.number(values)?);
        if !self.spherical {
            return Ok(Point3::new(a, b, c));
        }
        if c.abs() > FRAC_PI_2 + ELEVATION_ROUNDING {
            return Err(format!(
                "the elevation is {c}; expected radians within ±π/2; export angles in radians"
            ));
        }
        // Sine and cosine accept azimuths beyond ±π, too.
        let ((sin_a, cos_a), (sin_e, cos_e)) = (b.sin_cos(), c.sin_cos());
        Ok(Point3::new(a * cos_e * cos_a, a * cos_e * sin_a, a * sin_e))
    }
}

impl Field {
    fn number(&self, values: &RawValues) -> Result<f64, String> {
        let value = values.get(self.at).ok_or("the record is too short")?;
        value.to_f64(&self.kind).map_err(|error| error.to_string())
    }

    fn index(&self, values: &RawValues) -> Result<i32, String> {
        let number = self.number(values)?;
        // A cast of a number outside 32 bits, or of a fraction, changes it.
        let index = number as i32;
        if f64::from(index) == number {
            return Ok(index);
        }
        Err(format!("{:?} is {number}; expected an integer of 32 bits", self.name))
    }
}
