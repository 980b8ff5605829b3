//! Other programs on the same height image: a placeholder.
