//! Functions that do not fit a screen.

use syn::visit::{self, Visit};

use crate::package::{Package, is_for_tests};

/// Returns the functions whose bodies have more than so many lines, tests excepted.
pub fn longer_than(package: &Package, most: usize) -> Vec<String> {
    let mut found = Vec::new();
    for file in package.product() {
        let mut long = Long { most, found: Vec::new() };
        long.visit_file(&file.syntax);
        found.extend(long.found.into_iter().map(|(line, words)| format!("{}:{line}: {words}", file.name)));
    }
    found
}

struct Long {
    most: usize,
    found: Vec<(usize, String)>,
}

impl Long {
    fn look(&mut self, signature: &syn::Signature, body: &syn::Block) {
        let (open, close) = (body.brace_token.span.open().start().line, body.brace_token.span.close().end().line);
        let lines = (close - open).saturating_sub(1);
        if lines > self.most {
            let line = signature.fn_token.span.start().line;
            self.found.push((line, format!("{} is {lines} lines long", signature.ident)));
        }
    }
}

impl<'a> Visit<'a> for Long {
    fn visit_item_mod(&mut self, module: &'a syn::ItemMod) {
        if !is_for_tests(&module.attrs) {
            visit::visit_item_mod(self, module);
        }
    }

    fn visit_item_impl(&mut self, block: &'a syn::ItemImpl) {
        if !is_for_tests(&block.attrs) {
            visit::visit_item_impl(self, block);
        }
    }

    fn visit_item_fn(&mut self, function: &'a syn::ItemFn) {
        if !is_for_tests(&function.attrs) {
            self.look(&function.sig, &function.block);
            visit::visit_item_fn(self, function);
        }
    }

    fn visit_impl_item_fn(&mut self, function: &'a syn::ImplItemFn) {
        if !is_for_tests(&function.attrs) {
            self.look(&function.sig, &function.block);
            visit::visit_impl_item_fn(self, function);
        }
    }

    fn visit_trait_item_fn(&mut self, function: &'a syn::TraitItemFn) {
        if let Some(body) = &function.default {
            self.look(&function.sig, body);
        }
        visit::visit_trait_item_fn(self, function);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn found(text: &str) -> Vec<String> {
        longer_than(&Package::of("p", &[("lib.rs", text)]), 2)
    }

    #[test]
    fn lines_between_the_braces_count() {
        assert!(found("fn f() {\n    a();\n    b();\n}\n").is_empty());
        assert!(found("fn f(\n    a: u8,\n    b: u8,\n) {\n    a();\n}\n").is_empty());
        assert_eq!(found("\nfn f() {\n    a();\n    b();\n    c();\n}\n"), ["lib.rs:2: f is 3 lines long"]);
    }

    #[test]
    fn methods_count_and_tests_do_not() {
        let body = "{\n    a();\n    b();\n    c();\n}\n";
        assert_eq!(found(&format!("impl A {{ fn f() {body} }}")).len(), 1);
        assert_eq!(found(&format!("trait A {{ fn f() {body} fn g(); }}")).len(), 1);
        assert_eq!(found(&format!("mod app {{ fn f() {body} }}")).len(), 1);
        assert!(found(&format!("#[test] fn f() {body}")).is_empty());
        assert!(found(&format!("#[cfg(test)] mod tests {{ fn f() {body} }}")).is_empty());
    }
}
