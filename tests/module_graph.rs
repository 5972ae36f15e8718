//! The graph of files: which file uses an item that another file of its crate defines, read from the source text.
//!
//! Re-exports are followed to the file that defines the item, so a head that only declares and re-exports has no arrow in either direction.
//! Calls of methods are not seen, nor are items under `#[cfg(test)]`.

use std::collections::{BTreeMap, BTreeSet, HashMap, HashSet};
use std::path::{Path, PathBuf};

use proc_macro2::{Delimiter, TokenStream, TokenTree};
use syn::visit::{self, Visit};
use syn::{Attribute, Item, ItemUse, Meta, UseTree, Visibility};

/// Files of one crate and the arrows between them.
pub struct FileGraph {
    pub files: Vec<PathBuf>,
    /// Items that make each arrow, by the file that uses and the file that defines.
    pub arrows: BTreeMap<(usize, usize), BTreeSet<String>>,
}

impl FileGraph {
    /// Of the crate whose root is this file.
    pub fn of_crate(root: &Path) -> Self {
        let mut modules = Modules::default();
        modules.load_file(root, None);
        let mut arrows = BTreeMap::new();
        for (module, bodies) in modules.bodies.iter().enumerate() {
            let mut uses = Uses {
                modules: &modules,
                module,
                arrows: &mut arrows,
            };
            bodies.iter().for_each(|item| uses.visit_item(item));
        }
        let Modules { files, .. } = modules;
        Self { files, arrows }
    }

    /// Sets of files of which each uses every other, directly or through others.
    pub fn circles(&self) -> Vec<Vec<usize>> {
        let reached: Vec<HashSet<usize>> =
            (0..self.files.len()).map(|at| self.reached(at)).collect();
        let mut circles = Vec::new();
        let mut seen = HashSet::new();
        for at in 0..self.files.len() {
            let of_circle =
                |other: &usize| reached[at].contains(other) && reached[*other].contains(&at);
            let circle: Vec<usize> = (0..self.files.len()).filter(of_circle).collect();
            if circle.len() > 1 && seen.insert(circle[0]) {
                circles.push(circle);
            }
        }
        circles
    }

    fn reached(&self, start: usize) -> HashSet<usize> {
        let (mut reached, mut open) = (HashSet::new(), vec![start]);
        while let Some(at) = open.pop() {
            for &(_, to) in self
                .arrows
                .range((at, 0)..(at + 1, 0))
                .map(|(arrow, _)| arrow)
            {
                if reached.insert(to) {
                    open.push(to);
                }
            }
        }
        reached
    }

    /// The arrows within a circle, with what makes them; paths are written from `source`.
    pub fn describe(&self, circle: &[usize], source: &Path) -> String {
        let name = |at: usize| {
            self.files[at]
                .strip_prefix(source)
                .unwrap_or(&self.files[at])
                .display()
        };
        let mut text = format!("circle of {} files\n", circle.len());
        for (&(from, to), items) in &self.arrows {
            if circle.contains(&from) && circle.contains(&to) {
                let items: Vec<&str> = items.iter().map(String::as_str).collect();
                text += &format!("  {} -> {}: {}\n", name(from), name(to), items.join(", "));
            }
        }
        text
    }
}

/// What a name in a module stands for.
enum Binding {
    Item,
    Module(usize),
    Import(Vec<String>),
}

/// What a path leads to.
#[derive(Clone)]
enum Target {
    Module(usize),
    Item { file: usize, name: String },
}

#[derive(Default)]
struct Module {
    file: usize,
    parent: Option<usize>,
    names: HashMap<String, Vec<Binding>>,
    globs: Vec<Vec<String>>,
    /// True where macros are called, which may define further names.
    calls_macros: bool,
}

/// Modules of a crate; the first is its root.
#[derive(Default)]
struct Modules {
    files: Vec<PathBuf>,
    modules: Vec<Module>,
    /// Items of each module, without its child modules.
    bodies: Vec<Vec<Item>>,
}

impl Modules {
    fn load_file(&mut self, path: &Path, parent: Option<usize>) -> usize {
        let text =
            std::fs::read_to_string(path).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
        let parsed = syn::parse_file(&text).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
        let file = self.files.len();
        self.files.push(path.to_owned());
        let stem = path.file_stem().unwrap_or_default();
        let folder = path.parent().unwrap_or(Path::new(""));
        let is_head = ["mod", "lib", "main"].iter().any(|head| stem == *head);
        let children = if is_head {
            folder.to_owned()
        } else {
            folder.join(stem)
        };
        self.load(parsed.items, file, parent, &children)
    }

    fn load(
        &mut self,
        items: Vec<Item>,
        file: usize,
        parent: Option<usize>,
        folder: &Path,
    ) -> usize {
        let at = self.modules.len();
        self.modules.push(Module {
            file,
            parent,
            ..Module::default()
        });
        self.bodies.push(Vec::new());
        for item in items {
            if is_test(attributes(&item)) {
                continue;
            }
            if let Item::Mod(module) = item {
                let name = module.ident.to_string();
                let child = match module.content {
                    Some((_, items)) => self.load(items, file, Some(at), &folder.join(&name)),
                    None => {
                        let alone = folder.join(format!("{name}.rs"));
                        let path = if alone.exists() {
                            alone
                        } else {
                            folder.join(&name).join("mod.rs")
                        };
                        self.load_file(&path, Some(at))
                    }
                };
                self.bind(at, name, Binding::Module(child));
                continue;
            }
            for name in defined(&item) {
                self.bind(at, name, Binding::Item);
            }
            self.modules[at].calls_macros |= matches!(&item, Item::Macro(m) if m.ident.is_none());
            let mut imports = Imports::default();
            imports.visit_item(&item);
            for (name, path) in imports.names {
                self.bind(at, name, Binding::Import(path));
            }
            self.modules[at].globs.extend(imports.globs);
            self.bodies[at].push(item);
        }
        at
    }

    fn bind(&mut self, module: usize, name: String, binding: Binding) {
        self.modules[module]
            .names
            .entry(name)
            .or_default()
            .push(binding);
    }

    /// What a name stands for; `seen` stops imports that lead to themselves.
    fn look_up(
        &self,
        module: usize,
        name: &str,
        seen: &mut HashSet<(usize, String)>,
    ) -> Vec<Target> {
        if !seen.insert((module, name.to_owned())) {
            return Vec::new();
        }
        let Module {
            file, names, globs, ..
        } = &self.modules[module];
        let mut found = Vec::new();
        for binding in names.get(name).into_iter().flatten() {
            match binding {
                Binding::Item => found.push(Target::Item {
                    file: *file,
                    name: name.to_owned(),
                }),
                Binding::Module(child) => found.push(Target::Module(*child)),
                Binding::Import(path) => found.extend(self.follow(module, path, seen)),
            }
        }
        if found.is_empty() {
            for glob in globs {
                for target in self.follow(module, glob, seen) {
                    if let Target::Module(other) = target {
                        found.extend(self.look_up(other, name, seen));
                    }
                }
            }
        }
        found
    }

    /// What a path written in a module leads to: nothing in other crates.
    fn follow(
        &self,
        module: usize,
        path: &[String],
        seen: &mut HashSet<(usize, String)>,
    ) -> Vec<Target> {
        let mut targets = vec![Target::Module(module)];
        for (number, segment) in path.iter().enumerate() {
            let next = |target: Target| match (target, segment.as_str()) {
                (Target::Module(_), "crate") if number == 0 => vec![Target::Module(0)],
                (Target::Module(at), "self") => vec![Target::Module(at)],
                (Target::Module(at), "super") => self.modules[at]
                    .parent
                    .map(Target::Module)
                    .into_iter()
                    .collect(),
                (Target::Module(at), name) => {
                    let Module {
                        file,
                        names,
                        calls_macros,
                        ..
                    } = &self.modules[at];
                    let found = self.look_up(at, name, seen);
                    if found.is_empty() && number > 0 && *calls_macros && !names.contains_key(name)
                    {
                        // What else could it be, where the crate compiles?
                        vec![Target::Item {
                            file: *file,
                            name: name.to_owned(),
                        }]
                    } else {
                        found
                    }
                }
                (item, _) => vec![item],
            };
            targets = targets.into_iter().flat_map(next).collect();
        }
        targets
    }
}

/// Names that `use` brings in, at any depth of an item.
#[derive(Default)]
struct Imports {
    names: Vec<(String, Vec<String>)>,
    globs: Vec<Vec<String>>,
}

impl<'a> Visit<'a> for Imports {
    fn visit_item_use(&mut self, item: &'a ItemUse) {
        self.collect(&item.tree, &mut Vec::new());
    }
}

impl Imports {
    fn collect(&mut self, tree: &UseTree, path: &mut Vec<String>) {
        let mut add = |last: String, name: String| {
            let mut whole = path.clone();
            if last != "self" {
                whole.push(last);
            }
            let name = if name == "self" {
                whole.last().cloned().unwrap_or_default()
            } else {
                name
            };
            self.names.push((name, whole));
        };
        match tree {
            UseTree::Name(name) => add(name.ident.to_string(), name.ident.to_string()),
            UseTree::Rename(renamed) => add(renamed.ident.to_string(), renamed.rename.to_string()),
            UseTree::Glob(_) => self.globs.push(path.clone()),
            UseTree::Group(group) => group.items.iter().for_each(|tree| self.collect(tree, path)),
            UseTree::Path(next) => {
                path.push(next.ident.to_string());
                self.collect(&next.tree, path);
                path.pop();
            }
        }
    }
}

/// Finds the arrows that items of a module make.
struct Uses<'a> {
    modules: &'a Modules,
    module: usize,
    arrows: &'a mut BTreeMap<(usize, usize), BTreeSet<String>>,
}

impl Uses<'_> {
    fn add(&mut self, path: &[String]) {
        for target in self.follow(path) {
            if let Target::Item { file, name } = target {
                self.add_arrow(file, name);
            }
        }
    }

    fn follow(&self, path: &[String]) -> Vec<Target> {
        self.modules.follow(self.module, path, &mut HashSet::new())
    }

    fn add_arrow(&mut self, file: usize, name: String) {
        let from = self.modules.modules[self.module].file;
        if file != from {
            self.arrows.entry((from, file)).or_default().insert(name);
        }
    }

    /// Paths among the tokens of a macro, whose grammar is not known.
    fn scan(&mut self, tokens: TokenStream) {
        let mut path: Vec<String> = Vec::new();
        let mut before = [' '; 2];
        for token in tokens {
            let mark = match &token {
                TokenTree::Punct(mark) => mark.as_char(),
                _ => ' ',
            };
            if let TokenTree::Ident(name) = &token {
                match before {
                    [':', ':'] if !path.is_empty() => {}
                    [':', ':'] | [_, '.'] => {
                        before = [' '; 2];
                        continue;
                    }
                    _ => self.add(&std::mem::take(&mut path)),
                }
                path.push(name.to_string());
            } else if mark != ':' {
                self.add(&std::mem::take(&mut path));
            }
            if let TokenTree::Group(group) = token {
                self.scan(group.stream());
            }
            before = [before[1], mark];
        }
        self.add(&path);
    }
}

impl<'a> Visit<'a> for Uses<'_> {
    fn visit_item(&mut self, item: &'a Item) {
        if !is_test(attributes(item)) {
            visit::visit_item(self, item);
        }
    }

    fn visit_impl_item_fn(&mut self, function: &'a syn::ImplItemFn) {
        if !is_test(&function.attrs) {
            visit::visit_impl_item_fn(self, function);
        }
    }

    fn visit_item_use(&mut self, item: &'a ItemUse) {
        // A re-export is no use.
        if matches!(item.vis, Visibility::Inherited) {
            let mut imports = Imports::default();
            imports.collect(&item.tree, &mut Vec::new());
            let names = imports.names.into_iter().map(|(_, path)| path);
            names.chain(imports.globs).for_each(|path| self.add(&path));
        }
    }

    fn visit_path(&mut self, path: &'a syn::Path) {
        if path.leading_colon.is_none() {
            self.add(&names_of(path));
        }
        visit::visit_path(self, path);
    }

    fn visit_macro(&mut self, called: &'a syn::Macro) {
        self.visit_path(&called.path);
        self.scan(called.tokens.clone());
    }

    /// Functions that derived code calls, or modules that hold them: `#[serde(with = "path::to::module")]`.
    fn visit_attribute(&mut self, attribute: &'a Attribute) {
        let Meta::List(list) = &attribute.meta else {
            return;
        };
        for token in list.tokens.clone() {
            if let TokenTree::Literal(text) = token
                && let Ok(text) = syn::parse_str::<syn::LitStr>(&text.to_string())
                && let Ok(path) = text.parse::<syn::Path>()
                && path.segments.len() > 1
            {
                let path = names_of(&path);
                self.add(&path);
                for target in self.follow(&path) {
                    if let Target::Module(at) = target {
                        self.add_arrow(self.modules.modules[at].file, path.join("::"));
                    }
                }
            }
        }
    }
}

fn names_of(path: &syn::Path) -> Vec<String> {
    path.segments.iter().map(|s| s.ident.to_string()).collect()
}

fn attributes(item: &Item) -> &[Attribute] {
    match item {
        Item::Const(item) => &item.attrs,
        Item::Enum(item) => &item.attrs,
        Item::Fn(item) => &item.attrs,
        Item::Impl(item) => &item.attrs,
        Item::Macro(item) => &item.attrs,
        Item::Mod(item) => &item.attrs,
        Item::Static(item) => &item.attrs,
        Item::Struct(item) => &item.attrs,
        Item::Trait(item) => &item.attrs,
        Item::Type(item) => &item.attrs,
        Item::Use(item) => &item.attrs,
        _ => &[],
    }
}

/// `#[cfg(test)]`, `#[cfg(all(test, ...))]`.
fn is_test(attributes: &[Attribute]) -> bool {
    attributes.iter().any(|attribute| {
        let Meta::List(list) = &attribute.meta else {
            return false;
        };
        let condition = list.tokens.to_string();
        let mut words = condition.split(|c: char| !c.is_alphanumeric());
        list.path.is_ident("cfg") && words.any(|word| word == "test") && !condition.contains("not")
    })
}

/// Names that an item defines; of a macro that is called those before braces and before an equals sign.
fn defined(item: &Item) -> Vec<String> {
    let name = match item {
        Item::Const(item) => &item.ident,
        Item::Enum(item) => &item.ident,
        Item::Fn(item) => &item.sig.ident,
        Item::Static(item) => &item.ident,
        Item::Struct(item) => &item.ident,
        Item::Trait(item) => &item.ident,
        Item::TraitAlias(item) => &item.ident,
        Item::Type(item) => &item.ident,
        Item::Union(item) => &item.ident,
        Item::Macro(item) => match &item.ident {
            Some(name) => name,
            None => return defined_by_call(item.mac.tokens.clone()),
        },
        _ => return Vec::new(),
    };
    vec![name.to_string()]
}

fn defined_by_call(tokens: TokenStream) -> Vec<String> {
    let tokens: Vec<TokenTree> = tokens.into_iter().collect();
    let named = |pair: &[TokenTree]| match pair {
        [TokenTree::Ident(name), TokenTree::Group(body)] => {
            (body.delimiter() == Delimiter::Brace).then(|| name.to_string())
        }
        [TokenTree::Ident(name), TokenTree::Punct(mark)] => {
            (mark.as_char() == '=').then(|| name.to_string())
        }
        _ => None,
    };
    tokens.windows(2).filter_map(named).collect()
}
