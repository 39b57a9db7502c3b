//! What a source file names, writes and leaves to configuration: read from its syntax, tests of its own aside.

use std::path::{Path, PathBuf};

use syn::visit::{self, Visit};

/// What the walls ask of one file.
#[derive(Debug, Default)]
pub struct Source {
    /// Every path in the code and in `use` lines, from its first name on.
    pub paths: Vec<Vec<String>>,
    /// `#[cfg]` and `cfg!` inside function bodies.
    pub cfgs_in_bodies: usize,
    bodies: usize,
}

/// The workspace's folder.
pub fn workspace() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).parent().expect("the package lies in the workspace").to_owned()
}

/// All files with this ending in a folder and below, sorted.
pub fn files(folder: &Path, ending: &str) -> Vec<PathBuf> {
    let Ok(entries) = std::fs::read_dir(folder) else { return Vec::new() };
    let mut files: Vec<PathBuf> = Vec::new();
    for path in entries.filter_map(|entry| Some(entry.ok()?.path())) {
        if path.is_dir() {
            files.extend(self::files(&path, ending));
        } else if path.extension().is_some_and(|found| found == ending) {
            files.push(path);
        }
    }
    files.sort();
    files
}

pub fn read(file: &Path) -> Source {
    let text = std::fs::read_to_string(file).unwrap_or_else(|error| panic!("{}: {error}", file.display()));
    let syntax = syn::parse_file(&text).unwrap_or_else(|error| panic!("{}: {error}", file.display()));
    let mut source = Source::default();
    source.visit_file(&syntax);
    source
}

impl Source {
    /// The rooms of its crate that a file names, as `crate::ROOM` or by as many `super`s as lead there.
    /// `depth`: how many modules the file lies below the crate's root.
    pub fn rooms(&self, depth: usize) -> impl Iterator<Item = &str> {
        self.paths.iter().filter_map(move |path| {
            let supers = path.iter().take_while(|name| *name == "super").count();
            match path[0].as_str() {
                "crate" => path.get(1),
                _ if supers >= depth => path.get(supers),
                _ => None,
            }
            .map(String::as_str)
        })
    }

    /// Whether a path holds these names, one after the other.
    pub fn names(&self, names: &[&str]) -> bool {
        self.paths.iter().any(|path| path.windows(names.len()).any(|part| part == names))
    }

    fn use_tree(&mut self, tree: &syn::UseTree, before: &[String]) {
        let with = |name: &syn::Ident| [before, &[name.to_string()]].concat();
        match tree {
            syn::UseTree::Path(path) => self.use_tree(&path.tree, &with(&path.ident)),
            syn::UseTree::Name(name) => self.paths.push(with(&name.ident)),
            syn::UseTree::Rename(rename) => self.paths.push(with(&rename.ident)),
            syn::UseTree::Glob(_) => self.paths.push(before.to_vec()),
            syn::UseTree::Group(group) => group.items.iter().for_each(|tree| self.use_tree(tree, before)),
        }
    }
}

impl<'ast> Visit<'ast> for Source {
    fn visit_item_mod(&mut self, module: &'ast syn::ItemMod) {
        let of_tests = |attribute: &syn::Attribute| {
            attribute.path().is_ident("cfg")
                && attribute.parse_args::<syn::Path>().is_ok_and(|path| path.is_ident("test"))
        };
        if !module.attrs.iter().any(of_tests) {
            visit::visit_item_mod(self, module);
        }
    }

    fn visit_item_use(&mut self, item: &'ast syn::ItemUse) {
        self.use_tree(&item.tree, &[]);
    }

    fn visit_path(&mut self, path: &'ast syn::Path) {
        self.paths.push(path.segments.iter().map(|segment| segment.ident.to_string()).collect());
        visit::visit_path(self, path);
    }

    fn visit_block(&mut self, block: &'ast syn::Block) {
        self.bodies += 1;
        visit::visit_block(self, block);
        self.bodies -= 1;
    }

    fn visit_attribute(&mut self, attribute: &'ast syn::Attribute) {
        self.cfgs_in_bodies += usize::from(self.bodies > 0 && attribute.path().is_ident("cfg"));
    }

    fn visit_macro(&mut self, call: &'ast syn::Macro) {
        self.cfgs_in_bodies += usize::from(self.bodies > 0 && call.path.is_ident("cfg"));
        visit::visit_macro(self, call);
    }
}
