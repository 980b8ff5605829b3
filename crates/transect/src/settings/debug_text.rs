//! Settings in the form that programs before the record wrote them: the text by which Rust shows a
//! value for debugging, such as `OnePass(OnePassOptions { gap: 4, smooth: true }); Consensus(…)`.
//!
//! Names of variants become keys in small letters, so that the result has the form of a record.

use serde_json::{Map, Value};

/// Names of structs; every other name in front of braces is that of a variant.
const STRUCTS: [&str; 5] = [
    "OnePassOptions",
    "DissertationOptions",
    "ConsensusOptions",
    "PairwiseOptions",
    "OverlapTolerance",
];

/// The record of a text; `None` if the text has another form.
pub(super) fn record(text: &str) -> Option<Value> {
    let (partial, rest) = value(text)?;
    let (fusion, rest) = value(rest.strip_prefix("; ")?)?;
    let fields = [("version", 1.into()), ("partial", partial), ("fusion", fusion)];
    rest.is_empty().then(|| fields.into_iter().map(|(k, v)| (k.to_owned(), v)).collect())
}

/// The value at the beginning of a text, and the text behind it.
fn value(text: &str) -> Option<(Value, &str)> {
    let is_part = |c: char| c.is_alphanumeric() || "_.+-".contains(c);
    let (word, rest) = text.split_at(text.find(|c| !is_part(c)).unwrap_or(text.len()));
    if let Some(rest) = rest.strip_prefix('(') {
        let (inner, rest) = value(rest)?;
        let whole = if word == "Some" { inner } else { keyed(word, inner) };
        return Some((whole, rest.strip_prefix(')')?));
    }
    if let Some(rest) = rest.strip_prefix(" { ") {
        let (fields, rest) = fields(rest)?;
        return Some((if STRUCTS.contains(&word) { fields } else { keyed(word, fields) }, rest));
    }
    let simple = match word {
        "None" => Value::Null,
        // Numbers and truth values are the same in both forms.
        _ => serde_json::from_str(word).unwrap_or_else(|_| key(word).into()),
    };
    Some((simple, rest))
}

/// Fields up to the closing brace.
fn fields(mut text: &str) -> Option<(Value, &str)> {
    let mut fields = Map::new();
    loop {
        let (name, rest) = text.split_once(": ")?;
        let (value, rest) = value(rest)?;
        fields.insert(name.to_owned(), value);
        match rest.strip_prefix(", ") {
            Some(more) => text = more,
            None => return Some((fields.into(), rest.strip_prefix(" }")?)),
        }
    }
}

fn keyed(variant: &str, inner: Value) -> Value {
    Map::from_iter([(key(variant), inner)]).into()
}

/// The key of a variant: `OnePass` becomes `one_pass`.
fn key(variant: &str) -> String {
    let mut key = String::with_capacity(variant.len() + 4);
    for (k, c) in variant.char_indices() {
        if c.is_uppercase() && k > 0 {
            key.push('_');
        }
        key.push(c.to_ascii_lowercase());
    }
    key
}
