//! Printing notes and warnings to stderr, like notes of many files together.

use crate::printable::lines;
use std::collections::BTreeSet;
use transect_device::Note;
use transect_workflow::as_options;

/// Prints notes. Those that say the same of several files name the first file.
pub fn tell(notes: &[Note]) {
    for note in gathered(notes) {
        eprintln!("note: {}", lines(&as_options(&note.to_string())));
    }
}

/// Prints warnings.
pub fn warn(warnings: &[String]) {
    warnings.iter().for_each(|warning| eprintln!("warning: {}", lines(&as_options(warning))));
}

/// The notes in their order, each text once.
fn gathered(notes: &[Note]) -> Vec<Note> {
    let mut groups: Vec<(&Note, BTreeSet<&str>)> = Vec::new();
    for note in notes {
        let about = note.about.as_deref();
        match groups.iter_mut().find(|(first, _)| first.text == note.text) {
            Some((_, known)) => known.extend(about),
            None => groups.push((note, about.into_iter().collect())),
        }
    }
    let told = groups.into_iter().map(|(first, known)| match (&first.about, known.len()) {
        (Some(about), count @ 2..) => {
            Note::about(format_args!("{about} and {} more", count - 1), &first.text)
        }
        _ => first.clone(),
    });
    told.collect()
}

#[cfg(test)]
mod tests {
    use super::gathered;
    use transect_device::Note;

    #[test]
    fn like_notes_of_many_files_are_one() {
        let negative = |file| Note::about(file, "3 values are negative; missing");
        let notes = [
            negative("a.npy"),
            Note::about("b.npy", "the image is large"),
            negative("c.npy"),
            Note::new("poses are read as asked for: inverse"),
            negative("c.npy"),
            negative("d.npy"),
            Note::new("images are read as asked for: inverse"),
        ];
        let expected = [
            "a.npy and 2 more: 3 values are negative; missing",
            "b.npy: the image is large",
            "poses are read as asked for: inverse",
            "images are read as asked for: inverse",
        ];
        let told: Vec<String> = gathered(&notes).iter().map(ToString::to_string).collect();
        assert_eq!(told, expected);
    }
}
