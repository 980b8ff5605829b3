//! Segments between mesh edges, linked into chains.

/// A mesh edge: its two vertices, the smaller index first.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub struct EdgeKey(u32, u32);

impl EdgeKey {
    /// The edge between two vertices, whichever comes first.
    pub fn new(a: u32, b: u32) -> Self {
        Self(a.min(b), a.max(b))
    }

    /// The smaller vertex index.
    pub fn low(&self) -> u32 {
        self.0
    }

    /// The larger vertex index.
    pub fn high(&self) -> u32 {
        self.1
    }
}

/// One triangle's part of a section, between two of its edges.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub struct Segment {
    /// The edge on which it starts.
    pub from: EdgeKey,
    /// The edge on which it ends.
    pub to: EdgeKey,
}

/// Edges in the order in which a curve crosses them; a closed chain does not repeat the first.
#[derive(Debug)]
pub struct Chain {
    /// The crossed edges.
    pub edges: Vec<EdgeKey>,
    /// Whether the last is followed by the first.
    pub closed: bool,
}

/// Links segments end to start. Open chains come first; the order depends on vertex numbers alone.
///
/// At an edge with more than two faces, the first unused segment continues the chain. So every
/// segment is in exactly one chain, for any mesh.
pub fn link(mut segments: Vec<Segment>) -> Vec<Chain> {
    segments.sort_unstable();
    let mut ends: Vec<_> = segments.iter().map(|s| s.to).collect();
    ends.sort_unstable();
    let mut pool = Pool { used: vec![false; segments.len()], segments };
    let count = pool.segments.len();
    let is_head = |s: &Segment| ends.binary_search(&s.from).is_err();
    let heads: Vec<_> = (0..count).filter(|&i| is_head(&pool.segments[i])).collect();
    let mut chains = Vec::new();
    for start in heads.into_iter().chain(0..count) {
        chains.extend(pool.take_chain(start));
    }
    chains
}

struct Pool {
    /// Sorted by their start.
    segments: Vec<Segment>,
    used: Vec<bool>,
}

impl Pool {
    /// The chain that begins with a segment; `None` if it is in use already.
    fn take_chain(&mut self, start: usize) -> Option<Chain> {
        if self.used[start] {
            return None;
        }
        let first = self.segments[start].from;
        let mut edges = vec![first];
        let mut next = Some(start);
        while let Some(current) = next {
            self.used[current] = true;
            let to = self.segments[current].to;
            if to == first {
                return Some(Chain { edges, closed: true });
            }
            edges.push(to);
            next = self.unused_from(to);
        }
        Some(Chain { edges, closed: false })
    }

    fn unused_from(&self, edge: EdgeKey) -> Option<usize> {
        let begin = self.segments.partition_point(|s| s.from < edge);
        let mut same = self.segments[begin..].iter().take_while(|s| s.from == edge);
        let count = same.by_ref().count();
        (begin..begin + count).find(|&i| !self.used[i])
    }
}
