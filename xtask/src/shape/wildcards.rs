//! Matches over the meaning of codes, `Action` and `Function` of `program`, that have an arm for whatever
//! else there is: a new meaning would be silently taken for nothing.

use syn::spanned::Spanned;
use syn::visit::{self, Visit};

use crate::package::{Package, is_for_tests};

/// Enumerations whose matches name every value.
const NAMED_IN_FULL: &[&str] = &["Action", "Function"];

/// Returns the arms that take any other value, tests excepted.
pub fn arms(package: &Package) -> Vec<String> {
    let mut found = Vec::new();
    for file in package.product() {
        let mut arms = Arms::default();
        arms.visit_file(&file.syntax);
        found.extend(arms.found.into_iter().map(|(line, of)| format!("{}:{line}: in a match over {of}", file.name)));
    }
    found
}

#[derive(Default)]
struct Arms {
    /// Type whose `impl` this is.
    subject: Option<String>,
    found: Vec<(usize, String)>,
}

impl Arms {
    /// The enumeration of which a pattern names a value.
    fn named(&self, pattern: &syn::Pat) -> Option<String> {
        let mut paths = Paths::default();
        paths.visit_pat(pattern);
        let subject = self.subject.as_deref();
        let owner = |owner: String| if owner == "Self" { subject.map(str::to_owned) } else { Some(owner) };
        paths.0.into_iter().filter_map(owner).find(|owner| NAMED_IN_FULL.contains(&owner.as_str()))
    }
}

/// Last but one part of every path.
#[derive(Default)]
struct Paths(Vec<String>);

impl<'a> Visit<'a> for Paths {
    fn visit_path(&mut self, path: &'a syn::Path) {
        let owner = path.segments.iter().rev().nth(1);
        self.0.extend(owner.map(|segment| segment.ident.to_string()));
        visit::visit_path(self, path);
    }
}

/// Whether a pattern takes any value: `_`, a name, or a tuple of these.
fn takes_any(pattern: &syn::Pat) -> bool {
    match pattern {
        syn::Pat::Wild(_) => true,
        // A name with a capital is a constant or an imported value.
        syn::Pat::Ident(name) => {
            name.subpat.is_none() && name.ident.to_string().starts_with(|first: char| !first.is_uppercase())
        }
        syn::Pat::Tuple(tuple) => tuple.elems.iter().all(takes_any),
        syn::Pat::Reference(reference) => takes_any(&reference.pat),
        syn::Pat::Paren(inner) => takes_any(&inner.pat),
        syn::Pat::Or(alternatives) => alternatives.cases.iter().any(takes_any),
        _ => false,
    }
}

impl<'a> Visit<'a> for Arms {
    fn visit_item_mod(&mut self, module: &'a syn::ItemMod) {
        if !is_for_tests(&module.attrs) {
            visit::visit_item_mod(self, module);
        }
    }

    fn visit_item_fn(&mut self, function: &'a syn::ItemFn) {
        if !is_for_tests(&function.attrs) {
            visit::visit_item_fn(self, function);
        }
    }

    fn visit_item_impl(&mut self, block: &'a syn::ItemImpl) {
        if is_for_tests(&block.attrs) {
            return;
        }
        if let syn::Type::Path(subject) = &*block.self_ty {
            self.subject = subject.path.segments.last().map(|segment| segment.ident.to_string());
        }
        visit::visit_item_impl(self, block);
        self.subject = None;
    }

    fn visit_expr_match(&mut self, expression: &'a syn::ExprMatch) {
        if let Some(of) = expression.arms.iter().find_map(|arm| self.named(&arm.pat)) {
            let any = expression.arms.iter().filter(|arm| arm.guard.is_none() && takes_any(&arm.pat));
            self.found.extend(any.map(|arm| (arm.pat.span().start().line, of.clone())));
        }
        visit::visit_expr_match(self, expression);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn found(text: &str) -> Vec<String> {
        arms(&Package::of("p", &[("lib.rs", text)]))
    }

    #[test]
    fn arms_for_anything_else_are_found() {
        let any = |arm: &str| found(&format!("fn f(a: A) {{\nmatch a {{ Action::X(_) => 1,\n{arm} => 2 }}; }}"));
        assert_eq!(any("_"), ["lib.rs:3: in a match over Action"]);
        assert_eq!(any("other").len(), 1);
        assert_eq!(any("Action::Y | _").len(), 1);
        assert!(any("Action::Y { .. }").is_empty());
        assert!(any("_ if c").is_empty());
        assert!(any("y @ Action::Y").is_empty());
        assert!(any("REST").is_empty());
    }

    #[test]
    fn tuples_and_self_are_seen_through() {
        assert_eq!(found("fn f() { match (a, b) { (program::Function::X, _) => 1, (_, other) => 2 } }").len(), 1);
        assert!(found("fn f() { match (a, b) { (Function::X, _) => 1, (Function::Y, true) => 2 } }").is_empty());
        assert_eq!(found("impl Action { fn f(self) { match self { Self::X => 1, _ => 2 } } }").len(), 1);
        assert!(found("impl Other { fn f(self) { match self { Self::X => 1, _ => 2 } } }").is_empty());
    }

    #[test]
    fn other_matches_and_tests_do_not_count() {
        assert!(found("fn f() { match a { Other::X => 1, _ => 2 } }").is_empty());
        assert!(found("#[cfg(test)] mod tests { fn f() { match a { Action::X => 1, _ => 2 } } }").is_empty());
    }
}
