//! The points of a polyline in a DXF drawing.
//!
//! A drawing is a list of pairs of lines: a group code and a value (Autodesk, DXF reference). The
//! reader uses the section ENTITIES, and in it the entities that can be a guide.

use super::Placed;
use super::chain::{self, Line};
use crate::Place;
use crate::dxf_groups::{insertion_unit, unit_of_insertion};
use crate::error::Problem;
use transect_geometry::{LengthUnit, Point3};

// Bits of group 70 of a polyline, by the DXF reference.
const CLOSED: i64 = 1;
const SPLINE_FIT: i64 = 4;
/// Vertices have heights of their own.
const SPATIAL: i64 = 8;
/// A mesh of rows and columns, or of faces.
const MESH: i64 = 16 | 64;

/// A group: its code, its value and the line of the value.
#[derive(Debug, Clone, Copy)]
struct Group<'a> {
    code: i32,
    value: &'a str,
    line: usize,
}

impl Group<'_> {
    fn number(&self) -> Result<f64, Problem> {
        let problem = || format!("{:?} is no number", self.value);
        self.value.parse().map_err(|_| Problem::at(Place::Line(self.line), problem()))
    }
}

/// An entity: its name and groups.
struct Entity<'a> {
    name: &'a str,
    line: usize,
    groups: Vec<Group<'a>>,
}

impl Entity<'_> {
    /// The first number of a code.
    fn number(&self, code: i32) -> Result<Option<f64>, Problem> {
        self.groups.iter().find(|g| g.code == code).map(Group::number).transpose()
    }

    /// The bits of group 70.
    fn flags(&self) -> Result<i64, Problem> {
        Ok(self.number(70)?.unwrap_or(0.0) as i64)
    }

    /// The point whose coordinates have these codes; a missing third one is 0.
    fn point(&self, [x, y, z]: [i32; 3]) -> Result<Placed, Problem> {
        let at = Place::Line(self.line);
        let missing = |code| format!("{} has no group {code}", self.name);
        let needed =
            |code| self.number(code)?.ok_or_else(|| Problem::at(at.clone(), missing(code)));
        let z = self.number(z)?.unwrap_or(0.0);
        Ok(Placed { point: Point3::new(needed(x)?, needed(y)?, z), at })
    }

    /// Refuses closed, curved and turned entities.
    fn check(&self) -> Result<(), Problem> {
        let refuse = |what: &str| {
            Err(Problem::at(Place::Line(self.line), format!("the {} {what}", self.name)))
        };
        if self.name != "VERTEX" && self.flags()? & CLOSED != 0 {
            return refuse("is closed; a guide has two ends");
        }
        if self.name == "POLYLINE" && self.flags()? & SPLINE_FIT != 0 {
            return refuse(
                "is fitted by a spline: it lists control points and fitted points in one; draw it \
                 as straight pieces, or undo the fit (PEDIT, Decurve)",
            );
        }
        if self.name == "POLYLINE" && self.flags()? & MESH != 0 {
            return refuse("is a mesh; draw the guide as one polyline of straight pieces");
        }
        for group in self.groups.iter().filter(|g| g.code == 42) {
            if group.number()? != 0.0 {
                return refuse("has arcs (bulges); draw it as straight pieces");
            }
        }
        let extrusion = [self.number(210)?, self.number(220)?, self.number(230)?];
        if extrusion.iter().zip([0.0, 0.0, 1.0]).any(|(e, up)| e.is_some_and(|e| e != up)) {
            return refuse("is drawn in a turned coordinate system");
        }
        Ok(())
    }
}

/// A heavy polyline whose vertices are being read, and the height of all of them if it is flat.
struct Heavy {
    vertices: Vec<Placed>,
    elevation: Option<f64>,
}

impl Heavy {
    /// The polyline that an entity begins, without vertices.
    fn begin(entity: &Entity<'_>) -> Result<Self, Problem> {
        let is_flat = entity.flags()? & SPATIAL == 0;
        let elevation = entity.number(30)?.filter(|z| is_flat && *z != 0.0);
        Ok(Self { vertices: Vec::new(), elevation })
    }
}

/// The points of the guide, and a note if its lines differ in direction.
pub(super) fn points(
    text: &str,
    unit: LengthUnit,
) -> Result<(Vec<Placed>, Option<String>), Problem> {
    if text.starts_with("AutoCAD Binary DXF") {
        return Err(Problem::damaged("a binary DXF; save it as text"));
    }
    let groups = groups(text)?;
    check_unit(&groups, unit)?;
    let mut found = Found::default();
    for entity in entities(&groups) {
        found.take(&entity)?;
    }
    found.only_curve()
}

/// What a drawing holds.
#[derive(Default)]
struct Found {
    /// The polylines.
    curves: Vec<Vec<Placed>>,
    /// The separate lines.
    lines: Vec<Line>,
    /// A `POLYLINE` that has not ended yet.
    heavy: Option<Heavy>,
    /// Number of inserted blocks, which are not read.
    blocks: usize,
}

impl Found {
    /// Takes the next entity of the drawing.
    fn take(&mut self, entity: &Entity<'_>) -> Result<(), Problem> {
        match entity.name {
            "LWPOLYLINE" => {
                entity.check()?;
                self.curves.push(light(entity)?);
            }
            "POLYLINE" => self.begin_heavy(entity)?,
            "VERTEX" => {
                entity.check()?;
                if let Some(heavy) = &mut self.heavy {
                    let mut vertex = entity.point([10, 20, 30])?;
                    vertex.point.z = heavy.elevation.unwrap_or(vertex.point.z);
                    heavy.vertices.push(vertex);
                }
            }
            "SEQEND" => self.curves.extend(self.heavy.take().map(|heavy| heavy.vertices)),
            "LINE" => {
                self.lines.push([entity.point([10, 20, 30])?, entity.point([11, 21, 31])?]);
            }
            "ARC" | "SPLINE" | "ELLIPSE" => {
                let problem = format!(
                    "{} is no guide, and may be a part of one; draw the guide as one polyline of \
                     straight pieces, in a drawing of its own",
                    entity.name
                );
                return Err(Problem::at(Place::Line(entity.line), problem));
            }
            "INSERT" => self.blocks += 1,
            _ => (),
        }
        Ok(())
    }

    fn begin_heavy(&mut self, entity: &Entity<'_>) -> Result<(), Problem> {
        entity.check()?;
        if self.heavy.is_some() {
            let problem = "a POLYLINE begins before the one before it has ended; save the drawing \
                           again";
            return Err(Problem::at(Place::Line(entity.line), problem));
        }
        self.heavy = Some(Heavy::begin(entity)?);
        Ok(())
    }

    /// The points of the only curve, and a note if its lines differ in direction.
    fn only_curve(mut self) -> Result<(Vec<Placed>, Option<String>), Problem> {
        if self.heavy.is_some() {
            return Err(Problem::damaged("a POLYLINE has no SEQEND: the file is cut off"));
        }
        let mut chains = chain::join(&self.lines);
        let count = self.curves.len() + chains.len();
        if count == 1 {
            return Ok(match chains.pop() {
                Some(chain) => {
                    let note = chain.note();
                    (chain.points, note)
                }
                None => (self.curves.pop().unwrap_or_default(), None),
            });
        }
        let mut problem = format!("{count} separate polylines or lines; a guide is one");
        if self.blocks > 0 {
            problem += &format!(". {} blocks (INSERT) are not read: explode them", self.blocks);
        }
        Err(Problem::damaged(problem))
    }
}

/// Refuses drawings in another unit than the model's.
fn check_unit(groups: &[Group<'_>], unit: LengthUnit) -> Result<(), Problem> {
    let header = groups.iter().position(|g| g.code == 9 && g.value == "$INSUNITS");
    let Some(stated) = header.and_then(|at| groups.get(at + 1)) else { return Ok(()) };
    let number = stated.number()?;
    // 0 is a drawing without a unit.
    if number == 0.0 || number == f64::from(insertion_unit(unit)) {
        return Ok(());
    }
    let named = unit_of_insertion(number).map_or(String::new(), |unit| format!(" ({unit})"));
    let problem = format!(
        "the drawing's unit, $INSUNITS, is {number}{named}, but the scan's is {unit}; lengths are \
         never converted on reading: scale the drawing, or set $INSUNITS to {} if its coordinates \
         are in {unit}",
        insertion_unit(unit)
    );
    Err(Problem::at(Place::Line(stated.line), problem))
}

/// The points of a light polyline, at its elevation.
fn light(entity: &Entity<'_>) -> Result<Vec<Placed>, Problem> {
    let z = entity.number(38)?.unwrap_or(0.0);
    let mut points: Vec<Placed> = Vec::new();
    let mut open = false;
    for group in &entity.groups {
        match (group.code, points.last_mut()) {
            (10, _) => {
                let x = group.number()?;
                let point = Point3::new(x, f64::NAN, z);
                points.push(Placed { point, at: Place::Line(group.line) });
                open = true;
            }
            (20, Some(placed)) if open => {
                placed.point.y = group.number()?;
                open = false;
            }
            _ => (),
        }
    }
    Ok(points)
}

fn groups(text: &str) -> Result<Vec<Group<'_>>, Problem> {
    let mut groups = Vec::new();
    let mut lines = (1..).zip(text.lines());
    while let Some((number, code)) = lines.next() {
        if code.trim().is_empty() && lines.clone().all(|(_, rest)| rest.trim().is_empty()) {
            break;
        }
        let code = code.trim().parse();
        let problem = |text: &str| Problem::at(Place::Line(number), text);
        let code = code.map_err(|_| problem("a group code was expected"))?;
        let cut = || problem("the file ends within a group");
        let (line, value) = lines.next().ok_or_else(cut)?;
        groups.push(Group { code, value: value.trim(), line });
    }
    Ok(groups)
}

/// The entities of the section ENTITIES.
fn entities<'a>(groups: &[Group<'a>]) -> Vec<Entity<'a>> {
    let mut entities: Vec<Entity<'a>> = Vec::new();
    let mut inside = false;
    for group in groups {
        match (group.code, group.value) {
            (2, "ENTITIES") if !inside => inside = true,
            (0, "ENDSEC") => inside = false,
            (0, name) if inside => {
                entities.push(Entity { name, line: group.line, groups: Vec::new() });
            }
            _ if inside => {
                if let Some(entity) = entities.last_mut() {
                    entity.groups.push(*group);
                }
            }
            _ => (),
        }
    }
    entities
}
