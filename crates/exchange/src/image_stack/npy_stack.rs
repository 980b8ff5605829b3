//! A stack in one `.npy` file: images × rows × columns of unsigned 8- or 16-bit counts.

use super::Located;
use crate::error::Problem;
use crate::npy::{self, Header};
use crate::scalar::Scalar;
use crate::{Place, ReadError, input};
use std::io::{Read, Seek, SeekFrom};
use std::path::{Path, PathBuf};
use transect_device::ImageSize;
use transect_sensors::light_stripe::stripe::IntensityImage;

/// Longest header that is read: more than version 1 of the format can have.
const LONGEST_HEADER: u64 = 1 << 17;

pub(crate) struct NpyStack {
    path: PathBuf,
    header: Header,
    steps: usize,
    size: ImageSize,
}

impl NpyStack {
    /// The stack in a file; `None` if its array has other than three dimensions.
    pub(super) fn open(
        path: &Path,
        camera: ImageSize,
        notes: &mut Vec<String>,
    ) -> Result<Option<Self>, ReadError> {
        let io = |e| ReadError::io(path, e);
        let damaged = |problem: String| ReadError::damaged(path, Place::Whole, problem);
        let file = input::open(path)?;
        let length = file.metadata().map_err(io)?.len();
        let mut start = Vec::new();
        file.take(LONGEST_HEADER).read_to_end(&mut start).map_err(io)?;
        let located = |problem: Problem| problem.in_file(path);
        let header = Header::parse(&start).map_err(located)?;
        let [steps, rows, cols] = *header.shape else { return Ok(None) };
        if header.fortran || !matches!(header.scalar, Scalar::U8 | Scalar::U16) {
            let problem = "a stack of intensity images holds counts of type u1 or u2, not in Fortran order; \
                 save numpy.ascontiguousarray(stack)";
            return Err(ReadError::unsupported(path, Place::Whole, problem));
        }
        let length = usize::try_from(length).unwrap_or(usize::MAX);
        let needed = header.data_size(length).map_err(located)?;
        if steps == 0 {
            return Err(damaged("the stack has no images".to_owned()));
        }
        let size = ImageSize { rows, cols };
        if size != camera {
            let problem = format!("the stack's images have {size}, but the camera {camera}");
            return Err(damaged(problem));
        }
        size.check().map_err(|e| ReadError::unusable(path, Place::Whole, "the stack", e))?;
        notes.extend(npy::leftovers(length.saturating_sub(header.length).saturating_sub(needed)));
        Ok(Some(Self { path: path.to_owned(), header, steps, size }))
    }

    pub(super) fn steps(&self) -> usize {
        self.steps
    }

    pub(super) fn for_each(
        &self,
        mut take: impl FnMut(Located<'_>, IntensityImage) -> Result<(), ReadError>,
    ) -> Result<(), ReadError> {
        let io = |e| ReadError::io(&self.path, e);
        let mut file = input::open(&self.path)?;
        file.seek(SeekFrom::Start(self.header.length as u64)).map_err(io)?;
        // Not more than the file has, because `data_size` has compared them.
        let mut bytes = vec![0; self.size.pixels() * self.header.scalar.size()];
        for number in 0..self.steps {
            let place = Place::Element { kind: "image".to_owned(), number, line: None };
            file.read_exact(&mut bytes).map_err(io)?;
            let image = self
                .image(&bytes)
                .map_err(|e| ReadError::unusable(&self.path, place.clone(), "the image", e))?;
            take(Located { path: &self.path, place }, image)?;
        }
        Ok(())
    }

    fn image(&self, bytes: &[u8]) -> Result<IntensityImage, transect_device::ImageError> {
        if self.header.scalar == Scalar::U8 {
            return IntensityImage::from_u8(self.size, bytes.to_vec());
        }
        let (pairs, _) = bytes.as_chunks();
        let count = if self.header.big_endian { u16::from_be_bytes } else { u16::from_le_bytes };
        IntensityImage::from_u16(self.size, pairs.iter().map(|pair| count(*pair)).collect())
    }
}
