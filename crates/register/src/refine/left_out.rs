//! Whether pairs that were left out of an estimate agree better with it.
