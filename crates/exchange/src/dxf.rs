//! Drawing exchange: DXF of AutoCAD release 12 (AC1009), the version every CAD program reads.
//!
//! One layer per plane (`PLANE_0012`, `PLANE_N003` below zero), one POLYLINE per curve. Numbers
//! are in the model's length unit with all their digits. Release 12 has no place for a unit. The
//! unit is written as `$INSUNITS`, which newer programs read, and as a comment in the first line.
//! Coordinates are never scaled or moved.

use crate::dxf_groups::{Groups, layer_colour, layer_name, unit_values};
use std::io::{self, Write};
use transect_geometry::{Curve, PlaneFrame, PlaneIndex, Point2, Point3};
use transect_model::Model;

/// The coordinates in which curves are drawn.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum DxfFrame {
    /// Flat polylines in plane coordinates, at an elevation that is the plane's station: all
    /// sections lie above each other on the drawing's XY plane.
    Plane,
    /// Space polylines in world coordinates.
    #[default]
    World,
}

/// The groups that do not depend on the model.
const TEMPLATE: &str = include_str!("drawing.txt");

/// Writes a model's curves.
///
/// # Errors
/// An error of `out`.
pub fn write_dxf(model: &Model, frame: DxfFrame, out: &mut dyn Write) -> io::Result<()> {
    let coordinates = match frame {
        DxfFrame::Plane => "plane coordinates, elevation = station",
        DxfFrame::World => "world coordinates",
    };
    let mut values = unit_values(model.unit()).to_vec();
    values.push(("coordinates", coordinates.to_owned()));
    values.push(("layer_count", format!("{}", 1 + model.sections().len())));
    let drawing = Drawing { model, frame };
    let mut groups = Groups { out };
    groups.template(TEMPLATE, &values, |groups, mark| match mark {
        "extents" => drawing.write_extents(groups),
        "layers" => model.sections().try_for_each(|(index, _)| write_layer(groups, index)),
        _ => drawing.write_polylines(groups),
    })
}

fn write_layer(groups: &mut Groups<'_>, index: PlaneIndex) -> io::Result<()> {
    groups.text(0, "LAYER")?;
    groups.text(2, &layer_name(index))?;
    groups.integer(70, 0)?;
    groups.integer(62, layer_colour(index))?;
    groups.text(6, "CONTINUOUS")
}

/// Flags of group 70 for polylines and their vertices.
const CLOSED: i64 = 1;
const IN_SPACE: i64 = 8;
const VERTEX_IN_SPACE: i64 = 32;

struct Drawing<'a> {
    model: &'a Model,
    frame: DxfFrame,
}

/// A plane, and its coordinate along the guide.
struct Placed {
    frame: PlaneFrame,
    station: f64,
}

impl Drawing<'_> {
    fn plane(&self, index: PlaneIndex) -> Placed {
        let planes = self.model.planes();
        Placed { frame: planes.frame(index), station: planes.station(index) }
    }

    fn drawn(&self, plane: &Placed, position: &Point2) -> Point3 {
        match self.frame {
            DxfFrame::Plane => Point3::new(position.x, position.y, plane.station),
            DxfFrame::World => plane.frame.world_from_plane(position),
        }
    }

    /// Corners of the box around everything drawn. An empty drawing has AutoCAD's inverted box.
    fn write_extents(&self, groups: &mut Groups<'_>) -> io::Result<()> {
        let (mut low, mut high) = (Point3::from([1e20; 3]), Point3::from([-1e20; 3]));
        for (index, section) in self.model.sections() {
            let plane = self.plane(index);
            for node in section.curves().flat_map(Curve::nodes) {
                let drawn = self.drawn(&plane, &node.position);
                (low, high) = (low.inf(&drawn), high.sup(&drawn));
            }
        }
        groups.text(9, "$EXTMIN")?;
        groups.point(&low)?;
        groups.text(9, "$EXTMAX")?;
        groups.point(&high)
    }

    fn write_polylines(&self, groups: &mut Groups<'_>) -> io::Result<()> {
        for (index, section) in self.model.sections() {
            let (plane, layer) = (self.plane(index), layer_name(index));
            for curve in section.curves() {
                self.write_polyline(groups, curve, &plane, &layer)?;
            }
        }
        Ok(())
    }

    fn write_polyline(
        &self,
        groups: &mut Groups<'_>,
        curve: &Curve,
        plane: &Placed,
        layer: &str,
    ) -> io::Result<()> {
        let (in_space, elevation, vertex_flag) = match self.frame {
            DxfFrame::Plane => (0, plane.station, 0),
            DxfFrame::World => (IN_SPACE, 0.0, VERTEX_IN_SPACE),
        };
        groups.text(0, "POLYLINE")?;
        groups.text(8, layer)?;
        groups.integer(66, 1)?;
        groups.point(&Point3::new(0.0, 0.0, elevation))?;
        groups.integer(70, in_space + if curve.is_closed() { CLOSED } else { 0 })?;
        for node in curve.nodes() {
            groups.text(0, "VERTEX")?;
            groups.text(8, layer)?;
            groups.point(&self.drawn(plane, &node.position))?;
            groups.integer(70, vertex_flag)?;
        }
        groups.text(0, "SEQEND")?;
        groups.text(8, layer)
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
