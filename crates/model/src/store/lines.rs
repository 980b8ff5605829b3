//! The exchange form of a store: lines of JSON, which do not depend on the database's format.
//!
//! ```json
//! {"store":{"format":"transect-model","version":4,"unit":"m","planes":{"guide":{"straight":{"direction":[0.0,0.0,1.0]}},
//!     "offset":0.0,"interval":0.5},"options":"…","tool":"transect 0.1.0"}}
//! {"view":{"id":"front","name":"front","sensor":"…","source":"front.npy","source_hash":"…",
//!     "world_from_sensor":{"rotation":[0.0,0.0,0.0,1.0],"translation":[0.0,0.0,0.0]},"sigma":0.001}}
//! {"copy":{"view":"front","bytes":"05a0…"}}
//! {"partial":{"plane":3,"view":"front","curves":[{"closed":true,"nodes":[[0.0,0.0,0.001,0.01,1.0,1,0.03,0.2,[1.0,0.0,0.0]],…]}]}}
//! {"fused":{"plane":3,"curves":[…]}}
//! {"end":{"views":1,"planes":1,"hash":"…"}}
//! ```
//!
//! A curved guide is `{"curved":{"kind":…,"points":[[x,y,z],…]}}`; its kind is `"spline"` or
//! `{"polyline":RADIUS}`, with the radius `null` if corners have no largest radius.
//!
//! Each object is one line (broken here to fit the page). First the store, then its views in order
//! of ids, each with the coarse copy of its image if there is one, in hexadecimal digits. Then,
//! plane by plane in order of station, the partial curves of each view in order of ids and the
//! fused curves. Then the end. A rotation is a quaternion `[i, j, k, w]`. A node is
//! `[x, y, sigma, footprint, weight, views, correlation, tan_incidence, normal]`: plane
//! coordinates, standard deviation and sample spacing in the model's unit, weight, and number of
//! views (0 on bridged ground). `correlation` is the length over which errors are shared; tangent
//! and normal of the surface (in plane coordinates) are zeros if unknown. `"bridged"` lists the
//! nodes whose following unit no view saw, if there are any. `"ends"` says why an open curve begins
//! and ends: `"missing_pixel"`, `"range_jump"`, `"image_border"`, or null. The last line's hash
//! is FNV-1a (64 bits, hexadecimal) of all bytes before that line, newlines included.
//!
//! Numbers have the fewest digits that read back as the same number, so an imported store exports
//! as the same bytes.

use super::copy::ViewCopy;
use super::view::{StoreHeader, ViewDescription};
use super::view_id::ViewId;
use serde::{Deserialize, Serialize};
use transect_geometry::{Curve, EndReason, LengthUnit, Node, PlaneFamily, Point2, StoredNode};

/// Value of the key `format` in the first line.
pub(super) const FORMAT: &str = "transect-model";
/// The bytes that every export begins with.
pub const LINES_START: &[u8] = br#"{"store":{"format":"transect-model","#;
/// Version of this form.
pub const LINES_VERSION: u32 = 4;
/// The oldest version that is still read. It has no copies.
pub(super) const OLDEST_LINES: u32 = 3;

#[derive(Debug, Serialize, Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub(super) enum Line {
    Store(StoreLine),
    View(ViewDescription),
    Copy(CopyLine),
    Partial(PartialLine),
    Fused(FusedLine),
    End(EndLine),
}

#[derive(Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct StoreLine {
    pub format: String,
    pub version: u32,
    pub unit: LengthUnit,
    pub planes: PlaneFamily,
    pub options: String,
    pub tool: String,
}

#[derive(Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct CopyLine {
    pub view: ViewId,
    /// Two hexadecimal digits for every byte.
    bytes: String,
}

impl CopyLine {
    pub fn new(view: ViewId, copy: &ViewCopy) -> Self {
        Self { view, bytes: copy.0.iter().map(|byte| format!("{byte:02x}")).collect() }
    }

    /// The copy; `None` if the text has other characters, or an odd number of them.
    pub fn copy(&self) -> Option<ViewCopy> {
        let (pairs, odd) = self.bytes.as_bytes().as_chunks::<2>();
        let digit = |c: u8| char::from(c).to_digit(16);
        let byte = |[high, low]: &[u8; 2]| u8::try_from(16 * digit(*high)? + digit(*low)?).ok();
        let bytes = pairs.iter().map(byte).collect::<Option<_>>()?;
        odd.is_empty().then_some(ViewCopy(bytes))
    }
}

#[derive(Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct PartialLine {
    pub plane: i64,
    pub view: ViewId,
    pub curves: Vec<CurveText>,
}

#[derive(Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct FusedLine {
    pub plane: i64,
    pub curves: Vec<CurveText>,
}

#[derive(Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct EndLine {
    pub views: u64,
    pub planes: u64,
    pub hash: String,
}

#[derive(Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct CurveText {
    closed: bool,
    nodes: Vec<NodeText>,
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    bridged: Vec<u32>,
    #[serde(default, skip_serializing_if = "unknown")]
    ends: [Option<EndReason>; 2],
}

fn unknown(ends: &[Option<EndReason>; 2]) -> bool {
    *ends == [None; 2]
}

/// x, y, sigma, footprint, weight, views, correlation, tangent of the incidence, normal.
type NodeText = (f64, f64, f32, f32, f32, u32, f32, f32, [f32; 3]);

impl From<&StoreHeader> for StoreLine {
    fn from(header: &StoreHeader) -> Self {
        let StoreHeader { unit, planes, options, tool } = header.clone();
        Self { format: FORMAT.to_owned(), version: LINES_VERSION, unit, planes, options, tool }
    }
}

impl From<StoreLine> for StoreHeader {
    fn from(line: StoreLine) -> Self {
        let StoreLine { unit, planes, options, tool, .. } = line;
        Self { unit, planes, options, tool }
    }
}

impl From<&Curve> for CurveText {
    fn from(curve: &Curve) -> Self {
        let node = |n: &Node| {
            let StoredNode { position, sigma, footprint, weight, views, .. } = (*n).into();
            let StoredNode { correlation, tan_incidence, normal, .. } = (*n).into();
            let (x, y, normal) = (position.x, position.y, normal.into());
            (x, y, sigma, footprint, weight, views, correlation, tan_incidence, normal)
        };
        let numbered = (0_u32..).zip(curve.nodes());
        Self {
            closed: curve.is_closed(),
            nodes: curve.nodes().iter().map(node).collect(),
            bridged: numbered.filter(|(_, n)| n.bridged).map(|(k, _)| k).collect(),
            ends: curve.ends(),
        }
    }
}

impl CurveText {
    /// The curve, or a sentence about its problem.
    pub(super) fn curve(self) -> Result<Curve, String> {
        let node = |text: NodeText| {
            let (x, y, sigma, footprint, weight, views, correlation, tan_incidence, normal) = text;
            let (position, normal, bridged) = (Point2::new(x, y), normal.into(), false);
            Node::from(StoredNode {
                position,
                sigma,
                footprint,
                weight,
                views,
                correlation,
                tan_incidence,
                normal,
                bridged,
            })
        };
        let mut nodes: Vec<Node> = self.nodes.into_iter().map(node).collect();
        for k in self.bridged {
            let count = nodes.len();
            let node = nodes.get_mut(k as usize);
            let missing = || format!("\"bridged\" names node {k}, but the curve has {count} nodes");
            node.ok_or_else(missing)?.bridged = true;
        }
        let curve = Curve::new(nodes, self.closed).map_err(|error| error.to_string())?;
        Ok(curve.with_ends(self.ends))
    }
}
