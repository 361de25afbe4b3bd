//! Tests which modules use which: no room uses a room above it, and no files use each other in a circle.
//!
//! A **room** is a folder in `src` with its `mod.rs` (or the file beside the folder). A **unit** is a file or folder directly in
//! a room. The tests read all `use` declarations and all paths in the code that begin with `crate`, `super`, `self`, a child
//! module or an imported name. A name that a `mod.rs` re-exports counts as a use of the unit that defines it. Only comments,
//! texts and items with `#[cfg(test)]` are not read.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

/// Rooms from the bottom to the top. Rooms in one entry do not use each other.
const FLOORS: [&[&str]; 9] = [
    &["recording"],
    &["formats", "features"],
    &["import", "calibration"],
    &["scoring"],
    &["report"],
    &["export"],
    &["questions"],
    &["engine"],
    &["cli", "ui"],
];

/// Path of a module or an item from the root of the crate, such as `["scoring", "lag", "Lag"]`.
type Names = Vec<String>;

/// Text of each source file, by the path of its module.
type Sources = BTreeMap<Names, String>;

#[derive(Default)]
struct Module {
    children: BTreeSet<String>,
    /// Imported names with the paths that the declarations give, as written.
    imports: BTreeMap<String, Names>,
    /// Paths in the code and in private imports, as written.
    paths: Vec<Names>,
    /// Types to which the module adds methods (`impl Type`), as written, each with the names of the methods.
    extended: Vec<(Names, BTreeSet<String>)>,
    /// All words of the code.
    words: BTreeSet<String>,
    /// Names of the methods that the code calls.
    calls: BTreeSet<String>,
}

/// Modules that are compiled outside tests, by their paths.
#[derive(Default)]
struct House {
    modules: BTreeMap<Names, Module>,
}

/// One module uses an item of another.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
struct Use {
    from: Names,
    to: Names,
}

/// Splits a source into words, `::` and single characters, without comments, texts, characters and lifetimes.
fn tokens(text: &str) -> Vec<String> {
    let all: Vec<char> = text.chars().collect();
    let is_word = |c: char| c.is_alphanumeric() || c == '_';
    let at = |k: usize| all.get(k).copied().unwrap_or('\0');
    let mut found = Vec::new();
    let mut k = 0;
    // Skips a text that begins with `hashes` hash signs and a quotation mark at `k`.
    let skip_raw = |mut k: usize, hashes: usize| {
        k += hashes + 1;
        while k < all.len() {
            if at(k) == '"' && (1..=hashes).all(|more| at(k + more) == '#') {
                return k + hashes + 1;
            }
            k += 1;
        }
        k
    };
    while k < all.len() {
        let c = all[k];
        if c == '/' && at(k + 1) == '/' {
            while k < all.len() && all[k] != '\n' {
                k += 1;
            }
        } else if c == '/' && at(k + 1) == '*' {
            let mut depth = 0;
            loop {
                match (at(k), at(k + 1)) {
                    ('/', '*') => (depth, k) = (depth + 1, k + 2),
                    ('*', '/') => (depth, k) = (depth - 1, k + 2),
                    _ => k += 1,
                }
                if depth == 0 || k >= all.len() {
                    break;
                }
            }
        } else if c == '"' {
            k += 1;
            while k < all.len() && all[k] != '"' {
                k += if all[k] == '\\' { 2 } else { 1 };
            }
            k += 1;
        } else if c == '\'' {
            if at(k + 1) == '\\' {
                k += 3;
                while k < all.len() && all[k] != '\'' {
                    k += 1;
                }
                k += 1;
            } else if at(k + 2) == '\'' {
                k += 3;
            } else {
                // A lifetime or a label.
                k += 1;
                while is_word(at(k)) {
                    k += 1;
                }
            }
        } else if is_word(c) {
            let start = k;
            while is_word(at(k)) {
                k += 1;
            }
            let word: String = all[start..k].iter().collect();
            let hashes = (0..).take_while(|more| at(k + more) == '#').count();
            if ["r", "br", "cr"].contains(&word.as_str()) && at(k + hashes) == '"' {
                k = skip_raw(k, hashes);
            } else if word == "r" && hashes == 1 {
                k += 1; // A raw name such as `r#type`.
            } else if !(["b", "c"].contains(&word.as_str()) && ['"', '\''].contains(&at(k))) {
                found.push(word);
            }
        } else if c == ':' && at(k + 1) == ':' {
            found.push("::".to_owned());
            k += 2;
        } else {
            if !c.is_whitespace() {
                found.push(c.to_string());
            }
            k += 1;
        }
    }
    found
}

/// Returns the position behind the group of brackets that begins at `at`.
fn behind_group(tokens: &[String], at: usize) -> usize {
    let mut depth = 0;
    for (k, token) in tokens.iter().enumerate().skip(at) {
        match token.as_str() {
            "(" | "[" | "{" => depth += 1,
            ")" | "]" | "}" => depth -= 1,
            _ => {}
        }
        if depth == 0 {
            return k + 1;
        }
    }
    tokens.len()
}

/// Returns the position behind the generic parameters that begin at `at`.
fn behind_generics(tokens: &[String], at: usize) -> usize {
    let mut depth = 0;
    for (k, token) in tokens.iter().enumerate().skip(at) {
        match token.as_str() {
            "<" => depth += 1,
            ">" if tokens[k - 1] != "-" => depth -= 1,
            _ => {}
        }
        if depth == 0 {
            return k + 1;
        }
    }
    tokens.len()
}

/// Reads the path that begins at `at`. Returns the position behind it, and its names.
fn path_at(tokens: &[String], mut at: usize) -> (usize, Names) {
    let mut names = vec![tokens[at].clone()];
    at += 1;
    while tokens.get(at).is_some_and(|token| token == "::")
        && tokens.get(at + 1).is_some_and(|name| is_name(name))
    {
        names.push(tokens[at + 1].clone());
        at += 2;
    }
    (at, names)
}

fn is_name(token: &str) -> bool {
    token.starts_with(|c: char| c.is_alphabetic() || c == '_')
}

/// Returns the position behind the item, field or statement that begins at `at`, with its attributes.
fn behind_item(tokens: &[String], mut at: usize) -> usize {
    const ITEMS: [&str; 14] = [
        "pub",
        "fn",
        "mod",
        "use",
        "impl",
        "struct",
        "enum",
        "const",
        "static",
        "type",
        "trait",
        "async",
        "unsafe",
        "macro_rules",
    ];
    let is = |k: usize, token: &str| tokens.get(k).is_some_and(|found| found == token);
    while is(at, "#") {
        at = behind_group(tokens, at + 1);
    }
    let mut kind = at;
    if is(kind, "pub") {
        kind += 1;
        if is(kind, "(") {
            kind = behind_group(tokens, kind);
        }
    }
    let is_item = tokens.get(kind).is_some_and(|found| ITEMS.contains(&found.as_str()));
    let is_use = is(kind, "use");
    while at < tokens.len() {
        match tokens[at].as_str() {
            ";" => return at + 1,
            "," if !is_item => return at + 1,
            "}" | ")" | "]" => return at,
            "{" if !is_use => return behind_group(tokens, at),
            "(" | "[" | "{" => at = behind_group(tokens, at),
            _ => at += 1,
        }
    }
    at
}

/// Removes all items, fields and statements with `#[cfg(test)]`.
fn without_tests(tokens: &[String]) -> Vec<String> {
    let marks = ["#", "[", "cfg", "(", "test", ")", "]"];
    let mut kept = Vec::new();
    let mut at = 0;
    while at < tokens.len() {
        if tokens[at..].iter().take(marks.len()).eq(marks.iter()) {
            at = behind_item(tokens, at);
        } else {
            kept.push(tokens[at].clone());
            at += 1;
        }
    }
    kept
}

/// Reads the tree of a `use` declaration from `at` on. Returns the position behind it, and each path with the name that it gets;
/// `*` for all names of the path.
fn use_tree(
    tokens: &[String],
    mut at: usize,
    before: &[String],
    found: &mut Vec<(String, Names)>,
) -> usize {
    let mut path = before.to_vec();
    while at < tokens.len() {
        match tokens[at].as_str() {
            "{" => {
                at += 1;
                while at < tokens.len() && tokens[at] != "}" {
                    at = use_tree(tokens, at, &path, found);
                    at += usize::from(tokens.get(at).is_some_and(|token| token == ","));
                }
                return at + 1;
            }
            "*" => {
                found.push(("*".to_owned(), path));
                return at + 1;
            }
            "::" => at += 1,
            "as" => {
                found.push((tokens[at + 1].clone(), path));
                return at + 2;
            }
            "," | "}" | ";" => break,
            "self" if !path.is_empty() => at += 1,
            word => {
                path.push(word.to_owned());
                at += 1;
            }
        }
    }
    if let Some(name) = path.last().cloned() {
        found.push((name, path));
    }
    at
}

fn joined(path: &[String], name: &str) -> Names {
    [path, &[name.to_owned()]].concat()
}

impl House {
    fn of(sources: &Sources) -> Self {
        let mut house = Self::default();
        house.read(sources, &Vec::new());
        house
    }

    fn read(&mut self, sources: &Sources, path: &Names) {
        let text = sources.get(path).unwrap_or_else(|| panic!("no source of {path:?}"));
        self.scan(sources, path, &without_tests(&tokens(text)));
    }

    fn scan(&mut self, sources: &Sources, path: &Names, tokens: &[String]) {
        let words = tokens.iter().filter(|token| is_name(token)).cloned().collect();
        let mut module = Module { words, ..Module::default() };
        let is = |k: usize, token: &str| tokens.get(k).is_some_and(|found| found == token);
        let is_name = |k: usize| tokens.get(k).is_some_and(|token| is_name(token));
        let mut at = 0;
        while at < tokens.len() {
            if is(at, "pub") && is(at + 1, "(") {
                let behind = behind_group(tokens, at + 1);
                // A `pub use` of another room is read as an import, too.
                at = if is(behind, "use") { behind } else { behind.max(at + 1) };
            } else if is(at, "mod") && is_name(at + 1) && (is(at + 2, ";") || is(at + 2, "{")) {
                let child = joined(path, &tokens[at + 1]);
                module.children.insert(tokens[at + 1].clone());
                if is(at + 2, ";") {
                    self.read(sources, &child);
                    at += 3;
                } else {
                    let end = behind_group(tokens, at + 2);
                    self.scan(sources, &child, &tokens[at + 3..end - 1]);
                    at = end;
                }
            } else if is(at, "use") && (is_name(at + 1) || is(at + 1, "::")) {
                let public = at > 0 && (is(at - 1, "pub") || is(at - 1, ")"));
                let mut found = Vec::new();
                at = use_tree(tokens, at + 1, &[], &mut found);
                for (name, written) in found {
                    if !public {
                        module.paths.push(written.clone());
                    }
                    module.imports.insert(name, written);
                }
            } else if is(at, "impl")
                && (at == 0 || ["}", ";", "{", "]"].iter().any(|end| is(at - 1, end)))
            {
                at += 1;
                if is(at, "<") {
                    at = behind_generics(tokens, at);
                }
                let end = at + tokens[at..].iter().take_while(|token| *token != "{").count();
                if is_name(at) && !tokens[at..end].contains(&"for".to_owned()) {
                    let body = &tokens[end..behind_group(tokens, end)];
                    let methods = body.windows(2).filter(|pair| pair[0] == "fn");
                    let methods = methods.map(|pair| pair[1].clone()).collect();
                    module.extended.push((path_at(tokens, at).1, methods));
                }
            } else if is_name(at) && is(at + 1, "::") && !(at > 0 && is(at - 1, "::")) {
                let written;
                (at, written) = path_at(tokens, at);
                module.paths.push(written);
            } else {
                if is(at, ".") && is_name(at + 1) && is(at + 2, "(") {
                    module.calls.insert(tokens[at + 1].clone());
                }
                at += 1;
            }
        }
        self.modules.insert(path.clone(), module);
    }

    /// Returns the path from the root of the crate for a path as it is written in the module `from`; `None` if it leads to
    /// another crate.
    fn absolute(&self, from: &Names, written: &[String]) -> Option<Names> {
        let (first, rest) = written.split_first()?;
        let base = match first.as_str() {
            "crate" => Vec::new(),
            "self" => from.clone(),
            "super" => {
                let above = from[..from.len().saturating_sub(1)].to_vec();
                let more = rest.iter().take_while(|name| *name == "super").count();
                let base = above[..above.len().saturating_sub(more)].to_vec();
                return Some([base, rest[more..].to_vec()].concat());
            }
            name => {
                let module = self.modules.get(from)?;
                if module.children.contains(name) {
                    joined(from, name)
                } else {
                    let import = module.imports.get(name)?;
                    // `use serde::Serialize` in a module without `serde`, or an import with the name of its crate.
                    if import.first() == Some(first) {
                        return None;
                    }
                    self.absolute(from, import)?
                }
            }
        };
        Some([base, rest.to_vec()].concat())
    }

    /// Adds the modules that the path from the root of the crate passes through: the one that defines the item, and before it
    /// those of units that re-export it.
    fn follow(&self, path: &Names, depth: usize, passed: &mut BTreeSet<Names>) {
        let mut at = Vec::new();
        for (k, name) in path.iter().enumerate() {
            let Some(module) = self.modules.get(&at) else { break };
            if module.children.contains(name) {
                at.push(name.clone());
                continue;
            }
            let target = module.imports.get(name).and_then(|written| self.absolute(&at, written));
            if let Some(target) = target.filter(|_| depth < 8) {
                if at.len() > 1 {
                    passed.insert(at);
                }
                let target = [target, path[k + 1..].to_vec()].concat();
                return self.follow(&target, depth + 1, passed);
            }
            break;
        }
        passed.insert(at);
    }

    /// Returns the modules that an item with this path belongs to or is re-exported by.
    fn passed(&self, from: &Names, written: &[String]) -> BTreeSet<Names> {
        let mut passed = BTreeSet::new();
        if let Some(path) = self.absolute(from, written) {
            self.follow(&path, 0, &mut passed);
        }
        passed
    }

    fn uses(&self) -> BTreeSet<Use> {
        let mut uses = BTreeSet::new();
        for (from, module) in &self.modules {
            for written in &module.paths {
                let passed = self.passed(from, written).into_iter();
                uses.extend(passed.map(|to| Use { from: from.clone(), to }));
            }
        }
        let unit = |path: &Names| path[..path.len().min(2)].to_vec();
        // No path shows the use of a method that another unit than that of its type adds. Such calls are found by the name of
        // the method, in modules of the room that contain the name of the type.
        for (to, module) in &self.modules {
            for (of, methods) in &module.extended {
                if self.passed(to, of).iter().all(|own| unit(own) == unit(to)) {
                    continue;
                }
                let calls = |from: &Names, module: &Module| {
                    from.first() == to.first()
                        && of.last().is_some_and(|name| module.words.contains(name))
                        && !module.calls.is_disjoint(methods)
                };
                let from = self.modules.iter().filter(|(from, module)| calls(from, module));
                uses.extend(from.map(|(from, _)| Use { from: from.clone(), to: to.clone() }));
            }
        }
        uses
    }

    /// Returns the uses between the units of a room; of the rooms and files of the crate for an empty path.
    fn between_units(&self, room: &[String]) -> BTreeMap<String, BTreeSet<String>> {
        let unit = |path: &Names| {
            let inside = path.strip_prefix(room)?;
            Some(inside.first().map_or("mod.rs", String::as_str).to_owned())
        };
        let mut edges: BTreeMap<String, BTreeSet<String>> = BTreeMap::new();
        for Use { from, to } in self.uses() {
            if let Some((from, to)) = unit(&from).zip(unit(&to)).filter(|(from, to)| from != to) {
                edges.entry(from).or_default().insert(to);
            }
        }
        edges
    }

    /// Returns the groups of units of a room that use each other in a circle, with the uses inside each group.
    fn circles(&self, room: &[String]) -> Vec<BTreeMap<String, BTreeSet<String>>> {
        let edges = self.between_units(room);
        let reached = |from: &String| {
            let mut reached = BTreeSet::new();
            let mut open = vec![from];
            while let Some(next) = open.pop() {
                for to in edges.get(next).into_iter().flatten() {
                    if reached.insert(to.clone()) {
                        open.push(to);
                    }
                }
            }
            reached
        };
        let reached: BTreeMap<&String, BTreeSet<String>> =
            edges.keys().map(|unit| (unit, reached(unit))).collect();
        let groups = edges.keys().map(|unit| {
            let with =
                |other: &&String| reached[unit].contains(*other) && reached[*other].contains(unit);
            edges.keys().filter(with).cloned().collect::<BTreeSet<String>>()
        });
        let groups: BTreeSet<BTreeSet<String>> = groups.filter(|group| !group.is_empty()).collect();
        let inside = |group: &BTreeSet<String>| {
            let of = |unit: &String| (unit.clone(), &edges[unit] & group);
            group.iter().map(of).collect()
        };
        groups.iter().map(inside).collect()
    }
}

/// Reads all sources in a folder and its folders.
fn sources(folder: &Path, path: &[String], all: &mut Sources) {
    for entry in std::fs::read_dir(folder).unwrap() {
        let file = entry.unwrap().path();
        let name = file.file_stem().unwrap().to_string_lossy().into_owned();
        if file.is_dir() {
            sources(&file, &joined(path, &name), all);
        } else if file.extension().is_some_and(|ending| ending == "rs") {
            let is_root = name == "mod" || (path.is_empty() && name == "lib");
            let path = if is_root { path.to_vec() } else { joined(path, &name) };
            all.insert(path, std::fs::read_to_string(&file).unwrap());
        }
    }
}

fn this_house() -> House {
    let mut all = Sources::new();
    sources(&Path::new(env!("CARGO_MANIFEST_DIR")).join("src"), &[], &mut all);
    House::of(&all)
}

#[test]
fn no_room_uses_a_room_above() {
    let house = this_house();
    let floor = |room: &String| FLOORS.iter().position(|rooms| rooms.contains(&room.as_str()));
    let upward = |edge: &&Use| {
        let (Some(from), Some(to)) = (edge.from.first(), edge.to.first()) else { return false };
        let floors = floor(from).zip(floor(to));
        floors.is_some_and(|(own, used)| from != to && own <= used)
    };
    let uses = house.uses();
    assert!(uses.len() > 1000, "{}", uses.len());
    assert_eq!(uses.iter().filter(upward).collect::<Vec<_>>(), Vec::<&Use>::new());
}

#[test]
fn no_units_of_a_room_use_each_other_in_a_circle() {
    let house = this_house();
    let rooms = house.modules[&Vec::new()].children.iter().map(|room| vec![room.clone()]);
    let mut found = Vec::new();
    for room in [Vec::new()].into_iter().chain(rooms) {
        for circle in house.circles(&room) {
            let edges = circle.iter().map(|(unit, uses)| format!("    {unit} uses {uses:?}\n"));
            found.push(format!("{room:?}:\n{}", edges.collect::<String>()));
        }
    }
    assert!(found.is_empty(), "\n{}", found.concat());
}

/// Made-up sources, such as `("a::b", "use crate::c;")`.
fn made_up(files: &[(&str, &str)]) -> House {
    let names = |path: &str| -> Names {
        path.split("::").filter(|name| !name.is_empty()).map(str::to_owned).collect()
    };
    House::of(&files.iter().map(|(path, text)| (names(path), (*text).to_owned())).collect())
}

/// Returns the uses that the code of `room::a` makes, in a room with the units `a`, `b` and `c`; `d` is another room.
fn uses_of(code: &str) -> Vec<String> {
    let house = made_up(&[
        ("", "mod room; pub mod d;"),
        (
            "room",
            "mod a; pub(crate) mod b; mod c; mod e; pub use b::Of; pub(crate) use c::inner::{In as Named, Other};",
        ),
        ("room::a", code),
        ("room::b", "pub struct Of; pub mod deep {}"),
        ("room::c", "pub mod inner; #[cfg(test)] mod not_there;"),
        ("room::c::inner", "pub struct In; pub struct Other;"),
        ("room::e", "pub use crate::room::b::Of as Handed;"),
        ("d", ""),
    ]);
    let path = |path: &Names| path.join("::");
    let from_a = house.uses().into_iter().filter(|edge| path(&edge.from).starts_with("room::a"));
    let mut found: Vec<String> = from_a.map(|edge| path(&edge.to)).collect();
    found.retain(|to| !to.starts_with("room::a"));
    found.dedup();
    found
}

#[test]
fn all_forms_of_imports_are_read() {
    for (code, uses) in [
        ("use crate::room::b::Of;", &["room::b"][..]),
        (
            "use crate::{d, room::{c::inner::{self, In}, b::{deep}}};",
            &["d", "room::b::deep", "room::c::inner"],
        ),
        ("use crate::room::Of;", &["room::b"]),
        ("use crate::room::{Named};", &["room::c::inner"]),
        ("use super::{Of, Other};", &["room::b", "room::c::inner"]),
        ("use super::b::*;", &["room::b"]),
        ("use super::super::d as other; fn f() { other::g() }", &["d"]),
        ("use crate::room::e::Handed;", &["room::b", "room::e"]),
        (
            "pub(in crate::room) fn f() { crate::room::b::g(super::c::h::<u8>()) }",
            &["room::b", "room::c"],
        ),
        ("use crate::room::c; fn f() -> c::inner::In { todo!() }", &["room::c", "room::c::inner"]),
        (
            "mod inside { use super::super::b; mod more { use super::super::super::c; } }",
            &["room::b", "room::c"],
        ),
        ("use std::fmt; use serde::b; fn f() { b::g(); fmt::h() }", &[]),
    ] {
        assert_eq!(uses_of(code), uses, "{code}");
    }
}

#[test]
fn only_comments_texts_and_test_items_are_not_read() {
    for (code, uses) in [
        ("#[cfg(test)] use super::b::{Of, X}; use super::c;", &["room::c"][..]),
        (
            "impl A { #[cfg(test)] #[must_use] fn f(a: [u8; 2]) -> X { super::b::g() } fn h() { super::c::g() } }",
            &["room::c"],
        ),
        ("struct A { #[cfg(test)] x: super::b::Of, y: super::c::inner::In }", &["room::c::inner"]),
        ("#[cfg(test)] mod tests { use super::super::b; } use super::c;", &["room::c"]),
        ("#[cfg(feature = \"gui\")] use super::b;", &["room::b"]),
        (
            "// super::b::x\n/* super::b /* */ super::b::x */ /// super::b::x\nuse super::c;",
            &["room::c"],
        ),
        ("const A: &str = \"super::b::x \\\" super::b::x\"; use super::c;", &["room::c"]),
        ("const A: &str = r#\"super::b::x \" super::b::x\"#; use super::c;", &["room::c"]),
        (
            "fn f<'a>(c: char) -> &'a str { match c { '\"' | '\\'' => super::b::x(), _ => b\"super::c::x\" } }",
            &["room::b"],
        ),
    ] {
        assert_eq!(uses_of(code), uses, "{code}");
    }
}

#[test]
fn circles_of_units_are_found() {
    let circles = |files: &[(&str, &str)]| -> Vec<String> {
        let house = made_up(files);
        let rooms = [Vec::new(), vec!["room".to_owned()]];
        let found = rooms.iter().flat_map(|room| house.circles(room));
        found.map(|circle| circle.into_keys().collect::<Vec<_>>().join(" ")).collect()
    };
    let room = ("room", "mod a; mod b; mod c; pub use c::C;");
    // Through a name that the room re-exports, and through a file in a folder.
    let files = [
        ("", "mod room;"),
        room,
        ("room::a", "use super::b::B;"),
        ("room::b", "mod deep; pub struct B;"),
        ("room::b::deep", "use crate::room::C;"),
        ("room::c", "use crate::room::a; pub struct C;"),
    ];
    assert_eq!(circles(&files), ["a b c"]);
    // A method that `b` adds to the type of `a`, and that `a` calls.
    let files = [
        ("", "mod room;"),
        ("room", "mod a; mod b;"),
        ("room::a", "pub struct A; impl A { fn f(&self) { self.g() } }"),
        ("room::b", "use super::a::A; impl A { pub fn g(&self) {} }"),
    ];
    assert_eq!(circles(&files), ["a b"]);
    // A unit and the room's own file, and two files at the top.
    let files = [
        ("", "mod room; mod top; mod other;"),
        ("room", "mod a; pub struct R; fn f() { a::g() }"),
        ("room::a", "use super::R;"),
        ("top", "use crate::other::x;"),
        ("other", "use crate::top;"),
    ];
    assert_eq!(circles(&files), ["other top", "a mod.rs"]);
    // Uses within a unit and uses of another room are no circle.
    let files = [
        ("", "mod room; mod top;"),
        ("room", "mod a;"),
        ("room::a", "mod x; use x::X; use crate::top;"),
        ("room::a::x", "use super::super::a; pub struct X;"),
        ("top", ""),
    ];
    assert_eq!(circles(&files), Vec::<String>::new());
}
