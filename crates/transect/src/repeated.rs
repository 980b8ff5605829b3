//! Views of a store that hold one image.

use std::collections::BTreeMap;
use transect_device::Note;
use transect_model::store::{StoredView, ViewDescription};

/// Names the views that hold the image of another view at another pose, as a camera that repeats
/// its last frame makes them. At one pose, their curves are the same and count once.
pub(super) fn note(views: &[StoredView]) -> Option<Note> {
    repeated(views.iter().map(|view| &view.entry))
}

fn repeated<'a>(views: impl Iterator<Item = &'a ViewDescription>) -> Option<Note> {
    let mut of_image = BTreeMap::<&str, Vec<&ViewDescription>>::new();
    for view in views.filter(|view| !view.source_hash.is_empty()) {
        of_image.entry(&view.source_hash).or_default().push(view);
    }
    let pairs: Vec<[&ViewDescription; 2]> = of_image
        .values()
        .filter_map(|of| {
            let first = *of.first()?;
            let moved = |v: &&&ViewDescription| v.world_from_sensor != first.world_from_sensor;
            Some([first, *of.iter().find(moved)?])
        })
        .collect();
    let [a, b] = pairs.first()?;
    let others = match pairs.len() {
        1 => String::new(),
        n => format!(" So have {} more pairs.", n - 1),
    };
    Some(Note::new(format!(
        "views {} and {} have the same image at different poses.{others} One image counts twice \
         then, and the stated errors are too small; take one of them out",
        a.id, b.id
    )))
}

#[cfg(test)]
mod tests {
    use super::*;
    use transect_device::Isometry3;

    fn view(id: &str, hash: &str, x: f64) -> ViewDescription {
        ViewDescription {
            id: id.into(),
            name: String::new(),
            sensor: String::new(),
            source: String::new(),
            source_hash: hash.to_owned(),
            world_from_sensor: Isometry3::translation(x, 0.0, 0.0),
            sigma: None,
        }
    }

    #[test]
    fn one_image_at_two_poses_is_told() {
        let sound = [view("a", "1", 0.0), view("b", "2", 1.0), view("c", "1", 0.0)];
        let unknown = [view("d", "", 2.0), view("e", "", 3.0)];
        assert_eq!(repeated(sound.iter().chain(&unknown)), None);
        let other = view("f", "1", 1e-7);
        let note = repeated(sound.iter().chain([&other])).unwrap().to_string();
        assert!(note.contains("views a and f have the same image"), "{note}");
    }
}
