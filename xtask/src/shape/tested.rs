//! Tests of a package, and the lines of code that they are for.

use std::fs;
use std::path::Path;

use anyhow::{Context, Result};
use syn::spanned::Spanned;
use syn::visit::{self, Visit};

use crate::package::{Package, is_for_tests};
use crate::sources::rust_files;

/// Packages for the board alone, and where their tests lie: on the board, or on the emulated one.
const ELSEWHERE: &[(&str, &str)] = &[
    ("bsp-prime", "tests/on-target/tests"),
    ("boot", "virtual-prime/tests/updates"),
    ("firmware", "virtual-prime/tests"),
    ("controller", "virtual-prime/tests"),
];

/// Pages of tests of a package: each title begins a test of its own, on a fresh interpreter, with lines and
/// what is to come of them.
const PAGES: &[(&str, &str)] = &[("program", "tests/language")];

/// Returns the number of tests of a package: in `src`, in `tests` beside it, on its pages, and elsewhere.
pub fn tests(root: &Path, package: &Package) -> Result<usize> {
    let elsewhere = ELSEWHERE.iter().filter(|(name, _)| *name == package.name).map(|(_, folder)| root.join(folder));
    let mut count = package.files.iter().map(|file| count_tests(&file.text)).sum();
    for folder in elsewhere.chain([package.folder.join("tests")]).filter(|folder| folder.is_dir()) {
        for path in rust_files(&folder)? {
            count += count_tests(&fs::read_to_string(&path).with_context(|| path.display().to_string())?);
        }
    }
    for (_, folder) in PAGES.iter().filter(|(name, _)| *name == package.name) {
        for page in fs::read_dir(package.folder.join(folder)).with_context(|| (*folder).to_owned())? {
            count += titles(&fs::read_to_string(page?.path())?);
        }
    }
    Ok(count)
}

/// Returns the number of tests on a page.
fn titles(page: &str) -> usize {
    page.lines().filter(|line| line.starts_with("# ")).count()
}

/// Returns the number of lines of code and comments, tests excepted.
pub fn lines(package: &Package) -> usize {
    package.product().map(|file| file.text.lines().count() - lines_of_tests(&file.syntax)).sum()
}

/// Returns how many tests a source holds, those within macros too.
fn count_tests(text: &str) -> usize {
    text.lines().filter(|line| line.trim() == "#[test]").count()
}

/// Returns the lines of the items that are for tests alone.
fn lines_of_tests(file: &syn::File) -> usize {
    let mut counted = TestLines(0);
    counted.visit_file(file);
    counted.0
}

struct TestLines(usize);

impl TestLines {
    fn add(&mut self, item: &impl Spanned) {
        let span = item.span();
        self.0 += span.end().line + 1 - span.start().line;
    }
}

impl<'a> Visit<'a> for TestLines {
    fn visit_item_mod(&mut self, module: &'a syn::ItemMod) {
        if is_for_tests(&module.attrs) { self.add(module) } else { visit::visit_item_mod(self, module) }
    }

    fn visit_item_fn(&mut self, function: &'a syn::ItemFn) {
        if is_for_tests(&function.attrs) {
            self.add(function);
        }
    }

    fn visit_item_impl(&mut self, block: &'a syn::ItemImpl) {
        if is_for_tests(&block.attrs) { self.add(block) } else { visit::visit_item_impl(self, block) }
    }

    fn visit_impl_item_fn(&mut self, function: &'a syn::ImplItemFn) {
        if is_for_tests(&function.attrs) {
            self.add(function);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_of_tests_within_a_file_do_not_count() {
        let text = "fn f() {}\n\n#[cfg(test)]\nmod tests {\n    #[test]\n    fn t() {}\n}\n";
        assert_eq!(lines(&Package::of("p", &[("lib.rs", text)])), 2);
        let text = "#[cfg(not(test))]\nmod real {\n}\n";
        assert_eq!(lines(&Package::of("p", &[("lib.rs", text)])), 3);
    }

    #[test]
    fn each_title_of_a_page_is_a_test() {
        assert_eq!(titles("# A line\nG1 X1 ; # no title\n    line to X1\n\n# An arc\nG2 X2 I1\n"), 2);
    }

    #[test]
    fn tests_in_macros_and_in_files_of_tests_count() {
        let files = [
            ("lib.rs", "#[cfg(test)]\nmod tests;\nproptest! {\n    #[test]\n    fn a(b in 0..2) {}\n}\n"),
            ("tests.rs", "#[test]\nfn t() {}\n"),
        ];
        assert_eq!(tests(Path::new("nowhere"), &Package::of("p", &files)).unwrap(), 2);
    }
}
