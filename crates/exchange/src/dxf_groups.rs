//! Groups of a DXF drawing: the pairs of a code and a value that both drawing writers write.

use std::io::{self, Write};
use transect_geometry::{LengthUnit, PlaneIndex, Point3};

/// Writes groups one after the other.
pub(crate) struct Groups<'a> {
    pub(crate) out: &'a mut dyn Write,
}

impl Groups<'_> {
    pub(crate) fn text(&mut self, code: u16, value: &str) -> io::Result<()> {
        write!(self.out, "{code}\n{value}\n")
    }

    pub(crate) fn integer(&mut self, code: u16, value: i64) -> io::Result<()> {
        write!(self.out, "{code}\n{value}\n")
    }

    pub(crate) fn handle(&mut self, code: u16, handle: u64) -> io::Result<()> {
        write!(self.out, "{code}\n{handle:X}\n")
    }

    /// The fewest digits that read back as the same number, without an exponent and with a decimal
    /// point: some readers tell a real number by its point.
    pub(crate) fn number(&mut self, code: u16, value: f64) -> io::Result<()> {
        let point = if value.fract() == 0.0 { ".0" } else { "" };
        write!(self.out, "{code}\n{value}{point}\n")
    }

    /// A point as groups 10, 20 and 30.
    pub(crate) fn point(&mut self, point: &Point3) -> io::Result<()> {
        self.number(10, point.x)?;
        self.number(20, point.y)?;
        self.number(30, point.z)
    }

    /// Writes a template. Each of its lines is a code, a space and a value. A line `@mark` calls
    /// `fill` with the mark, and every `{name}` is replaced by the value of that name.
    pub(crate) fn template(
        &mut self,
        template: &str,
        values: &[(&str, String)],
        mut fill: impl FnMut(&mut Self, &str) -> io::Result<()>,
    ) -> io::Result<()> {
        for line in template.lines().filter(|l| !l.is_empty() && !l.starts_with('#')) {
            if let Some(mark) = line.strip_prefix('@') {
                fill(self, mark)?;
                continue;
            }
            let mut line = line.to_owned();
            for (name, value) in values {
                line = line.replace(&format!("{{{name}}}"), value);
            }
            let (code, value) = line.split_once(' ').unwrap_or((&line, ""));
            write!(self.out, "{code}\n{value}\n")?;
        }
        Ok(())
    }
}

/// The values that every drawing states about its length unit: its symbol, its `$INSUNITS`, and
/// `$MEASUREMENT` (0 for inches, 1 for the metric system).
pub(crate) fn unit_values(unit: LengthUnit) -> [(&'static str, String); 3] {
    let metric = !matches!(unit, LengthUnit::Inch | LengthUnit::Foot);
    [
        ("unit", unit.to_string()),
        ("insertion_unit", insertion_unit(unit).to_string()),
        ("measurement", u8::from(metric).to_string()),
    ]
}

/// The number of a unit in `$INSUNITS`.
pub(crate) fn insertion_unit(unit: LengthUnit) -> u8 {
    match unit {
        LengthUnit::Inch => 1,
        LengthUnit::Foot => 2,
        LengthUnit::Millimetre => 4,
        LengthUnit::Centimetre => 5,
        LengthUnit::Metre => 6,
        LengthUnit::Micrometre => 13,
        LengthUnit::Decimetre => 14,
    }
}

/// The unit of a number in `$INSUNITS`; `None` for units that no model has.
pub(crate) fn unit_of_insertion(number: f64) -> Option<LengthUnit> {
    LengthUnit::ALL.into_iter().find(|unit| f64::from(insertion_unit(*unit)) == number)
}

/// The layer of a plane: letters, digits and `_`, at most 31 characters, as release 12 allows.
pub(crate) fn layer_name(index: PlaneIndex) -> String {
    let sign = if index.0 < 0 { "N" } else { "" };
    let digits = if index.0 < 0 { 3 } else { 4 };
    format!("PLANE_{sign}{:0digits$}", index.0.unsigned_abs())
}

/// The colour of a plane's layer by AutoCAD's colour index: red, yellow, green, cyan, blue or
/// magenta, so that neighbouring planes differ.
pub(crate) fn layer_colour(index: PlaneIndex) -> i64 {
    1 + index.0.rem_euclid(6)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn layer_names_are_those_release_12_allows() {
        for index in [0, 12, -3, 123_456, i64::MIN, i64::MAX] {
            let name = layer_name(PlaneIndex(index));
            assert!(name.len() <= 31, "{name}");
            assert!(name.chars().all(|c| c.is_ascii_alphanumeric() || c == '_'), "{name}");
        }
        assert_eq!(layer_name(PlaneIndex(12)), "PLANE_0012");
        assert_eq!(layer_name(PlaneIndex(-3)), "PLANE_N003");
    }
}
