//! Uncompressed zip archives, as `numpy.savez` writes them: just enough for `.npz`.
//!
//! ```text
//! member: PK\3\4 header (30 bytes), name, extra, data      one after the other
//! index:  PK\1\2 entry (46 bytes), name, extra, comment    one per member
//! end:    PK\5\6 record (22 bytes): where the index is
//! ```
//!
//! Members must be stored, not deflated (`numpy.savez`, not `savez_compressed`), and the archive
//! smaller than 4 GiB. Checksums are verified. Written archives carry a fixed date, so that the
//! same arrays give the same bytes. Reference: APPNOTE.TXT 6.3.10, sections 4.3.7 to 4.3.16.

use crate::error::Problem;
use std::io::{self, Write};

/// 1980-01-01, the earliest date the format can state.
const DATE: u16 = 0x21;

/// The bytes of a member called `name`; `None` if there is none.
pub(crate) fn member<'a>(archive: &'a [u8], name: &str) -> Result<Option<&'a [u8]>, Problem> {
    let end =
        find_end(archive).ok_or_else(|| Problem::damaged("not a .npz archive, or truncated"))?;
    let cut = || Problem::damaged("the archive's index is truncated");
    let mut at = u32_at(end, 16).ok_or_else(cut)? as usize;
    for _ in 0..u16_at(end, 10).ok_or_else(cut)? {
        let entry = archive.get(at..).filter(|e| e.starts_with(b"PK\x01\x02")).ok_or_else(cut)?;
        let field = |offset| u16_at(entry, offset).map(usize::from).ok_or_else(cut);
        let (name_length, extra, comment) = (field(28)?, field(30)?, field(32)?);
        if entry.get(46..46 + name_length) == Some(name.as_bytes()) {
            return stored(archive, entry, name).map(Some);
        }
        at += 46 + name_length + extra + comment;
    }
    Ok(None)
}

/// The end record. Only a comment of at most 65535 bytes may follow it.
fn find_end(archive: &[u8]) -> Option<&[u8]> {
    let from = archive.len().saturating_sub(22 + usize::from(u16::MAX));
    let tail = archive.get(from..)?;
    let at = tail.windows(4).rposition(|w| w == b"PK\x05\x06")?;
    tail.get(at..).filter(|end| end.len() >= 22)
}

fn stored<'a>(archive: &'a [u8], entry: &[u8], name: &str) -> Result<&'a [u8], Problem> {
    let cut = || Problem::damaged(format!("{name} is truncated"));
    if u16_at(entry, 10) != Some(0) {
        let advice = "write it with numpy.savez instead of savez_compressed";
        return Err(Problem::unsupported(format!("{name} is compressed; {advice}")));
    }
    let size = u32_at(entry, 20).ok_or_else(cut)? as usize;
    let local = archive.get(u32_at(entry, 42).ok_or_else(cut)? as usize..).ok_or_else(cut)?;
    // Name and extra fields may be longer here than in the index.
    let name_length = u16_at(local, 26).ok_or_else(cut)?;
    let extra = u16_at(local, 28).ok_or_else(cut)?;
    let start = 30 + usize::from(name_length) + usize::from(extra);
    let data = local.get(start..).and_then(|d| d.get(..size)).ok_or_else(cut)?;
    if Some(crc32fast::hash(data)) != u32_at(entry, 16) {
        return Err(Problem::damaged(format!("the checksum of {name} does not fit its content")));
    }
    Ok(data)
}

fn u16_at(bytes: &[u8], at: usize) -> Option<u16> {
    bytes.get(at..)?.first_chunk().map(|b| u16::from_le_bytes(*b))
}

fn u32_at(bytes: &[u8], at: usize) -> Option<u32> {
    bytes.get(at..)?.first_chunk().map(|b| u32::from_le_bytes(*b))
}

/// Writes an archive of stored members.
pub(crate) fn write(out: &mut dyn Write, members: &[(&str, Vec<u8>)]) -> io::Result<()> {
    let (mut index, mut at) = (Vec::new(), 0);
    for (name, data) in members {
        let fields = shared_fields(name, data)?;
        out.write_all(b"PK\x03\x04")?;
        out.write_all(&fields)?;
        out.write_all(name.as_bytes())?;
        out.write_all(data)?;
        index.extend_from_slice(b"PK\x01\x02\x14\x00");
        index.extend_from_slice(&fields);
        // No comment, disk 0, no attributes.
        index.extend_from_slice(&[0; 10]);
        index.extend_from_slice(&small(at)?.to_le_bytes());
        index.extend_from_slice(name.as_bytes());
        at += 30 + name.len() + data.len();
    }
    let count = u16::try_from(members.len()).map_err(io::Error::other)?.to_le_bytes();
    out.write_all(&index)?;
    out.write_all(b"PK\x05\x06\x00\x00\x00\x00")?;
    out.write_all(&[count, count].concat())?;
    out.write_all(&small(index.len())?.to_le_bytes())?;
    out.write_all(&small(at)?.to_le_bytes())?;
    out.write_all(&[0, 0])
}

/// The 26 bytes that a member's header and its index entry have in common.
fn shared_fields(name: &str, data: &[u8]) -> io::Result<Vec<u8>> {
    let size = small(data.len())?.to_le_bytes();
    let name_length = u16::try_from(name.len()).map_err(io::Error::other)?.to_le_bytes();
    let mut fields = vec![20, 0, 0, 0, 0, 0, 0, 0];
    fields.extend_from_slice(&DATE.to_le_bytes());
    fields.extend_from_slice(&crc32fast::hash(data).to_le_bytes());
    fields.extend_from_slice(&size);
    fields.extend_from_slice(&size);
    fields.extend_from_slice(&name_length);
    fields.extend_from_slice(&[0, 0]);
    Ok(fields)
}

fn small(length: usize) -> io::Result<u32> {
    u32::try_from(length).map_err(|_| io::Error::other("an .npz archive must stay under 4 GiB"))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn archive() -> Vec<u8> {
        let mut bytes = Vec::new();
        write(&mut bytes, &[("a.npy", b"123456789".to_vec()), ("b.npy", Vec::new())]).unwrap();
        bytes
    }

    #[test]
    fn members_come_back_and_missing_ones_are_none() {
        let bytes = archive();
        assert_eq!(member(&bytes, "a.npy").ok().flatten(), Some(&b"123456789"[..]));
        assert_eq!(member(&bytes, "b.npy").ok().flatten(), Some(&b""[..]));
        assert_eq!(member(&bytes, "c.npy").ok(), Some(None));
    }

    #[test]
    fn damage_is_found_wherever_it_is() {
        let sound = archive();
        for cut in 0..sound.len() {
            assert!(member(&sound[..cut], "a.npy").is_err(), "cut at {cut}");
        }
        let mut flipped = sound.clone();
        flipped[36] ^= 1;
        let text = member(&flipped, "a.npy").err().map(|p| p.text);
        assert_eq!(text.unwrap(), "the checksum of a.npy does not fit its content");
    }
}
