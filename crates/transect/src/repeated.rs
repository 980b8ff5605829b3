//! Views that hold one image.

use crate::modelled_view::ModelledView;
use std::collections::BTreeMap;
use transect_device::{Isometry3, Note};
use transect_model::store::StoredView;

/// The image of a view, by its fingerprint, and the pose that it was modelled at.
#[derive(Debug, Clone, Copy)]
pub(crate) struct PlacedImage<'a> {
    pub view: &'a str,
    /// Empty if the fingerprint is not known.
    pub fingerprint: &'a str,
    pub world_from_sensor: &'a Isometry3,
}

impl<'a> From<&'a StoredView> for PlacedImage<'a> {
    fn from(StoredView { entry, .. }: &'a StoredView) -> Self {
        Self {
            view: &entry.id.0,
            fingerprint: &entry.source_hash,
            world_from_sensor: &entry.world_from_sensor,
        }
    }
}

impl<'a> From<&'a ModelledView> for PlacedImage<'a> {
    fn from(ModelledView { report, fingerprint, world_from_sensor, .. }: &'a ModelledView) -> Self {
        Self { view: &report.name, fingerprint, world_from_sensor }
    }
}

/// Names the views that hold the image of another view at another pose, as a camera that repeats
/// its last frame makes them. At one pose, their curves are the same and count once.
pub(crate) fn repeated_images<'a>(images: impl Iterator<Item = PlacedImage<'a>>) -> Option<Note> {
    let mut of_image = BTreeMap::<&str, Vec<PlacedImage<'_>>>::new();
    for image in images.filter(|image| !image.fingerprint.is_empty()) {
        of_image.entry(image.fingerprint).or_default().push(image);
    }
    let repeated = of_image.values().filter_map(|of| {
        let first = *of.first()?;
        let moved = |v: &&PlacedImage<'_>| v.world_from_sensor != first.world_from_sensor;
        Some(([first, *of.iter().find(moved)?], of.len() - 1))
    });
    let repeated: Vec<_> = repeated.collect();
    let ([a, b], _) = repeated.first()?;
    let others = match repeated.iter().map(|(_, copies)| copies).sum::<usize>() {
        0 | 1 => String::new(),
        2 => " 1 more view repeats an image.".to_owned(),
        copies => format!(" {} more views repeat an image.", copies - 1),
    };
    Some(Note::new(format!(
        "views {} and {} have the same image at different poses.{others} An image that counts \
         twice makes the stated errors too small. Keep one view of each image: leave the others \
         out with the setting `views`, or take them out of a store with transect remove-view",
        a.view, b.view
    )))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_image_at_two_poses_is_told() {
        let poses = [0.0, 1.0, 2.0, 1e-7, 3.0].map(|x| Isometry3::translation(x, 0.0, 0.0));
        let image = |view, fingerprint, k: usize| PlacedImage {
            view,
            fingerprint,
            world_from_sensor: &poses[k],
        };
        let sound = [image("a", "1", 0), image("b", "2", 1), image("c", "1", 0)];
        let unknown = [image("d", "", 2), image("e", "", 0)];
        assert_eq!(repeated_images(sound.into_iter().chain(unknown)), None);
        let other = image("f", "1", 3);
        let note = repeated_images(sound.into_iter().chain([other])).unwrap().to_string();
        assert!(note.contains("views a and f have the same image"), "{note}");
        assert!(note.contains(" 1 more view repeats an image."), "{note}");
        let pair = [image("a", "1", 0), other];
        let note = repeated_images(pair.into_iter()).unwrap().to_string();
        assert!(note.contains("different poses. An image that counts twice"), "{note}");
        let more = [image("g", "1", 4), image("h", "2", 2)];
        let note = repeated_images(sound.into_iter().chain([other]).chain(more)).unwrap();
        assert!(note.to_string().contains(" 3 more views repeat an image."), "{note}");
    }
}
