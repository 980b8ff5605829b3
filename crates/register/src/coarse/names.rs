//! The order of names with numbers in them.

/// A name with zeros before its numbers, so that their order is that of the names.
pub(super) fn with_long_numbers(name: &str) -> String {
    let is_digit = |c: char| c.is_ascii_digit();
    let mut long = String::new();
    let mut rest = name;
    while let Some(start) = rest.find(is_digit) {
        let (before, number) = rest.split_at(start);
        let (number, after) =
            number.split_at(number.find(|c| !is_digit(c)).unwrap_or(number.len()));
        long += &format!("{before}{number:0>20}");
        rest = after;
    }
    long + rest
}

#[cfg(test)]
mod tests {
    use super::with_long_numbers;

    #[test]
    fn names_are_in_the_order_of_their_numbers() {
        let names = ["a", "view1", "view2b", "view2b3", "view10", "view10b", "z0"];
        let long = names.map(with_long_numbers);
        assert!(long.is_sorted(), "{long:?}");
        assert!(!names.is_sorted());
    }
}
