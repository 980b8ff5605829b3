//! SPLINE entities, which drawings have from AutoCAD release 13 on: DXF of release 2000 (AC1015).
//!
//! Later releases refuse a drawing of entities alone: each table is there, every object has a handle
//! and an owner, and the two blocks of model and paper space with their records (Autodesk, DXF reference).

use super::{ModelSplines, PlaneSplines};
use crate::dxf::{insertion_unit, layer_name, measurement};
use std::io::{self, Write};
use transect_geometry::CubicSpline;

/// Handles of what every drawing has; layers and entities are numbered from [`FIRST_FREE`] on.
const MODEL_SPACE: u64 = 0x1F;
const PAPER_SPACE: u64 = 0x1B;
const TABLES: [&str; 9] =
    ["VPORT", "LTYPE", "LAYER", "STYLE", "VIEW", "UCS", "APPID", "DIMSTYLE", "BLOCK_RECORD"];
const ROOT: u64 = 0xC;
const GROUPS: u64 = 0xD;
const FIRST_FREE: u64 = 0x100;

/// Layer colours (AutoCAD colour index), so that neighbouring planes differ.
const COLOURS: i64 = 6;

const CLOSED: i64 = 1;
const PLANAR: i64 = 8;

struct Drawing<'a> {
    out: &'a mut dyn Write,
    next: u64,
}

impl ModelSplines {
    /// Writes a drawing of all splines in world coordinates, one layer per plane.
    ///
    /// # Errors
    /// What `out` says.
    pub fn write_dxf(&self, out: &mut dyn Write) -> io::Result<()> {
        let mut dxf = Drawing { out, next: FIRST_FREE };
        let pieces = self.curves().map(|c| c.pieces.len() as u64).sum::<u64>();
        // Layers and entities have one handle each; the next free one is written first.
        let free = FIRST_FREE + self.planes.len() as u64 + pieces;
        dxf.text(999, &format!("Transect splines; lengths in {}; world coordinates", self.unit))?;
        dxf.header(self, free)?;
        dxf.section("CLASSES")?;
        dxf.text(0, "ENDSEC")?;
        dxf.tables(&self.planes)?;
        dxf.blocks()?;
        dxf.section("ENTITIES")?;
        for plane in &self.planes {
            for curve in &plane.curves {
                let ring = curve.closed && curve.pieces.len() == 1;
                for piece in &curve.pieces {
                    dxf.spline(plane, piece, ring)?;
                }
            }
        }
        dxf.text(0, "ENDSEC")?;
        dxf.objects()?;
        dxf.text(0, "EOF")
    }
}

impl Drawing<'_> {
    fn text(&mut self, group: u16, value: &str) -> io::Result<()> {
        write!(self.out, "{group}\n{value}\n")
    }

    fn texts(&mut self, groups: &[(u16, &str)]) -> io::Result<()> {
        groups.iter().try_for_each(|(group, value)| self.text(*group, value))
    }

    fn integer(&mut self, group: u16, value: i64) -> io::Result<()> {
        write!(self.out, "{group}\n{value}\n")
    }

    fn handle(&mut self, group: u16, handle: u64) -> io::Result<()> {
        write!(self.out, "{group}\n{handle:X}\n")
    }

    fn new_handle(&mut self) -> io::Result<()> {
        self.next += 1;
        self.handle(5, self.next - 1)
    }

    /// As in the drawing of polylines: never an exponent, always a point.
    fn number(&mut self, group: u16, value: f64) -> io::Result<()> {
        let point = if value.fract() == 0.0 { ".0" } else { "" };
        write!(self.out, "{group}\n{value}{point}\n")
    }

    fn section(&mut self, name: &str) -> io::Result<()> {
        self.texts(&[(0, "SECTION"), (2, name)])
    }

    fn header(&mut self, splines: &ModelSplines, free: u64) -> io::Result<()> {
        self.section("HEADER")?;
        self.texts(&[(9, "$ACADVER"), (1, "AC1015"), (9, "$HANDSEED")])?;
        self.handle(5, free)?;
        self.text(9, "$INSUNITS")?;
        self.integer(70, insertion_unit(splines.unit))?;
        self.text(9, "$MEASUREMENT")?;
        self.integer(70, measurement(splines.unit))?;
        self.text(0, "ENDSEC")
    }

    fn tables(&mut self, planes: &[PlaneSplines]) -> io::Result<()> {
        self.section("TABLES")?;
        for (number, name) in (1..).zip(TABLES) {
            self.texts(&[(0, "TABLE"), (2, name)])?;
            self.handle(5, number)?;
            self.texts(&[(330, "0"), (100, "AcDbSymbolTable")])?;
            match name {
                "LTYPE" => self.line_types(number)?,
                "LAYER" => self.layers(number, planes)?,
                "STYLE" => self.style(number)?,
                "APPID" => {
                    self.integer(70, 1)?;
                    self.record("APPID", 0x14, number, "AcDbRegAppTableRecord", "ACAD")?;
                    self.integer(70, 0)?;
                }
                "DIMSTYLE" => {
                    self.integer(70, 0)?;
                    self.text(100, "AcDbDimStyleTable")?;
                }
                "BLOCK_RECORD" => {
                    self.integer(70, 2)?;
                    for (handle, space) in SPACES {
                        self.record(name, handle, number, "AcDbBlockTableRecord", space)?;
                    }
                }
                _ => self.integer(70, 0)?,
            }
            self.text(0, "ENDTAB")?;
        }
        self.text(0, "ENDSEC")
    }

    /// The beginning of a table's entry.
    fn record(
        &mut self,
        kind: &str,
        handle: u64,
        table: u64,
        class: &str,
        name: &str,
    ) -> io::Result<()> {
        self.text(0, kind)?;
        self.handle(5, handle)?;
        self.handle(330, table)?;
        self.texts(&[(100, "AcDbSymbolTableRecord"), (100, class), (2, name)])
    }

    fn line_types(&mut self, table: u64) -> io::Result<()> {
        self.integer(70, 3)?;
        for (handle, name) in [(0x10, "ByBlock"), (0x11, "ByLayer"), (0x12, "Continuous")] {
            self.record("LTYPE", handle, table, "AcDbLinetypeTableRecord", name)?;
            self.texts(&[(70, "0"), (3, ""), (72, "65"), (73, "0"), (40, "0.0")])?;
        }
        Ok(())
    }

    fn layers(&mut self, table: u64, planes: &[PlaneSplines]) -> io::Result<()> {
        self.integer(70, 1 + planes.len() as i64)?;
        self.record("LAYER", 0x13, table, "AcDbLayerTableRecord", "0")?;
        self.texts(&[(70, "0"), (62, "7"), (6, "Continuous")])?;
        for PlaneSplines { index, .. } in planes {
            let (handle, colour) = (self.next, 1 + index.0.rem_euclid(COLOURS));
            self.next += 1;
            self.record("LAYER", handle, table, "AcDbLayerTableRecord", &layer_name(*index))?;
            self.integer(70, 0)?;
            self.integer(62, colour)?;
            self.text(6, "Continuous")?;
        }
        Ok(())
    }

    fn style(&mut self, table: u64) -> io::Result<()> {
        self.integer(70, 1)?;
        self.record("STYLE", 0x15, table, "AcDbTextStyleTableRecord", "Standard")?;
        self.texts(&[(70, "0"), (40, "0.0"), (41, "1.0"), (50, "0.0"), (71, "0"), (42, "2.5")])?;
        self.texts(&[(3, "txt"), (4, "")])
    }

    fn blocks(&mut self) -> io::Result<()> {
        self.section("BLOCKS")?;
        for (handle, name) in SPACES {
            for (kind, class, own) in
                [("BLOCK", "AcDbBlockBegin", handle + 1), ("ENDBLK", "AcDbBlockEnd", handle + 2)]
            {
                self.text(0, kind)?;
                self.handle(5, own)?;
                self.handle(330, handle)?;
                self.texts(&[(100, "AcDbEntity"), (8, "0"), (100, class)])?;
                if kind == "BLOCK" {
                    self.texts(&[(2, name), (70, "0"), (10, "0.0"), (20, "0.0"), (30, "0.0")])?;
                    self.texts(&[(3, name), (1, "")])?;
                }
            }
        }
        self.text(0, "ENDSEC")
    }

    fn spline(&mut self, plane: &PlaneSplines, piece: &CubicSpline, ring: bool) -> io::Result<()> {
        self.text(0, "SPLINE")?;
        self.new_handle()?;
        self.handle(330, MODEL_SPACE)?;
        self.texts(&[(100, "AcDbEntity"), (8, &layer_name(plane.index)), (100, "AcDbSpline")])?;
        let normal = plane.frame.normal();
        self.number(210, normal.x)?;
        self.number(220, normal.y)?;
        self.number(230, normal.z)?;
        self.integer(70, PLANAR + if ring { CLOSED } else { 0 })?;
        self.integer(71, 3)?;
        self.integer(72, piece.knots().len() as i64)?;
        self.integer(73, piece.controls().len() as i64)?;
        self.integer(74, 0)?;
        piece.knots().iter().try_for_each(|knot| self.number(40, *knot))?;
        for control in piece.controls() {
            let p = plane.frame.world_from_plane(control);
            self.number(10, p.x)?;
            self.number(20, p.y)?;
            self.number(30, p.z)?;
        }
        Ok(())
    }

    fn objects(&mut self) -> io::Result<()> {
        self.section("OBJECTS")?;
        self.text(0, "DICTIONARY")?;
        self.handle(5, ROOT)?;
        self.texts(&[(330, "0"), (100, "AcDbDictionary"), (281, "1"), (3, "ACAD_GROUP")])?;
        self.handle(350, GROUPS)?;
        self.text(0, "DICTIONARY")?;
        self.handle(5, GROUPS)?;
        self.handle(330, ROOT)?;
        self.texts(&[(100, "AcDbDictionary"), (281, "1"), (0, "ENDSEC")])
    }
}

/// Handles and names of model and paper space; the two handles behind each are its block's.
const SPACES: [(u64, &str); 2] = [(MODEL_SPACE, "*Model_Space"), (PAPER_SPACE, "*Paper_Space")];
