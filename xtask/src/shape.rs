//! Shape of the sources: how long functions are, whether a match names all that there is, how much of what is
//! public is documented, how many tests a package has, and who takes the whole machine.
//!
//! A package that is short of a goal has a row in a table, which only shrinks: a figure that is nearer to its
//! goal than its row is a fault too.

mod documented;
mod functions;
mod tested;
mod wildcards;

use std::path::Path;

use anyhow::{Result, bail};

use crate::limit;
use crate::package::{self, Package};
use crate::structure::Structure;

/// Longest body of a function, lines.
const LONGEST: usize = 60;
/// Functions that are longer, by package.
const LONG: &[(&str, usize)] = &[];

/// Arms that take whatever else a code may mean.
const WILDCARDS: usize = 0;

/// Public functions, types and traits with documentation, percent.
const DOCUMENTED: usize = 98;
const LESS_DOCUMENTED: &[(&str, usize)] = &[];

/// Tests per 1000 lines of a package's code.
const TESTS: usize = 10;
const LESS_TESTED: &[(&str, usize)] = &[("bsp-prime", 6)];
/// Packages that are tests themselves.
const ARE_TESTS: &[&str] = &["scenarios", "on-target", "fuzz", "fuzz-engine"];
/// Functions that take the whole `Machine`.
const TAKERS: (usize, usize) = (60, 60);

/// Figures of a package, each with the places that count.
#[derive(Debug)]
struct Shape {
    long: Vec<String>,
    wildcards: Vec<String>,
    undocumented: Vec<String>,
    /// Public items with documentation, whole percent.
    documented: usize,
    tests_per_kloc: usize,
    takers: Vec<String>,
}

impl Shape {
    fn of(root: &Path, package: &Package) -> Result<Self> {
        let (public, undocumented) = documented::items(package);
        let documented = 100 * (public - undocumented.len()) / public.max(1);
        let structure = Structure::read(package);
        Ok(Self {
            long: functions::longer_than(package, LONGEST),
            wildcards: wildcards::arms(package),
            documented: if public == 0 { 100 } else { documented },
            undocumented,
            tests_per_kloc: 1000 * tested::tests(root, package)? / tested::lines(package).max(1),
            takers: structure.takers("Machine").iter().map(|(file, name)| format!("{file}: {name}")).collect(),
        })
    }

    /// Broken rules of a package by itself.
    fn faults(&self, name: &str) -> Vec<String> {
        let what = |words: &str| format!("{name}: {words}");
        let long = limit::of(LONG, name, 0);
        let documented = limit::of(LESS_DOCUMENTED, name, DOCUMENTED);
        let tests = limit::of(LESS_TESTED, name, TESTS);
        let mut faults = Vec::new();
        let too_long = limit::at_most(&what("functions of more than 60 lines"), self.long.len(), long, 0);
        if self.long.len() > long {
            faults.extend(self.long.iter().map(|place| format!("{name}: {place}")));
        }
        faults.extend(too_long);
        faults.extend(limit::at_least(
            &what("public items documented, percent"),
            self.documented,
            documented,
            DOCUMENTED,
        ));
        if !ARE_TESTS.contains(&name) {
            let per_kloc = self.tests_per_kloc;
            faults.extend(limit::at_least(&what("tests per 1000 lines"), per_kloc, tests, TESTS));
        }
        faults
    }
}

/// Checks all packages, and reports all violations at once.
pub fn check(root: &Path) -> Result<()> {
    let packages = package::all(root)?;
    let mut faults = Vec::new();
    let (mut wildcards, mut takers) = (0, 0);
    for package in &packages {
        let shape = Shape::of(root, package)?;
        faults.extend(shape.faults(&package.name));
        wildcards += shape.wildcards.len();
        if package.name == "machine" {
            takers = shape.takers.len();
        }
    }
    faults.extend(limit::at_most("arms for any other Action or Function", wildcards, WILDCARDS, 0));
    faults.extend(limit::at_most("functions that take the whole Machine", takers, TAKERS.0, TAKERS.1));
    if faults.is_empty() {
        println!("shape: {} crates keep their limits", packages.len());
        return Ok(());
    }
    for fault in &faults {
        eprintln!("  {fault}");
    }
    bail!("{} broken rule(s); xtask shape CRATE says where", faults.len())
}

/// Prints the figures of a package, with the places that count.
pub fn report(root: &Path, name: &str) -> Result<()> {
    let package = package::named(root, name)?;
    let shape = Shape::of(root, &package)?;
    let lists = [
        ("functions of more than 60 lines", &shape.long),
        ("arms for any other Action or Function", &shape.wildcards),
        ("public items without documentation", &shape.undocumented),
        ("functions that take the whole Machine", &shape.takers),
    ];
    for (what, places) in lists {
        println!("{name}: {what}: {}", places.len());
        places.iter().for_each(|place| println!("  {place}"));
    }
    println!("{name}: {} lines, {} % documented", tested::lines(&package), shape.documented);
    println!("{name}: {} tests per 1000 lines", shape.tests_per_kloc);
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn shape(text: &str) -> Shape {
        Shape::of(Path::new("."), &Package::of("p", &[("lib.rs", text)])).unwrap()
    }

    #[test]
    fn a_package_in_order_has_no_faults() {
        let found =
            shape("/// Returns one.\npub fn f() -> u8 { 1 }\n#[cfg(test)]\nmod tests {\n#[test]\nfn t() {}\n}\n");
        assert!(found.faults("p").is_empty());
    }

    #[test]
    fn each_rule_has_its_words() {
        let long = format!("pub fn f() {{\n{}}}\n", "    g();\n".repeat(LONGEST + 1));
        assert_eq!(
            shape(&long).faults("p"),
            [
                "p: lib.rs:1: f is 61 lines long",
                "p: functions of more than 60 lines: 1, at most 0 may be",
                "p: public items documented, percent: 0, at least 98 must be",
                "p: tests per 1000 lines: 0, at least 10 must be",
            ]
        );
    }

    #[test]
    fn who_takes_the_whole_machine_is_counted() {
        let text = "pub struct Machine; fn f(machine: &mut Machine) {} fn g(machine: &Machine<X>) {} fn h(m: u8) {}";
        assert_eq!(shape(text).takers, ["lib.rs: f", "lib.rs: g"]);
    }
}
