//! Public functions, methods, types and traits, and their documentation. Constants, fields and values of
//! enumerations are left to the compiler's lint: the name of a register or a state may say all.

use syn::visit::{self, Visit};

use crate::package::{Package, is_for_tests};

/// Returns the number of public items, and those without documentation, tests excepted.
pub fn items(package: &Package) -> (usize, Vec<String>) {
    let (mut all, mut bare) = (0, Vec::new());
    for file in package.product() {
        let mut items = Items::default();
        items.visit_file(&file.syntax);
        all += items.all;
        bare.extend(items.bare.into_iter().map(|(line, name)| format!("{}:{line}: {name}", file.name)));
    }
    (all, bare)
}

#[derive(Default)]
struct Items {
    all: usize,
    bare: Vec<(usize, String)>,
}

impl Items {
    fn add(&mut self, attributes: &[syn::Attribute], name: &syn::Ident) {
        self.all += 1;
        if !attributes.iter().any(|attribute| attribute.path().is_ident("doc")) {
            self.bare.push((name.span().start().line, name.to_string()));
        }
    }

    fn public(&mut self, visibility: &syn::Visibility, attributes: &[syn::Attribute], name: &syn::Ident) {
        if matches!(visibility, syn::Visibility::Public(_)) {
            self.add(attributes, name);
        }
    }
}

impl<'a> Visit<'a> for Items {
    fn visit_item(&mut self, item: &'a syn::Item) {
        match item {
            syn::Item::Fn(item) => self.public(&item.vis, &item.attrs, &item.sig.ident),
            syn::Item::Struct(item) => self.public(&item.vis, &item.attrs, &item.ident),
            syn::Item::Enum(item) => self.public(&item.vis, &item.attrs, &item.ident),
            syn::Item::Union(item) => self.public(&item.vis, &item.attrs, &item.ident),
            syn::Item::Type(item) => self.public(&item.vis, &item.attrs, &item.ident),
            syn::Item::Trait(item) => {
                self.public(&item.vis, &item.attrs, &item.ident);
                if matches!(item.vis, syn::Visibility::Public(_)) {
                    visit::visit_item_trait(self, item);
                }
            }
            // What a trait asks for is documented there.
            syn::Item::Impl(item) if item.trait_.is_none() && !is_for_tests(&item.attrs) => {
                visit::visit_item_impl(self, item);
            }
            syn::Item::Mod(item) if !is_for_tests(&item.attrs) => visit::visit_item_mod(self, item),
            _ => {}
        }
    }

    fn visit_impl_item_fn(&mut self, function: &'a syn::ImplItemFn) {
        self.public(&function.vis, &function.attrs, &function.sig.ident);
    }

    fn visit_trait_item_fn(&mut self, function: &'a syn::TraitItemFn) {
        self.add(&function.attrs, &function.sig.ident);
    }

    fn visit_trait_item_type(&mut self, item: &'a syn::TraitItemType) {
        self.add(&item.attrs, &item.ident);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn found(text: &str) -> (usize, Vec<String>) {
        items(&Package::of("p", &[("lib.rs", text)]))
    }

    #[test]
    fn items_without_documentation_are_named() {
        assert_eq!(found("/// Doc.\npub fn f() {}\npub struct S;"), (2, vec!["lib.rs:3: S".to_owned()]));
        assert_eq!(found("impl S { pub fn f() {} fn g() {} }"), (1, vec!["lib.rs:1: f".to_owned()]));
        assert_eq!(found("/// Doc.\npub trait T { fn f(); }"), (2, vec!["lib.rs:2: f".to_owned()]));
    }

    #[test]
    fn other_items_do_not_count() {
        assert_eq!(found("pub const A: u8 = 1; pub struct S { pub field: u8 }").0, 1);
        assert_eq!(found("fn f() {} pub(crate) struct S; trait T { fn f(); }"), (0, vec![]));
        assert_eq!(found("impl T for S { fn f() {} } #[cfg(test)] mod tests { pub fn f() {} }"), (0, vec![]));
    }
}
