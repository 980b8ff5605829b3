use super::*;
use crate::test_data::with_causes;

const SIZE: ImageSize = ImageSize { rows: 2, cols: 3 };

/// All counts of a stack, and what messages call its images.
fn read(path: &Path, camera: ImageSize) -> Result<(Vec<Vec<f64>>, Vec<String>), ReadError> {
    let stack = ImageStack::open(path, camera, &mut Vec::new())?.unwrap();
    let (mut images, mut names, mut row_counts) = (Vec::new(), Vec::new(), Vec::new());
    stack.for_each(|at, image| {
        let mut counts = Vec::new();
        for row in 0..image.size().rows {
            image.copy_row(row, &mut row_counts);
            counts.extend_from_slice(&row_counts);
        }
        images.push(counts);
        names.push(format!("{}{}", at.path.display(), at.place));
        Ok(())
    })?;
    assert_eq!(images.len(), stack.steps());
    Ok((images, names))
}

fn error(path: &Path, camera: ImageSize) -> String {
    with_causes(&read(path, camera).unwrap_err())
}

fn png(folder: &Path, name: &str, size: ImageSize, counts: Counts<'_>) {
    crate::write_file(&folder.join(name), |out| write_png_image(size, counts, out)).unwrap();
}

#[test]
fn arrays_come_back_image_by_image_in_both_depths() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("stack.npy");
    let eight: Vec<u8> = (244..=255).collect();
    let sixteen: Vec<u16> = eight.iter().map(|&c| u16::from(c) * 257).collect();
    for (counts, scale) in [(Counts::Eight(&eight), 1.0), (Counts::Sixteen(&sixteen), 257.0)] {
        crate::write_file(&path, |out| write_npy_stack(2, SIZE, counts, out)).unwrap();
        let (images, names) = read(&path, SIZE).unwrap();
        let wanted: Vec<f64> = eight.iter().map(|&c| f64::from(c) * scale).collect();
        assert_eq!(images, [&wanted[..6], &wanted[6..]]);
        assert!(names[1].ends_with("stack.npy, image 1"), "{names:?}");
    }
    let mut longer = std::fs::read(&path).unwrap();
    longer.extend([0; 3]);
    std::fs::write(&path, longer).unwrap();
    let mut notes = Vec::new();
    assert_eq!(ImageStack::open(&path, SIZE, &mut notes).unwrap().unwrap().steps(), 2);
    assert_eq!(notes, ["3 bytes after the last number ignored"]);
    let mut big = Vec::new();
    crate::npy::write_header(&mut big, ">u2", &[1, 2, 3]).unwrap();
    big.extend(sixteen[..6].iter().flat_map(|c| c.to_be_bytes()));
    std::fs::write(&path, big).unwrap();
    assert_eq!(read(&path, SIZE).unwrap().0[0][0], 244.0 * 257.0);
}

#[test]
fn folders_are_read_in_the_order_of_their_names() {
    let folder = tempfile::tempdir().unwrap();
    png(folder.path(), "image_10.png", SIZE, Counts::Sixteen(&[10, 256, 65535, 0, 1, 2]));
    png(folder.path(), "image_02.PNG", SIZE, Counts::Eight(&[2, 255, 0, 0, 1, 2]));
    std::fs::write(folder.path().join("notes.txt"), "none").unwrap();
    let (images, names) = read(folder.path(), SIZE).unwrap();
    let wanted = [[2.0, 255.0, 0.0, 0.0, 1.0, 2.0], [10.0, 256.0, 65535.0, 0.0, 1.0, 2.0]];
    assert_eq!(images, wanted);
    assert!(names[0].ends_with("image_02.PNG"), "{names:?}");
    let mut notes = Vec::new();
    assert_eq!(ImageStack::open(folder.path(), SIZE, &mut notes).unwrap().unwrap().steps(), 2);
    assert_eq!(notes, ["1 files that are no .png ignored"]);
}

#[test]
fn what_is_no_stack_is_left_to_others() {
    let folder = tempfile::tempdir().unwrap();
    let open = |name: &str| {
        ImageStack::open(&folder.path().join(name), SIZE, &mut Vec::new()).map(|s| s.is_none())
    };
    crate::test_data::write_npy(&folder.path().join("flat.npy"), &[2, 3], &[1.0; 6]);
    assert!(open("flat.npy").unwrap());
    assert!(open("one.png").unwrap(), "a single .png is a range image, there or not");
    assert!(matches!(open("missing.npy"), Err(ReadError::Io { .. })));
}

#[test]
fn arrays_that_are_no_stack_of_this_camera_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("stack.npy");
    let with = |descr: &str, shape: &[usize], data: usize, camera: ImageSize| {
        let mut bytes = Vec::new();
        crate::npy::write_header(&mut bytes, descr, shape).unwrap();
        bytes.resize(bytes.len() + data, 7);
        std::fs::write(&path, bytes).unwrap();
        error(&path, camera)
    };
    let huge = ImageSize { rows: 1 << 40, cols: 1 << 40 };
    let empty = ImageSize { rows: 0, cols: 1 << 60 };
    for (error, wanted) in [
        (with("<f4", &[2, 2, 3], 48, SIZE), "stack.npy: a stack of intensity images holds counts"),
        (with("|u1", &[0, 2, 3], 0, SIZE), "stack.npy: the stack has no images"),
        (with("|u1", &[2, 2, 3], 11, SIZE), "truncated: the header announces [2, 2, 3]"),
        (with("|u1", &[1 << 40, 2, 3], 11, SIZE), "truncated: the header announces"),
        (with("|u1", &[1, 1 << 40, 1 << 40], 9, huge), "truncated: the header announces"),
        (with("|u1", &[9, 0, 1 << 60], 9, empty), "is empty or absurdly large"),
        (
            with("|u1", &[2, 3, 2], 12, SIZE),
            "the stack's images have 3 rows × 2 columns, but the camera 2 rows × 3 columns",
        ),
        (with("<c8", &[2, 2, 3], 96, SIZE), "numbers of type \"<c8\""),
    ] {
        assert!(error.contains(wanted), "{error}");
    }
}

#[test]
fn folders_that_are_no_stack_of_this_camera_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let none = error(folder.path(), SIZE);
    assert!(none.contains("no .png images in this folder"), "{none}");
    png(folder.path(), "a.png", SIZE, Counts::Eight(&[0; 6]));
    png(folder.path(), "b.png", ImageSize { rows: 3, cols: 2 }, Counts::Eight(&[0; 6]));
    let other = error(folder.path(), SIZE);
    assert!(other.contains("b.png: the image has 3 rows × 2 columns, but the camera"), "{other}");
    std::fs::write(folder.path().join("b.png"), b"no image").unwrap();
    assert!(error(folder.path(), SIZE).contains("b.png: cannot be decoded"));
    let file = std::fs::File::create(folder.path().join("b.png")).unwrap();
    let mut encoder = png::Encoder::new(file, 3, 2);
    encoder.set_color(png::ColorType::Rgb);
    encoder.write_header().unwrap().write_image_data(&[0; 18]).unwrap();
    let coloured = error(folder.path(), SIZE);
    let wanted = "b.png: the image is Rgb of 8 bits and must be grey";
    assert!(coloured.contains(wanted), "{coloured}");
}

#[test]
fn counts_that_do_not_fill_their_images_are_not_written() {
    let mut out = Vec::new();
    assert!(write_npy_stack(2, SIZE, Counts::Eight(&[0; 11]), &mut out).is_err());
    assert!(write_png_image(SIZE, Counts::Sixteen(&[0; 7]), &mut out).is_err());
    let absurd = ImageSize { rows: usize::MAX, cols: 2 };
    assert!(write_npy_stack(1, absurd, Counts::Eight(&[]), &mut out).is_err());
    assert!(out.is_empty());
}
