//! Packages and their sources, read once for all rules about them.

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{Context, Result};
use serde_json::Value;

use crate::sources::rust_files;
use crate::structure::module_of;

/// Packages of the emulator's workspace, which needs a newer compiler: name and folder.
const EMULATOR: &[(&str, &str)] = &[("virtual-prime", "virtual-prime"), ("usb-host", "virtual-prime/usb-host")];

/// Package of a workspace, as cargo knows it.
#[derive(Debug)]
pub struct Manifest {
    pub name: String,
    pub folder: PathBuf,
    /// Direct dependencies, those of tests excepted.
    pub dependencies: BTreeSet<String>,
}

/// Package with its parsed sources.
#[derive(Debug)]
pub struct Package {
    pub name: String,
    pub folder: PathBuf,
    pub files: Vec<Source>,
}

/// Source file of a package.
#[derive(Debug)]
pub struct Source {
    /// Path below `src`.
    pub name: String,
    pub text: String,
    pub syntax: syn::File,
    /// Whether the whole file is compiled for tests alone.
    pub is_test: bool,
}

/// Returns the members of the workspace.
pub fn workspace(root: &Path) -> Result<Vec<Manifest>> {
    let cargo = std::env::var("CARGO").unwrap_or_else(|_| "cargo".into());
    let output = Command::new(cargo)
        .args(["metadata", "--no-deps", "--format-version", "1"])
        .current_dir(root)
        .output()
        .context("cargo metadata")?;
    let metadata: Value = serde_json::from_slice(&output.stdout).context("cargo metadata's answer")?;
    let packages = metadata["packages"].as_array().context("packages")?;
    Ok(packages.iter().filter_map(manifest).collect())
}

fn manifest(package: &Value) -> Option<Manifest> {
    let dependencies = package["dependencies"].as_array()?;
    let names = dependencies
        .iter()
        .filter(|dependency| dependency["kind"].as_str() != Some("dev"))
        .filter_map(|dependency| dependency["name"].as_str())
        .map(str::to_owned)
        .collect();
    let folder = Path::new(package["manifest_path"].as_str()?).parent()?.to_owned();
    Some(Manifest { name: package["name"].as_str()?.to_owned(), folder, dependencies: names })
}

/// Reads the members of the workspace and of the emulator's.
pub fn all(root: &Path) -> Result<Vec<Package>> {
    let ours = workspace(root)?.into_iter().map(|manifest| (manifest.name, manifest.folder));
    let emulator = EMULATOR.iter().map(|(name, folder)| ((*name).to_owned(), root.join(folder)));
    ours.chain(emulator).map(|(name, folder)| Package::read(name, folder)).collect()
}

/// Reads the package of this name.
pub fn named(root: &Path, name: &str) -> Result<Package> {
    all(root)?.into_iter().find(|package| package.name == name).with_context(|| format!("there is no package {name}"))
}

impl Package {
    fn read(name: String, folder: PathBuf) -> Result<Self> {
        let source = folder.join("src");
        let mut files = Vec::new();
        for path in rust_files(&source)? {
            let text = fs::read_to_string(&path).with_context(|| path.display().to_string())?;
            let syntax = syn::parse_file(&text).with_context(|| path.display().to_string())?;
            let below = path.strip_prefix(&source).unwrap_or(&path).display().to_string();
            files.push(Source { name: below, text, syntax, is_test: false });
        }
        Ok(Self { name, folder, files: marked(files) })
    }

    /// Creates a package of these files: names and texts.
    #[cfg(test)]
    pub fn of(name: &str, files: &[(&str, &str)]) -> Self {
        let parsed = files.iter().map(|(name, text)| Source {
            name: (*name).to_owned(),
            text: (*text).to_owned(),
            syntax: syn::parse_file(text).unwrap(),
            is_test: false,
        });
        Self { name: name.to_owned(), folder: PathBuf::new(), files: marked(parsed.collect()) }
    }

    /// Returns the files that are not for tests alone.
    pub fn product(&self) -> impl Iterator<Item = &Source> {
        self.files.iter().filter(|file| !file.is_test)
    }
}

/// File and folder of a feature's scenarios, which the test program of the package takes in.
const SCENARIOS: &str = "scenarios";

/// Marks the files that a declaration makes a part of the tests, and those below them; and scenarios.
fn marked(mut files: Vec<Source>) -> Vec<Source> {
    let mut modules: Vec<Vec<String>> = Vec::new();
    let mut places: Vec<String> = Vec::new();
    for file in &files {
        let folder = file.name.rsplit_once('/').map_or(String::new(), |(folder, _)| format!("{folder}/"));
        for item in &file.syntax.items {
            let syn::Item::Mod(module) = item else { continue };
            if module.content.is_some() || !is_for_tests(&module.attrs) {
                continue;
            }
            let mut below = module_of(&file.name);
            below.push(module.ident.to_string());
            modules.push(below);
            places.extend(path_attribute(&module.attrs).map(|path| format!("{folder}{path}")));
        }
    }
    for file in &mut files {
        let module = module_of(&file.name);
        file.is_test = modules.iter().any(|test| module.starts_with(test))
            || places.contains(&file.name)
            || module.iter().any(|part| part == SCENARIOS);
    }
    files
}

/// Returns the file that `#[path = "..."]` names.
fn path_attribute(attributes: &[syn::Attribute]) -> Option<String> {
    let value = attributes.iter().find_map(|attribute| attribute.meta.require_name_value().ok())?;
    match &value.value {
        syn::Expr::Lit(syn::ExprLit { lit: syn::Lit::Str(path), .. }) if value.path.is_ident("path") => {
            Some(path.value())
        }
        _ => None,
    }
}

/// Returns whether these attributes compile an item for tests alone.
pub fn is_for_tests(attributes: &[syn::Attribute]) -> bool {
    attributes.iter().any(|attribute| {
        attribute.path().is_ident("test")
            || attribute.path().is_ident("cfg")
                && attribute.meta.require_list().is_ok_and(|list| {
                    let text = list.tokens.to_string();
                    text.contains("test") && !text.contains("not")
                })
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn files_of_tests_are_no_product() {
        let package = Package::of(
            "p",
            &[
                ("lib.rs", "mod a;\n#[cfg(test)]\nmod tests;\n"),
                ("a.rs", "fn f() {}\n#[cfg(test)]\n#[path = \"a_tests.rs\"]\nmod tests;\n"),
                ("a_tests.rs", "#[test]\nfn t() {}\n"),
                ("tests.rs", "mod deep;\n#[test]\nfn t() {}\n"),
                ("tests/deep.rs", "#[test]\nfn t() {}\n"),
                ("a/scenarios.rs", "#[test]\nfn t() {}\n"),
                ("b/scenarios/deep.rs", "#[test]\nfn t() {}\n"),
            ],
        );
        let product: Vec<&str> = package.product().map(|file| file.name.as_str()).collect();
        assert_eq!(product, ["lib.rs", "a.rs"]);
    }
}
