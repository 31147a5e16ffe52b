//! Structure of a crate: files and rooms that name each other, types that are spread over many files,
//! functions that take the whole of a type.
//!
//! Files are read with `syn`. An edge is an import, a path in the text, or the call of a method of `self` or
//! of an argument whose type has that method in another file. Tests do not count. A path through a re-export
//! leads to the file that defines the item.

use std::collections::{BTreeMap, BTreeSet};

use petgraph::algo::tarjan_scc;
use petgraph::graphmap::DiGraphMap;
use syn::visit::{self, Visit};

use crate::package::{Package, is_for_tests};

/// Most files with an `impl` of one type.
const MOST_IMPL_FILES: usize = 3;

/// Facts of a crate that a rule needs.
#[derive(Debug, Default)]
pub struct Structure {
    /// By file, those that it names.
    edges: BTreeMap<String, BTreeSet<String>>,
    /// By type, the files that have an `impl` of it.
    impls: BTreeMap<String, BTreeSet<String>>,
    /// By type, the functions that take the whole of it: file and name.
    takers: BTreeMap<String, Vec<(String, String)>>,
}

impl Structure {
    /// Reads the structure of a package, its tests excepted.
    pub fn read(package: &Package) -> Self {
        Self::of(&package.product().map(|file| (file.name.as_str(), &file.syntax)).collect())
    }

    fn of(files: &BTreeMap<&str, &syn::File>) -> Self {
        let mut facts: BTreeMap<&str, Facts> = BTreeMap::new();
        for (name, file) in files {
            let mut found = Facts::default();
            found.visit_file(file);
            facts.insert(name, found);
        }
        let modules: BTreeMap<Vec<String>, &str> = files
            .keys()
            .filter(|name| **name != "main.rs" || !files.contains_key("lib.rs"))
            .map(|name| (module_of(name), *name))
            .collect();
        let mut definers: BTreeMap<&(String, String), &str> = BTreeMap::new();
        for (name, found) in &facts {
            definers.extend(found.methods.iter().map(|method| (method, *name)));
        }
        let mut structure = Self::default();
        for (name, found) in &facts {
            let here = module_of(name);
            let mut named = BTreeSet::new();
            for path in &found.paths {
                named.extend(resolve(path, &here, &modules, &facts, 0));
            }
            named.extend(found.calls.iter().filter_map(|call| definers.get(call)).map(|file| (*file).to_owned()));
            named.remove(*name);
            structure.edges.insert((*name).to_owned(), named);
            for subject in &found.impls {
                structure.impls.entry(subject.clone()).or_default().insert((*name).to_owned());
            }
            for (whole, function) in &found.takes {
                structure.takers.entry(whole.clone()).or_default().push(((*name).to_owned(), function.clone()));
            }
        }
        structure
    }

    /// Types with methods in too many files.
    pub fn spread(&self) -> impl Iterator<Item = String> {
        self.impls.iter().filter(|(_, files)| files.len() > MOST_IMPL_FILES).map(|(name, files)| {
            let list: Vec<&str> = files.iter().map(String::as_str).collect();
            format!("{name} has methods in {} files: {}", files.len(), list.join(" "))
        })
    }

    /// Functions that take the whole of a type, each with its file.
    pub fn takers(&self, whole: &str) -> &[(String, String)] {
        self.takers.get(whole).map_or(&[], Vec::as_slice)
    }

    /// Files that need each other, largest first.
    pub fn circles(&self) -> Vec<Vec<&str>> {
        circles(self.arrows())
    }

    /// Rooms that need each other, largest first: the files and folders at the top of a crate.
    pub fn circles_of_rooms(&self) -> Vec<Vec<&str>> {
        circles(self.arrows().map(|(from, to)| (room_of(from), room_of(to))).filter(|(from, to)| from != to))
    }

    /// Every pair of files of which the first names the second.
    pub fn arrows(&self) -> impl Iterator<Item = (&str, &str)> {
        self.edges.iter().flat_map(|(file, named)| named.iter().map(move |other| (file.as_str(), other.as_str())))
    }
}

/// Groups of more than one node that lead to each other, largest first.
fn circles<'a>(arrows: impl Iterator<Item = (&'a str, &'a str)>) -> Vec<Vec<&'a str>> {
    let graph: DiGraphMap<&str, ()> = arrows.map(|(from, to)| (from, to, ())).collect();
    let mut circles: Vec<Vec<&str>> = tarjan_scc(&graph).into_iter().filter(|circle| circle.len() > 1).collect();
    circles.iter_mut().for_each(|circle| circle.sort_unstable());
    circles.sort_by_key(|circle| std::cmp::Reverse(circle.len()));
    circles
}

/// The first folder of a file's path, or the file's own name.
fn room_of(file: &str) -> &str {
    file.split('/').next().unwrap_or(file).trim_end_matches(".rs")
}

/// `homing/slaves.rs` is `homing::slaves`, `homing/mod.rs` is `homing`, `lib.rs` is the crate.
pub fn module_of(name: &str) -> Vec<String> {
    let mut parts: Vec<String> = name.trim_end_matches(".rs").split('/').map(str::to_owned).collect();
    if parts.last().is_some_and(|last| last == "mod" || last == "lib" || last == "main") {
        parts.pop();
    }
    parts
}

/// The file that a path leads to, if it is one of the crate. What a file re-exports is found where it is
/// defined.
fn resolve(
    path: &[String],
    here: &[String],
    modules: &BTreeMap<Vec<String>, &str>,
    facts: &BTreeMap<&str, Facts>,
    depth: usize,
) -> Option<String> {
    let mut at = here.to_vec();
    let mut rest = path;
    match rest.first()?.as_str() {
        "crate" => {
            at.clear();
            rest = rest.get(1..)?;
        }
        "self" => rest = rest.get(1..)?,
        "super" => {
            while rest.first().is_some_and(|part| part == "super") {
                at.pop()?;
                rest = rest.get(1..)?;
            }
        }
        first => {
            // A child module, or something from elsewhere.
            let child: Vec<String> = at.iter().cloned().chain([first.to_owned()]).collect();
            modules.get(&child)?;
        }
    }
    while let Some(next) = rest.first() {
        at.push(next.clone());
        if !modules.contains_key(&at) {
            at.pop();
            break;
        }
        rest = rest.get(1..)?;
    }
    let file = *modules.get(&at)?;
    let item = rest.first();
    let onward = item.and_then(|item| facts.get(file)?.reexports.iter().find(|(name, _)| name == item));
    match onward {
        Some((_, path)) if depth < 4 => resolve(path, &at, modules, facts, depth + 1).or(Some(file.to_owned())),
        _ => Some(file.to_owned()),
    }
}

/// Names that a file declares and uses.
#[derive(Debug, Default)]
struct Facts {
    paths: BTreeSet<Vec<String>>,
    /// Names that it imports or gives on, and where they are from.
    reexports: Vec<(String, Vec<String>)>,
    /// Methods that it defines and those that it calls, each with its type.
    methods: BTreeSet<(String, String)>,
    calls: BTreeSet<(String, String)>,
    /// While reading: the type whose `impl` this is, and what the arguments at hand are.
    subject: Option<String>,
    arguments: Vec<(String, String)>,
    impls: BTreeSet<String>,
    /// Types that a function takes, and its name.
    takes: Vec<(String, String)>,
}

impl Facts {
    fn import(&mut self, tree: &syn::UseTree, so_far: &[String], gives_on: bool) {
        let with = |part: &syn::Ident| so_far.iter().cloned().chain([part.to_string()]).collect::<Vec<_>>();
        match tree {
            syn::UseTree::Path(path) => self.import(&path.tree, &with(&path.ident), gives_on),
            syn::UseTree::Group(group) => group.items.iter().for_each(|tree| self.import(tree, so_far, gives_on)),
            syn::UseTree::Name(name) if name.ident == "self" => drop(self.paths.insert(so_far.to_vec())),
            syn::UseTree::Name(name) => self.imported(name.ident.to_string(), with(&name.ident), gives_on),
            syn::UseTree::Rename(name) => self.imported(name.rename.to_string(), with(&name.ident), gives_on),
            syn::UseTree::Glob(_) => drop(self.paths.insert(so_far.to_vec())),
        }
    }

    /// An imported name can be used by the modules below, too.
    fn imported(&mut self, name: String, path: Vec<String>, gives_on: bool) {
        if !gives_on {
            self.paths.insert(path.clone());
        }
        self.reexports.push((name, path));
    }

    fn signature(&mut self, signature: &syn::Signature) {
        self.arguments.clear();
        for input in &signature.inputs {
            let syn::FnArg::Typed(argument) = input else { continue };
            let mut types = Types::default();
            types.visit_type(&argument.ty);
            let syn::Pat::Ident(pattern) = &*argument.pat else { continue };
            self.arguments.extend(types.0.first().map(|taken| (pattern.ident.to_string(), taken.clone())));
            self.takes.extend(types.0.into_iter().map(|taken| (taken, signature.ident.to_string())));
        }
    }

    fn type_of(&self, receiver: &syn::Expr) -> Option<String> {
        let syn::Expr::Path(path) = receiver else { return None };
        let name = path.path.get_ident()?.to_string();
        if name == "self" {
            return self.subject.clone();
        }
        self.arguments.iter().find(|(argument, _)| *argument == name).map(|(_, taken)| taken.clone())
    }
}

/// The last part of every type's path.
#[derive(Default)]
struct Types(Vec<String>);

impl<'a> Visit<'a> for Types {
    fn visit_type_path(&mut self, path: &'a syn::TypePath) {
        self.0.extend(path.path.segments.last().map(|segment| segment.ident.to_string()));
        visit::visit_type_path(self, path);
    }
}

impl<'a> Visit<'a> for Facts {
    fn visit_item_mod(&mut self, module: &'a syn::ItemMod) {
        if !is_for_tests(&module.attrs) {
            visit::visit_item_mod(self, module);
        }
    }

    fn visit_item_use(&mut self, item: &'a syn::ItemUse) {
        if !is_for_tests(&item.attrs) {
            let gives_on = !matches!(item.vis, syn::Visibility::Inherited);
            self.import(&item.tree, &[], gives_on);
        }
    }

    fn visit_item_fn(&mut self, function: &'a syn::ItemFn) {
        if !is_for_tests(&function.attrs) {
            self.signature(&function.sig);
            visit::visit_item_fn(self, function);
        }
    }

    fn visit_item_impl(&mut self, block: &'a syn::ItemImpl) {
        if is_for_tests(&block.attrs) {
            return;
        }
        let mut types = Types::default();
        types.visit_type(&block.self_ty);
        self.subject = types.0.into_iter().next();
        if block.trait_.is_none() {
            self.impls.extend(self.subject.clone());
        }
        visit::visit_item_impl(self, block);
        self.subject = None;
    }

    fn visit_impl_item_fn(&mut self, function: &'a syn::ImplItemFn) {
        self.signature(&function.sig);
        self.methods.extend(self.subject.clone().map(|subject| (subject, function.sig.ident.to_string())));
        visit::visit_impl_item_fn(self, function);
    }

    fn visit_expr_method_call(&mut self, call: &'a syn::ExprMethodCall) {
        self.calls.extend(self.type_of(&call.receiver).map(|subject| (subject, call.method.to_string())));
        visit::visit_expr_method_call(self, call);
    }

    fn visit_path(&mut self, path: &'a syn::Path) {
        if path.segments.len() > 1 {
            self.paths.insert(path.segments.iter().map(|segment| segment.ident.to_string()).collect());
        }
        visit::visit_path(self, path);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn structure(files: &[(&str, &str)]) -> Structure {
        Structure::read(&Package::of("p", files))
    }

    #[test]
    fn imports_paths_and_methods_make_circles() {
        let found = structure(&[
            ("lib.rs", "mod a; mod b; mod c; mod d;"),
            ("a.rs", "use crate::b::B; pub struct A; impl A { pub fn only_a(&self) {} }"),
            ("b.rs", "pub struct B; fn f() { crate::c::g(); }"),
            ("c.rs", "pub fn g() {} fn h(x: &mut A<X>) { x.only_a(); }"),
            ("d.rs", "use crate::a::A;"),
        ]);
        assert_eq!(found.circles(), [["a.rs", "b.rs", "c.rs"]]);
    }

    #[test]
    fn a_reexport_leads_to_where_the_item_is_and_tests_do_not_count() {
        let found = structure(&[
            ("lib.rs", "mod a; mod b;"),
            ("a/mod.rs", "mod inner; mod other; pub use inner::Thing; use other::f;"),
            ("a/inner.rs", "pub struct Thing;"),
            ("a/other.rs", "use super::Thing; pub fn f() {} #[cfg(test)] mod tests { use crate::b::X; }"),
            ("b.rs", "use crate::a::Thing; pub struct X;"),
        ]);
        assert!(found.edges["b.rs"].contains("a/inner.rs") && !found.edges["b.rs"].contains("a/mod.rs"));
        assert_eq!(found.edges["a/other.rs"], BTreeSet::from(["a/inner.rs".to_owned()]));
        assert!(found.circles().is_empty());
    }

    #[test]
    fn a_program_beside_a_library_is_not_the_library() {
        let found = structure(&[
            ("lib.rs", "pub mod a; pub use a::A;"),
            ("main.rs", "mod commands; use p::A;"),
            ("commands.rs", "use p::a::A;"),
            ("a.rs", "pub struct A;"),
            ("b.rs", "use crate::A;"),
        ]);
        assert_eq!(found.edges["b.rs"], BTreeSet::from(["a.rs".to_owned()]));
        assert!(!found.arrows().any(|(_, to)| to == "main.rs"));
    }

    #[test]
    fn who_takes_the_whole_and_who_is_spread_is_found() {
        let found = structure(&[
            ("lib.rs", "mod a; mod b;"),
            ("a.rs", "pub struct Machine; impl Machine { fn x(&self) {} } fn f(machine: &mut Machine) {}"),
            ("b.rs", "use crate::a::Machine; impl Machine { fn y(&self) {} } impl Clone for Machine {}"),
        ]);
        assert_eq!(found.impls["Machine"].len(), 2);
        assert_eq!(found.takers("Machine"), [("a.rs".to_owned(), "f".to_owned())]);
    }
}
