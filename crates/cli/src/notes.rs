//! Printing notes to stderr, like ones of many files together.

/// Prints notes. Those that say the same of several files name the first file.
pub fn tell(notes: &[String]) {
    gathered(notes).iter().for_each(|note| eprintln!("note: {note}"));
}

/// The notes in their order, each text once; notes begin with the name of a file, if they have one.
fn gathered(notes: &[String]) -> Vec<String> {
    let mut texts: Vec<(&str, &str, usize)> = Vec::new();
    for note in notes {
        let (file, text) = note.split_once(": ").unwrap_or(("", note));
        match texts.iter_mut().find(|(_, known, _)| *known == text) {
            Some((_, _, more)) => *more += 1,
            None => texts.push((file, text, 0)),
        }
    }
    let told = texts.into_iter().map(|(file, text, more)| match (file, more) {
        ("", _) => text.to_owned(),
        (_, 0) => format!("{file}: {text}"),
        _ => format!("{file} and {more} more: {text}"),
    });
    told.collect()
}

#[cfg(test)]
mod tests {
    use super::gathered;

    #[test]
    fn like_notes_of_many_files_are_one() {
        let notes = [
            "a.npy: 3 values are negative; missing",
            "b.npy: the image is large",
            "c.npy: 3 values are negative; missing",
            "the planes lie in a face",
            "d.npy: 3 values are negative; missing",
        ];
        let expected = [
            "a.npy and 2 more: 3 values are negative; missing",
            "b.npy: the image is large",
            "the planes lie in a face",
        ];
        assert_eq!(gathered(&notes.map(str::to_owned)), expected);
    }
}
