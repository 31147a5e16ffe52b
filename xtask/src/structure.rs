//! Structure of a crate: files that name each other, types are spread over many of them,
//! who may wait.
//!
//! Files are read with `syn`. An edge is an import, a path in the text, or the call of a method of `self` or
//! of an argument whose type has that method in another file. Tests do not count. A path through a re-export
//! leads to the file that defines the item.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::Path;

use anyhow::{Context, Result};
use petgraph::algo::tarjan_scc;
use petgraph::graphmap::DiGraphMap;
use syn::visit::{self, Visit};

use crate::sources::rust_files;

/// Most files that may need each other.
const LARGEST_CIRCLE: usize = 3;
/// Most files with an `impl` of one type.
const MOST_IMPL_FILES: usize = 3;

/// Facts of a crate that a rule needs.
#[derive(Debug, Default)]
pub struct Structure {
    /// By file, those that it names.
    edges: BTreeMap<String, BTreeSet<String>>,
    /// By type, the files that have an `impl` of it.
    impls: BTreeMap<String, BTreeSet<String>>,
    /// Files with a function that takes the whole of this type, with the function's name.
    takers: BTreeMap<String, Vec<(String, String)>>,
}

/// Broken rules of a crate; `executor` is a type, and the folder whose functions alone may take the whole of
/// it.
pub fn faults(root: &Path, package: &str, executor: Option<(&str, &str)>) -> Result<Vec<String>> {
    let structure = Structure::read(&root.join(package).join("src"))?;
    let mut faults = Vec::new();
    for circle in structure.circles() {
        if circle.len() > LARGEST_CIRCLE {
            let names = circle.join(" ");
            faults.push(format!("{package}: {} files need each other, {LARGEST_CIRCLE} may: {names}", circle.len()));
        }
    }
    for (name, files) in &structure.impls {
        if files.len() > MOST_IMPL_FILES {
            let list: Vec<&str> = files.iter().map(String::as_str).collect();
            let count = files.len();
            faults.push(format!("{package}: {name} has methods in {count} files: {}", list.join(" ")));
        }
    }
    if let Some((whole, folder)) = executor {
        for (file, function) in structure.takers.get(whole).into_iter().flatten() {
            if !file.starts_with(&format!("{folder}/")) {
                faults.push(format!("{package}/src/{file}: {function} takes the whole {whole}"));
            }
        }
    }
    Ok(faults)
}

/// The same as figures: files, those in the largest circle, and the type with methods in the most files.
pub fn figures(root: &Path, package: &str) -> Result<String> {
    let structure = Structure::read(&root.join(package).join("src"))?;
    let circle = structure.circles().iter().map(Vec::len).max().unwrap_or(0);
    let (spread, name) =
        structure.impls.iter().map(|(name, files)| (files.len(), name.as_str())).max().unwrap_or((0, "-"));
    let files = structure.edges.len();
    Ok(format!("{package}: {files} files, largest circle {circle}, {name} has methods in {spread} of them"))
}

/// Prints the circles of a crate, of files and of rooms, and every arrow between two files.
pub fn report(root: &Path, package: &str) -> Result<()> {
    let structure = Structure::read(&root.join(package).join("src"))?;
    for (from, to) in structure.arrows() {
        println!("{from} -> {to}");
    }
    for (kind, circles) in [("files", structure.circles()), ("rooms", structure.circles_of_rooms())] {
        for circle in circles {
            println!("{package}: {} {kind} need each other: {}", circle.len(), circle.join(" "));
        }
    }
    Ok(())
}

impl Structure {
    fn read(source: &Path) -> Result<Self> {
        let mut files = BTreeMap::new();
        for path in rust_files(source)? {
            let text = fs::read_to_string(&path).with_context(|| path.display().to_string())?;
            let file = syn::parse_file(&text).with_context(|| path.display().to_string())?;
            let name = path.strip_prefix(source).unwrap_or(&path).display().to_string();
            files.insert(name, file);
        }
        Ok(Self::of(&files))
    }

    fn of(files: &BTreeMap<String, syn::File>) -> Self {
        let mut facts: BTreeMap<&str, Facts> = BTreeMap::new();
        for (name, file) in files {
            let mut found = Facts::default();
            found.visit_file(file);
            facts.insert(name, found);
        }
        let modules: BTreeMap<Vec<String>, &str> = files.keys().map(|name| (module_of(name), name.as_str())).collect();
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

    /// Files that need each other, largest first.
    fn circles(&self) -> Vec<Vec<&str>> {
        circles(self.arrows())
    }

    /// Rooms that need each other, largest first: the files and folders at the top of a crate.
    fn circles_of_rooms(&self) -> Vec<Vec<&str>> {
        circles(self.arrows().map(|(from, to)| (room_of(from), room_of(to))).filter(|(from, to)| from != to))
    }

    /// Every pair of files of which the first names the second.
    fn arrows(&self) -> impl Iterator<Item = (&str, &str)> {
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
fn module_of(name: &str) -> Vec<String> {
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

fn is_for_tests(attributes: &[syn::Attribute]) -> bool {
    attributes.iter().any(|attribute| {
        attribute.path().is_ident("test")
            || attribute.path().is_ident("cfg")
                && attribute.meta.require_list().is_ok_and(|list| {
                    let text = list.tokens.to_string();
                    text.contains("test") && !text.contains("not")
                })
    })
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
        let parsed = files.iter().map(|(name, text)| ((*name).to_owned(), syn::parse_file(text).unwrap()));
        Structure::of(&parsed.collect())
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
    fn who_takes_the_whole_and_who_is_spread_is_found() {
        let found = structure(&[
            ("lib.rs", "mod a; mod b;"),
            ("a.rs", "pub struct Machine; impl Machine { fn x(&self) {} } fn f(machine: &mut Machine) {}"),
            ("b.rs", "use crate::a::Machine; impl Machine { fn y(&self) {} } impl Clone for Machine {}"),
        ]);
        assert_eq!(found.impls["Machine"].len(), 2);
        assert_eq!(found.takers["Machine"], [("a.rs".to_owned(), "f".to_owned())]);
    }
}
