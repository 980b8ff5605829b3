//! Drawing exchange: DXF of AutoCAD release 12 (AC1009), the version every CAD program reads.
//!
//! One layer per plane (`PLANE_0012`, `PLANE_N003` below zero), one POLYLINE per curve. Numbers are
//! in the model's length unit with all their digits. Release 12 has no place for a unit: it is
//! written as `$INSUNITS`, which newer programs honour, and as a comment in the first line.
//! Coordinates are never scaled or moved.

use std::io::{self, Write};
use transect_geometry::{Curve, LengthUnit, PlaneFrame, PlaneIndex, Point3};
use transect_model::Model;

/// In which coordinates curves are drawn.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum DxfFrame {
    /// Flat polylines in plane coordinates, at an elevation that is the plane's station: all
    /// sections lie above each other on the drawing's XY plane.
    Plane,
    /// Space polylines in world coordinates.
    #[default]
    World,
}

/// Writes a model's curves.
///
/// # Errors
/// What `out` says.
pub fn write_dxf(model: &Model, frame: DxfFrame, out: &mut dyn Write) -> io::Result<()> {
    let mut dxf = Dxf { out, frame };
    let coordinates = match frame {
        DxfFrame::Plane => "plane coordinates, elevation = station",
        DxfFrame::World => "world coordinates",
    };
    dxf.text(999, &format!("Transect sections; lengths in {}; {coordinates}", model.unit()))?;
    dxf.header(model)?;
    dxf.tables(model)?;
    dxf.section("ENTITIES")?;
    for (index, section) in model.sections() {
        let (plane, station) = (model.planes().frame(index), model.planes().station(index));
        let layer = layer_name(index);
        for curve in section.curves() {
            dxf.polyline(curve, &plane, station, &layer)?;
        }
    }
    dxf.text(0, "ENDSEC")?;
    dxf.text(0, "EOF")
}

/// Letters, digits, `_`, at most 31 characters: what release 12 allows.
pub(crate) fn layer_name(index: PlaneIndex) -> String {
    let sign = if index.0 < 0 { "N" } else { "" };
    let digits = if index.0 < 0 { 3 } else { 4 };
    format!("PLANE_{sign}{:0digits$}", index.0.unsigned_abs())
}

/// The number `$INSUNITS` has for a unit.
pub(crate) fn insertion_unit(unit: LengthUnit) -> i64 {
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

/// `$MEASUREMENT`: 0 for inches, 1 for the metric system.
pub(crate) fn measurement(unit: LengthUnit) -> i64 {
    i64::from(!matches!(unit, LengthUnit::Inch | LengthUnit::Foot))
}

struct Dxf<'a> {
    out: &'a mut dyn Write,
    frame: DxfFrame,
}

/// Layer colours (AutoCAD colour index), so that neighbouring planes differ: red, yellow, green,
/// cyan, blue, magenta.
const COLOURS: i64 = 6;
const CLOSED: i64 = 1;
const IN_SPACE: i64 = 8;
const VERTEX_IN_SPACE: i64 = 32;

impl Dxf<'_> {
    fn text(&mut self, group: u16, value: &str) -> io::Result<()> {
        write!(self.out, "{group}\n{value}\n")
    }

    fn integer(&mut self, group: u16, value: i64) -> io::Result<()> {
        write!(self.out, "{group}\n{value}\n")
    }

    /// The fewest digits that read back as the same number, never with an exponent, always with a
    /// point: there are readers that tell a real number by it.
    fn number(&mut self, group: u16, value: f64) -> io::Result<()> {
        let point = if value.fract() == 0.0 { ".0" } else { "" };
        write!(self.out, "{group}\n{value}{point}\n")
    }

    fn point(&mut self, [x, y, z]: [f64; 3]) -> io::Result<()> {
        self.number(10, x)?;
        self.number(20, y)?;
        self.number(30, z)
    }

    fn section(&mut self, name: &str) -> io::Result<()> {
        self.text(0, "SECTION")?;
        self.text(2, name)
    }

    fn header(&mut self, model: &Model) -> io::Result<()> {
        self.section("HEADER")?;
        self.text(9, "$ACADVER")?;
        self.text(1, "AC1009")?;
        self.text(9, "$INSUNITS")?;
        self.integer(70, insertion_unit(model.unit()))?;
        self.text(9, "$MEASUREMENT")?;
        self.integer(70, measurement(model.unit()))?;
        let (low, high) = self.extents(model);
        self.text(9, "$EXTMIN")?;
        self.point(low)?;
        self.text(9, "$EXTMAX")?;
        self.point(high)?;
        self.text(0, "ENDSEC")
    }

    /// Corners of the box around everything drawn; AutoCAD's inverted box for an empty drawing.
    fn extents(&self, model: &Model) -> ([f64; 3], [f64; 3]) {
        let (mut low, mut high) = ([1e20_f64; 3], [-1e20_f64; 3]);
        for (index, section) in model.sections() {
            let (plane, station) = (model.planes().frame(index), model.planes().station(index));
            for node in section.curves().flat_map(Curve::nodes) {
                let drawn = self.drawn(&plane, station, node.position);
                for ((low, high), c) in low.iter_mut().zip(&mut high).zip(drawn) {
                    (*low, *high) = (low.min(c), high.max(c));
                }
            }
        }
        (low, high)
    }

    fn drawn(
        &self,
        plane: &PlaneFrame,
        station: f64,
        position: transect_geometry::Point2,
    ) -> [f64; 3] {
        match self.frame {
            DxfFrame::Plane => [position.x, position.y, station],
            DxfFrame::World => {
                let p: Point3 = plane.world_from_plane(&position);
                [p.x, p.y, p.z]
            }
        }
    }

    fn tables(&mut self, model: &Model) -> io::Result<()> {
        self.section("TABLES")?;
        self.table("LTYPE", 1)?;
        self.text(0, "LTYPE")?;
        self.text(2, "CONTINUOUS")?;
        self.integer(70, 0)?;
        self.text(3, "Solid line")?;
        self.integer(72, 65)?;
        self.integer(73, 0)?;
        self.number(40, 0.0)?;
        self.text(0, "ENDTAB")?;
        self.table("LAYER", 1 + model.sections().len() as i64)?;
        self.layer("0", 7)?;
        for (index, _) in model.sections() {
            self.layer(&layer_name(index), 1 + index.0.rem_euclid(COLOURS))?;
        }
        self.text(0, "ENDTAB")?;
        self.text(0, "ENDSEC")
    }

    fn table(&mut self, name: &str, entries: i64) -> io::Result<()> {
        self.text(0, "TABLE")?;
        self.text(2, name)?;
        self.integer(70, entries)
    }

    fn layer(&mut self, name: &str, colour: i64) -> io::Result<()> {
        self.text(0, "LAYER")?;
        self.text(2, name)?;
        self.integer(70, 0)?;
        self.integer(62, colour)?;
        self.text(6, "CONTINUOUS")
    }

    fn polyline(
        &mut self,
        curve: &Curve,
        plane: &PlaneFrame,
        station: f64,
        layer: &str,
    ) -> io::Result<()> {
        let (in_space, elevation, vertex_flag) = match self.frame {
            DxfFrame::Plane => (0, station, 0),
            DxfFrame::World => (IN_SPACE, 0.0, VERTEX_IN_SPACE),
        };
        self.text(0, "POLYLINE")?;
        self.text(8, layer)?;
        self.integer(66, 1)?;
        self.point([0.0, 0.0, elevation])?;
        self.integer(70, in_space + if curve.is_closed() { CLOSED } else { 0 })?;
        for node in curve.nodes() {
            self.text(0, "VERTEX")?;
            self.text(8, layer)?;
            self.point(self.drawn(plane, station, node.position))?;
            self.integer(70, vertex_flag)?;
        }
        self.text(0, "SEQEND")?;
        self.text(8, layer)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_data::{curve, model, python_with};

    fn sample() -> Model {
        let square = [(0.0, 0.0), (2.0, 0.0), (2.0, 2.0), (0.0, 2.0)];
        let open = curve(&[(5e5, 5.4e6 + 1e-6), (5e5 + 1e-7, 5.4e6)], false);
        let planes = [(12, vec![curve(&square, true)]), (-3, vec![open])];
        model([0.0, 1.0, 0.0], &planes)
    }

    fn text(model: &Model, frame: DxfFrame) -> String {
        let mut out = Vec::new();
        write_dxf(model, frame, &mut out).unwrap();
        String::from_utf8(out).unwrap()
    }

    /// Group codes and values in order.
    fn groups(text: &str) -> Vec<(u16, String)> {
        let lines: Vec<_> = text.lines().collect();
        lines.chunks(2).map(|c| (c[0].parse().unwrap(), c[1].to_owned())).collect()
    }

    #[test]
    fn layers_units_and_coordinates_are_in_the_file() {
        let groups = groups(&text(&sample(), DxfFrame::Plane));
        let values = |code| {
            groups.iter().filter(move |g| g.0 == code).map(|g| g.1.as_str()).collect::<Vec<_>>()
        };
        assert!(values(999)[0].contains("lengths in mm"));
        assert_eq!(values(2)[5..], ["0", "PLANE_N003", "PLANE_0012", "ENTITIES"]);
        let insunits = groups.iter().position(|g| g.1 == "$INSUNITS").unwrap();
        assert_eq!(groups[insunits + 1], (70, "4".to_owned()));
        assert!(values(20).contains(&"5400000.000001"), "micrometres survive: {:?}", values(20));
        let kinds = values(0);
        assert_eq!(kinds.iter().filter(|k| **k == "POLYLINE").count(), 2);
        assert_eq!(kinds.iter().filter(|k| **k == "VERTEX").count(), 6);
        assert_eq!(kinds.last(), Some(&"EOF"));
        assert!(!values(10).iter().any(|v| v.contains('e')), "no exponents: {:?}", values(10));
    }

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

    #[test]
    fn dxf_passes_ezdxf_audit() {
        let Some(python) = python_with("ezdxf") else { return };
        let folder = tempfile::tempdir().unwrap();
        for (frame, model) in [
            (DxfFrame::Plane, sample()),
            (DxfFrame::World, sample()),
            (DxfFrame::World, model([0.0, 0.0, 1.0], &[])),
        ] {
            let path = folder.path().join("model.dxf");
            crate::write_file(&path, |out| write_dxf(&model, frame, out)).unwrap();
            let script = "import sys, ezdxf\n\
                doc = ezdxf.readfile(sys.argv[1])\n\
                audit = doc.audit()\n\
                print(doc.dxfversion, doc.header['$INSUNITS'], len(audit.errors), \
                len(audit.fixes), len(doc.modelspace()))\n\
                for e in audit.errors + audit.fixes: print(e.message)\n";
            let run = std::process::Command::new(&python).args(["-c", script]).arg(&path).output();
            let output = String::from_utf8(run.unwrap().stdout).unwrap();
            let curves = model.sections().map(|(_, s)| s.curves().len()).sum::<usize>();
            assert_eq!(output.trim(), format!("AC1009 4 0 0 {curves}"), "{frame:?}");
        }
    }
}
