//! The rooms of the house: which file may know which. Read off the sources, as they are parsed by `syn`.
//!
//! Truths: the tables of rooms in `src/core/solver/mod.rs` and `src/plugin.rs`, whose order is the order of
//! knowing; that no circle of imports joins any files, and none is too long to read; and that the diagrams of
//! `ARCHITECTURE.md` are those of the sources.

use std::{
    collections::{BTreeMap, BTreeSet},
    fs,
    path::{Path, PathBuf},
};

use syn::{
    Attribute, File, ItemMod, ItemUse, UseTree, VisRestricted,
    visit::{self, Visit},
};

/// Lines that a file must not reach.
const LONGEST: usize = 400;

/// A module, by the segments of its path from the crate's root.
type Module = Vec<String>;

/// The modules of a crate, and which names another.
struct Sources {
    root: PathBuf,
    files: BTreeMap<Module, File>,
}

impl Sources {
    /// All files below a folder, whose root is its `lib.rs`. A folder with a manifest is another crate's.
    fn read(root: &str) -> Self {
        let root = Path::new(env!("CARGO_MANIFEST_DIR")).join(root);
        let mut files = BTreeMap::new();
        let mut folders = vec![root.clone()];
        while let Some(folder) = folders.pop() {
            for entry in fs::read_dir(&folder).unwrap() {
                let path = entry.unwrap().path();
                if path.is_dir() && !path.join("Cargo.toml").exists() {
                    folders.push(path);
                } else if path.extension().is_some_and(|extension| extension == "rs") {
                    let text = fs::read_to_string(&path).unwrap();
                    let lines = text.lines().count();
                    assert!(lines < LONGEST, "{} has {lines} lines", path.display());
                    let file = syn::parse_file(&text)
                        .unwrap_or_else(|error| panic!("{}: {error}", path.display()));
                    files.insert(module_of(&root, &path), file);
                }
            }
        }
        assert!(files.len() > 30, "{} holds {} files", root.display(), files.len());
        Self { root, files }
    }

    /// For each module, the others that it names; not those that it is part of.
    fn imports(&self) -> BTreeMap<&Module, BTreeSet<&Module>> {
        let named = |module: &Module| {
            let mut names = Names { module: module.clone(), paths: Vec::new() };
            names.visit_file(&self.files[module]);
            let known = names.paths.into_iter().filter_map(|path| self.nearest(&path));
            known.filter(|other| !module.starts_with(other)).collect()
        };
        self.files.keys().map(|module| (module, named(module))).collect()
    }

    /// The module that a path leads into.
    fn nearest(&self, path: &[String]) -> Option<&Module> {
        let lengths = (0..=path.len()).rev();
        let mut prefixes = lengths.map(|length| path[..length].to_vec());
        let found = prefixes.find(|prefix| self.files.contains_key(prefix))?;
        self.files.get_key_value(&found).map(|(module, _)| module)
    }

    /// The rooms of a table in the documentation of a file, in their order.
    fn rooms(&self, file: &str) -> Vec<String> {
        let text = fs::read_to_string(self.root.join(file)).unwrap();
        let (_, table) = text.split_once("//! # Rooms\n").expect("a heading `Rooms`");
        let (table, _) = table.split_once("//! # ").unwrap_or((table, ""));
        let rows = table.lines().filter_map(|line| line.strip_prefix("//! | `"));
        let rooms: Vec<_> = rows.map(|row| row.split('`').next().unwrap().to_owned()).collect();
        assert!(rooms.len() > 5, "{file} has the rooms {rooms:?}");
        rooms
    }
}

fn module_of(root: &Path, path: &Path) -> Module {
    let path = path.strip_prefix(root).unwrap().with_extension("");
    let mut module: Module = path.iter().map(|part| part.to_str().unwrap().to_owned()).collect();
    if matches!(module.last().map(String::as_str), Some("mod" | "lib")) {
        module.pop();
    }
    module
}

/// Collects the paths into the crate itself that a file names, but for those of its tests.
struct Names {
    module: Module,
    paths: Vec<Vec<String>>,
}

impl Names {
    fn take(&mut self, segments: &[String]) {
        let Some((first, mut rest)) = segments.split_first() else { return };
        let mut path = match first.as_str() {
            "crate" => Vec::new(),
            "self" => self.module.clone(),
            "super" => {
                let mut path = self.module.clone();
                path.pop();
                while let Some((_, others)) = rest.split_first().filter(|(it, _)| *it == "super") {
                    path.pop();
                    rest = others;
                }
                path
            }
            _ => return,
        };
        path.extend(rest.iter().cloned());
        self.paths.push(path);
    }

    fn take_tree(&mut self, tree: &UseTree, before: &mut Vec<String>) {
        match tree {
            UseTree::Path(path) => {
                before.push(path.ident.to_string());
                self.take_tree(&path.tree, before);
                before.pop();
            }
            UseTree::Group(group) => {
                group.items.iter().for_each(|tree| self.take_tree(tree, before));
            }
            UseTree::Name(name) => self.take(&[&before[..], &[name.ident.to_string()]].concat()),
            UseTree::Rename(name) => self.take(&[&before[..], &[name.ident.to_string()]].concat()),
            UseTree::Glob(_) => self.take(before),
        }
    }
}

fn is_of_tests(attributes: &[Attribute]) -> bool {
    let is_test = |attribute: &Attribute| {
        let cfg = attribute.path().is_ident("cfg").then(|| attribute.meta.require_list());
        cfg.is_some_and(|list| list.is_ok_and(|list| list.tokens.to_string() == "test"))
    };
    attributes.iter().any(is_test)
}

impl<'a> Visit<'a> for Names {
    fn visit_item_use(&mut self, item: &'a ItemUse) {
        self.take_tree(&item.tree, &mut Vec::new());
    }

    fn visit_path(&mut self, path: &'a syn::Path) {
        let segments: Vec<_> = path.segments.iter().map(|it| it.ident.to_string()).collect();
        self.take(&segments);
        visit::visit_path(self, path);
    }

    fn visit_item_mod(&mut self, item: &'a ItemMod) {
        if !is_of_tests(&item.attrs) {
            // A module within the file is part of it.
            self.module.push(item.ident.to_string());
            visit::visit_item_mod(self, item);
            self.module.pop();
        }
    }

    /// To be seen by another is not to know it.
    fn visit_vis_restricted(&mut self, _: &'a VisRestricted) {}
}

/// Files that are in circles, or on a way from one to another.
fn circles<'a>(imports: &BTreeMap<&'a Module, BTreeSet<&'a Module>>) -> Vec<&'a Module> {
    let mut left = imports.clone();
    loop {
        // What names none of those left is in no circle, nor is what none of them names.
        let is_named = |module: &&Module| left.values().any(|named| named.contains(*module));
        let names = |named: &BTreeSet<&Module>| named.iter().any(|other| left.contains_key(*other));
        let inside = left.iter().filter(|(module, named)| names(named) && is_named(module));
        let inside: BTreeMap<_, _> =
            inside.map(|(module, named)| (*module, named.clone())).collect();
        if inside.len() == left.len() {
            return left.into_keys().collect();
        }
        left = inside;
    }
}

#[test]
fn no_circle_of_imports_joins_any_files() {
    for root in ["src/core", "src"] {
        let sources = Sources::read(root);
        let imports = sources.imports();
        let count: usize = imports.values().map(BTreeSet::len).sum();
        assert!(count > 100, "{root}: {count} imports were found");
        let circles = circles(&imports);
        assert!(circles.is_empty(), "in {root}, imports go round through {circles:?}");
    }
}

/// The rooms of a folder of a crate, as a table in the documentation of a file has them. What is in no room of the table
/// is in its last.
struct Rooms {
    root: &'static str,
    folder: &'static [&'static str],
    file: &'static str,
}

const SOLVER: Rooms = Rooms { root: "src/core", folder: &["solver"], file: "solver/mod.rs" };
const PLUGIN: Rooms = Rooms { root: "src", folder: &[], file: "plugin.rs" };

impl Rooms {
    /// Their names in order, and which of them import from which, each with an example.
    fn read(&self) -> (Vec<String>, BTreeMap<(usize, usize), [String; 2]>) {
        let sources = Sources::read(self.root);
        let names = sources.rooms(self.file);
        let room = |module: &Module| {
            let is_inside = module.len() >= self.folder.len()
                && module.iter().zip(self.folder).all(|(a, b)| a == b);
            let name = module.get(self.folder.len());
            let known = name.and_then(|name| names.iter().position(|room| room == name));
            is_inside.then(|| known.unwrap_or(names.len() - 1))
        };
        let mut imports = BTreeMap::new();
        for (module, others) in sources.imports() {
            for other in others {
                if let (Some(own), Some(known)) = (room(module), room(other)) {
                    let example = || [module.join("::"), other.join("::")];
                    imports.entry((own, known)).or_insert_with(example);
                }
            }
        }
        (names, imports)
    }

    fn know_only_those_above(&self) {
        let (names, imports) = self.read();
        for ((own, known), [module, other]) in imports {
            assert!(
                known <= own,
                "`{module}` of the room `{}` imports from `{other}`, but `{}` comes after it in {}/{}",
                names[own],
                names[known],
                self.root,
                self.file,
            );
        }
    }

    /// A diagram in Mermaid's language: from each room to those that it knows, but for those that it knows by way of another.
    fn diagram(&self) -> String {
        let (names, imports) = self.read();
        let knows = |own: usize, known: usize| own != known && imports.contains_key(&(own, known));
        let mut text = String::from("```mermaid\ngraph RL\n");
        for own in 0..names.len() {
            // What the rooms know that this one knows, directly or not: a later room is known by later ones alone.
            let mut behind = BTreeSet::new();
            for known in (0..own).rev().filter(|&known| knows(own, known)) {
                if !behind.contains(&known) {
                    text += &format!("    {} --> {}\n", names[own], names[known]);
                }
                let mut front = vec![known];
                while let Some(at) = front.pop() {
                    front.extend((0..at).filter(|&next| knows(at, next) && behind.insert(next)));
                }
            }
        }
        text + "```\n"
    }
}

#[test]
fn the_diagrams_show_the_rooms_as_they_are() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("ARCHITECTURE.md");
    let text = fs::read_to_string(path).unwrap();
    for rooms in [SOLVER, PLUGIN] {
        let diagram = rooms.diagram();
        assert!(diagram.lines().count() > 10, "{} has hardly any imports", rooms.root);
        assert!(text.contains(&diagram), "ARCHITECTURE.md is to have this diagram:\n{diagram}");
    }
}

/// What a crate re-exports at its root hides where it is from.
#[test]
fn nothing_is_imported_by_way_of_the_root() {
    const CORE: [&str; 3] = ["hang", "sdf", "solver"];
    let sources = Sources::read("src");
    for (module, file) in sources.files.iter().filter(|(module, _)| !module.is_empty()) {
        let mut names = Names { module: module.clone(), paths: Vec::new() };
        names.visit_file(file);
        let by_root = |path: &&Vec<String>| sources.nearest(path).is_some_and(Vec::is_empty);
        for path in names.paths.iter().filter(by_root) {
            let is_core = path.first().is_some_and(|first| CORE.contains(&first.as_str()));
            assert!(is_core, "`{}` imports `crate::{}`", module.join("::"), path.join("::"));
        }
    }
}

#[test]
fn rooms_of_the_solver_know_only_those_above_them() {
    SOLVER.know_only_those_above();
}

#[test]
fn rooms_of_the_plugin_know_only_those_above_them() {
    PLUGIN.know_only_those_above();
}
