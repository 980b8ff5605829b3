//! Imports among the files of one crate run one way.
//!
//! A file is a module. It imports another file when a path in it names an item of that file. An
//! item that a third module re-exports counts as an import of the file that defines it. A file may
//! import from its direct parent module, and a path through that parent counts as the parent. The
//! root of a crate (`lib.rs`) may be imported by its direct children; its re-exports are followed.
//! Code under `#[cfg(test)]` is left out. The reader relies on the layout that `rustfmt` gives, and
//! reads the contents of strings like code.

use super::finding::{Finding, TextFile, files, report};
use crate::run::Failure;
use std::collections::{BTreeMap, BTreeSet, VecDeque};
use std::path::Path;

/// A path of modules and names from the root of a crate.
type Names = Vec<String>;

/// A word or a sign with its line.
type Token<'a> = (&'a str, usize);

/// The modules of one crate by their paths.
type Modules<'a> = BTreeMap<Names, Module<'a>>;

/// The imported modules of each module, with the line of the first import.
type Imports<'a> = BTreeMap<&'a Names, BTreeMap<&'a Names, usize>>;

/// Longest chain of re-exports that is followed, so that a chain without end stops the search.
const MOST_REEXPORTS: usize = 8;

/// Checks every crate of the workspace.
pub fn run(root: &Path) -> Result<(), Failure> {
    let mut crates = BTreeMap::<String, Vec<TextFile>>::new();
    for file in files(root, "", &[".rs"])? {
        if let Some((folder, _)) = file.name.split_once("/src/") {
            crates.entry(folder.to_owned()).or_default().push(file);
        }
    }
    report(crates.values().flat_map(|files| circles(files)).collect())
}

/// The circles among the files of one crate, at least one of each group that hangs together.
fn circles(files: &[TextFile]) -> Vec<Finding> {
    let modules = read_modules(files);
    let imports: Imports = modules.keys().map(|name| (name, imports_of(name, &modules))).collect();
    // One circle is found from each of its files; the first file reports it.
    let is_first = |circle: &Vec<&Names>| circle.iter().min() == circle.first();
    let circles = modules.keys().filter_map(|start| circle_through(&imports, start));
    circles.filter(is_first).filter_map(|circle| describe(&modules, &imports, &circle)).collect()
}

/// The shortest way along imports from a module back to itself.
fn circle_through<'a>(imports: &Imports<'a>, start: &'a Names) -> Option<Vec<&'a Names>> {
    let mut ways = VecDeque::from([vec![start]]);
    let mut reached = BTreeSet::new();
    while let Some(way) = ways.pop_front() {
        for &next in imports.get(way.last()?)?.keys() {
            if next == start {
                return Some(way);
            }
            if reached.insert(next) {
                ways.push_back([&way[..], &[next]].concat());
            }
        }
    }
    None
}

/// The finding about one circle.
fn describe(modules: &Modules, imports: &Imports, circle: &[&Names]) -> Option<Finding> {
    let mut steps = Vec::new();
    for (from, to) in circle.iter().zip(circle.iter().cycle().skip(1)) {
        steps.push((modules.get(*from)?.file, *imports.get(from)?.get(to)?));
    }
    let (first, line) = *steps.first()?;
    let circle: String = steps.iter().map(|(file, line)| format!("{file}:{line} → ")).collect();
    let message = format!(
        "imports form a circle: {circle}{first}; move what these files share into a file that \
         imports none of them"
    );
    Some(Finding { file: first.to_owned(), line, message })
}

/// A file of a crate as a module.
struct Module<'a> {
    file: &'a str,
    paths: Vec<WrittenPath>,
    /// The names that the file's `use` declarations bring in from the crate, and their paths.
    names: BTreeMap<String, Names>,
}

/// A path in a file.
struct WrittenPath {
    line: usize,
    /// The name that a `use` gives the item; `None` for a path in other code.
    name: Option<String>,
    /// The parts as they are written, later as they follow from the root; empty for other crates.
    parts: Names,
}

/// Reads the files of a crate; files that only tests use are left out.
fn read_modules(files: &[TextFile]) -> Modules<'_> {
    let mut modules = Modules::new();
    let mut of_tests = Vec::new();
    for file in files {
        let path = module_path(&file.name);
        let (text, tests) = without_tests(&file.text);
        of_tests.extend(tests.into_iter().map(|name| [path.clone(), vec![name]].concat()));
        let paths = written_paths(&tokens(&text));
        modules.insert(path, Module { file: &file.name, paths, names: BTreeMap::new() });
    }
    modules.retain(|path, _| !of_tests.iter().any(|tests| path.starts_with(tests)));
    let known: BTreeSet<Names> = modules.keys().cloned().collect();
    for (path, module) in &mut modules {
        let target = |written: &WrittenPath| from_root(path, &written.parts, &known);
        let named = |written: &WrittenPath| Some((written.name.clone()?, target(written)?));
        module.names = module.paths.iter().filter_map(named).collect();
        for written in &mut module.paths {
            let known = module.names.get(&written.parts[0]);
            let by_name = known.map(|known| [known, &written.parts[1..]].concat());
            written.parts = target(written).or(by_name).unwrap_or_default();
        }
    }
    modules
}

/// The module that a file holds: `crates/c/src/a/mod.rs` and `crates/c/src/a.rs` hold `a`.
fn module_path(file: &str) -> Names {
    let path = file.split_once("/src/").map_or(file, |(_, path)| path);
    let path = path.trim_end_matches(".rs").trim_end_matches("/mod");
    let is_root = ["lib", "main"].contains(&path);
    path.split('/').filter(|_| !is_root).map(str::to_owned).collect()
}

/// The numbered lines without items of tests, and the names of the modules that only tests use.
fn without_tests(text: &str) -> (Vec<Token<'_>>, Names) {
    let mut rest = Vec::new();
    let mut modules = Names::new();
    let mut lines = text.lines().zip(1..);
    while let Some((line, number)) = lines.next() {
        let Some(indent) = line.strip_suffix("#[cfg(test)]") else {
            rest.push((line, number));
            continue;
        };
        let item = lines.find(|(line, _)| !line.trim_start().starts_with('#'));
        match item.and_then(|(item, _)| item.strip_suffix(';')) {
            Some(item) => modules.extend(item.split_once("mod ").map(|item| item.1.to_owned())),
            None => drop(lines.find(|(line, _)| {
                line.strip_prefix(indent).is_some_and(|behind| behind.starts_with('}'))
            })),
        }
    }
    (rest, modules)
}

/// The words and signs of lines without their comments; `::` is one sign.
fn tokens<'a>(lines: &[Token<'a>]) -> Vec<Token<'a>> {
    let is_word = |c: char| c.is_alphanumeric() || c == '_';
    let mut tokens = Vec::new();
    for &(line, number) in lines {
        let mut rest = line.split("//").next().unwrap_or(line).trim();
        while let Some(first) = rest.chars().next() {
            let length = match rest.find(|c| !is_word(c)) {
                Some(0) if rest.starts_with("::") => 2,
                Some(0) => first.len_utf8(),
                length => length.unwrap_or(rest.len()),
            };
            tokens.push((&rest[..length], number));
            rest = rest[length..].trim_start();
        }
    }
    tokens
}

fn is_name((text, _): Token) -> bool {
    text.starts_with(|c: char| c.is_alphabetic() || c == '_')
}

/// All paths of a file.
fn written_paths(tokens: &[Token]) -> Vec<WrittenPath> {
    let mut paths = Vec::new();
    let mut rest = tokens;
    while let Some((&(text, line), behind)) = rest.split_first() {
        rest = behind;
        if text == "use" {
            let end = rest.iter().position(|token| token.0 == ";").unwrap_or(rest.len());
            paths.extend(paths_of_use(&rest[..end]));
            rest = &rest[end..];
        } else if text == "in" && rest.first().is_some_and(|next| next.0 == "crate") {
            // `pub(in crate::x)` imports nothing.
            let end = rest.iter().position(|token| token.0 == ")").unwrap_or(rest.len());
            rest = &rest[end..];
        } else if is_name((text, line)) {
            let mut parts = vec![text.to_owned()];
            while let [("::", _), next, behind @ ..] = rest
                && is_name(*next)
            {
                parts.push(next.0.to_owned());
                rest = behind;
            }
            paths.push(WrittenPath { line, name: None, parts });
        }
    }
    paths
}

/// The paths of one `use` declaration, given without `use` and the semicolon.
fn paths_of_use(tokens: &[Token]) -> Vec<WrittenPath> {
    let mut paths = Vec::new();
    let mut parts = Names::new();
    // How many parts stand before each brace that is open.
    let mut before = vec![0];
    let mut name = None;
    for (index, &(text, line)) in tokens.iter().chain(&[(",", 0)]).enumerate() {
        match text {
            "{" => before.push(parts.len()),
            "," | "}" => {
                if parts.len() > before.last().copied().unwrap_or(0) {
                    // `self` in braces names the module before them.
                    let is_self = parts.len() > 1 && parts.last().is_some_and(|p| p == "self");
                    parts.truncate(parts.len() - usize::from(is_self));
                    let name = name.take().or_else(|| parts.last().cloned());
                    let line = tokens.get(index - 1).map_or(line, |token| token.1);
                    paths.push(WrittenPath { line, name, parts: parts.clone() });
                }
                before.truncate(before.len() - usize::from(text == "}"));
                parts.truncate(before.last().copied().unwrap_or(0));
            }
            _ if index > 0 && tokens[index - 1].0 == "as" => name = Some(text.to_owned()),
            _ if text != "as" && is_name((text, line)) => parts.push(text.to_owned()),
            _ => {}
        }
    }
    paths
}

/// A path of a module as a path from the root; `None` for items of other crates.
fn from_root(module: &Names, parts: &[String], modules: &BTreeSet<Names>) -> Option<Names> {
    let first = parts.iter().position(|part| !["crate", "self", "super"].contains(&part.as_str()));
    let (places, rest) = parts.split_at(first.unwrap_or(parts.len()));
    let up = places.iter().filter(|place| *place == "super").count();
    let is_crate = places.first().is_some_and(|place| place == "crate");
    let base = if is_crate { &[] } else { &module[..module.len().saturating_sub(up)] };
    let path = [base, rest].concat();
    let is_ours = !places.is_empty() || modules.contains(&path[..=base.len()]);
    is_ours.then_some(path)
}

/// The modules that a module imports, each with the line of its first import.
fn imports_of<'a>(path: &Names, modules: &'a Modules) -> BTreeMap<&'a Names, usize> {
    let mut imports = BTreeMap::new();
    for written in modules.get(path).into_iter().flat_map(|module| &module.paths) {
        if let Some(file) = definition(path, &written.parts, modules, MOST_REEXPORTS) {
            imports.entry(file).or_insert(written.line);
        }
    }
    imports
}

/// The module that defines an item. `None` for a module as such, for the importing module itself
/// and for its direct parent.
fn definition<'a>(
    from: &Names,
    item: &[String],
    modules: &'a Modules,
    steps: usize,
) -> Option<&'a Names> {
    let length = (0..item.len()).rev().find(|&length| modules.contains_key(&item[..length]))?;
    let (path, module) = modules.get_key_value(&item[..length])?;
    let is_parent = from.split_last().is_some_and(|(_, parent)| parent == path);
    if path == from || is_parent && !path.is_empty() {
        return None;
    }
    match module.names.get(&item[length]) {
        Some(target) if steps > 0 && target != item => {
            definition(from, &[target, &item[length + 1..]].concat(), modules, steps - 1)
        }
        _ if modules.contains_key(&item[..=length]) => None,
        _ => (!is_parent).then_some(path),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The messages about a crate of these files.
    fn messages(files: &[(&str, &str)]) -> Vec<String> {
        let file = |(name, text): &(&str, &str)| TextFile {
            name: format!("crates/c/src/{name}"),
            text: (*text).to_owned(),
        };
        let files: Vec<_> = files.iter().map(file).collect();
        circles(&files).iter().map(Finding::to_string).collect()
    }

    fn is_circle(files: &[(&str, &str)]) -> bool {
        !messages(files).is_empty()
    }

    #[test]
    fn a_circle_is_printed_with_its_lines() {
        let found = messages(&[
            ("lib.rs", "mod a; mod b; mod d;"),
            ("a.rs", "\nuse crate::b::B;\npub struct A;"),
            ("b.rs", "use crate::d::D;\npub struct B;"),
            ("d.rs", "pub struct D(crate::a::A);"),
        ]);
        assert_eq!(
            found,
            [
                "crates/c/src/a.rs:2: imports form a circle: crates/c/src/a.rs:2 → crates/c/src/b.rs:1 \
              → crates/c/src/d.rs:1 → crates/c/src/a.rs; move what these files share into a file \
              that imports none of them"
            ]
        );
    }

    #[test]
    fn imports_one_way_are_no_circle() {
        assert!(!is_circle(&[
            ("lib.rs", "mod a; mod b; mod d; pub use a::A;"),
            ("a.rs", "use crate::{b::{self, B}, d::D}; use std::a::X; pub struct A;"),
            ("b.rs", "use super::d::*; pub struct B;"),
            ("d.rs", "//! use crate::a::A;\npub struct D; // crate::a::A"),
        ]));
    }

    #[test]
    fn every_way_to_write_an_import_is_read() {
        for import in [
            "use crate::b::B;",
            "pub(crate) use super::b::{C, B as Other};",
            "use crate::{d, b::{B}};",
            "use super::b; fn f() -> b::B { b::B }",
            "use crate::b::{self as other}; type T = other::B;",
            "fn f(_: crate::b::B<'_>) {}",
            "fn f() { self::super::b::f::<u8>(); }",
        ] {
            let a = ("a.rs", import);
            assert!(is_circle(&[("lib.rs", ""), a, ("b.rs", "use crate::a::A;")]), "{import}");
        }
    }

    #[test]
    fn reexports_by_the_root_lead_to_the_file_that_defines_the_item() {
        let root = ("lib.rs", "mod a; mod b; pub use a::A; pub use b::thing::B;");
        let thing = ("b/thing.rs", "use crate::A; pub struct B;");
        let b = ("b/mod.rs", "pub mod thing;");
        assert!(is_circle(&[root, b, thing, ("a.rs", "use crate::B; pub struct A;")]));
        assert!(!is_circle(&[root, b, thing, ("a.rs", "pub struct A;")]));
    }

    #[test]
    fn parents_and_children_may_know_each_other() {
        let parent = "mod y; mod z; use y::Y; pub struct P; fn f(_: z::Z) {}";
        let y = ("x/y.rs", "use super::{P, z::Z}; pub struct Y;");
        let z = ("x/z.rs", "use crate::x::P; pub struct Z;");
        let root = ("lib.rs", "mod x; pub fn own() {}");
        assert!(!is_circle(&[root, ("x/mod.rs", parent), y, z]));
        assert!(!is_circle(&[root, ("x.rs", parent), y, z]));
        // An item that the parent re-exports counts as the parent.
        let z = ("x/z.rs", "use super::Y; pub struct Z;");
        assert!(!is_circle(&[root, ("x.rs", parent), y, z]));
        // The root's own items may be used by its children, but by no grandchildren.
        assert!(!is_circle(&[("lib.rs", "mod w; use w::W; fn f() {}"), ("w.rs", "use crate::f;")]));
        let z = ("x/z.rs", "use crate::own; pub struct Z;");
        let root = ("lib.rs", "mod x; use x::P; pub fn own() {}");
        assert!(is_circle(&[root, ("x.rs", parent), y, z]));
    }

    #[test]
    fn a_circle_through_a_parent_is_found() {
        let parent = ("x/mod.rs", "mod y; pub use y::Y; pub fn own() {}");
        let y = ("x/y.rs", "use crate::w::W; pub struct Y;");
        let root = ("lib.rs", "mod w; mod x;");
        assert!(is_circle(&[root, parent, y, ("w.rs", "use crate::x::own; pub struct W;")]));
        assert!(is_circle(&[root, parent, y, ("w.rs", "use crate::x::Y; pub struct W;")]));
        let parent = ("x/mod.rs", "mod y; mod z; pub use y::Y; pub use z::Z;");
        let z = ("x/z.rs", "pub struct Z;");
        assert!(!is_circle(&[root, parent, y, z, ("w.rs", "use crate::x::Z; pub struct W;")]));
    }

    #[test]
    fn tests_are_left_out() {
        let b = ("b.rs", "use crate::a::A; pub struct B;");
        for a in [
            "#[cfg(test)]\nmod tests { use crate::b::B; fn f() { { } } } pub struct A;",
            "#[cfg(test)]\nuse crate::b::B; pub struct A;",
            "pub struct A; #[cfg(test)] pub(crate) mod tests;",
        ] {
            let tests = ("a/tests.rs", "use crate::b::B; pub fn f() {}");
            let more = ("a/tests/more.rs", "use super::super::f; use crate::b::B;");
            let files = [("lib.rs", ""), ("a.rs", a), b];
            assert!(!is_circle(&files), "{a}");
            if a.ends_with("mod tests;") {
                assert!(!is_circle(&[&files[..], &[tests, more]].concat()));
            }
        }
    }

    #[test]
    fn visibility_is_no_import() {
        let b = ("x/b.rs", "pub(in crate::x) struct B; pub(super) struct C; pub(crate) struct D;");
        let parent = ("x/mod.rs", "pub fn f(_: b::B) {}");
        let deep = ("x/b/deep.rs", "pub(in crate::x) struct E;");
        assert!(!is_circle(&[("lib.rs", ""), parent, b, deep]));
    }
}
