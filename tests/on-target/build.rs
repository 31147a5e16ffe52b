//! Linker scripts of the test images.
fn main() {
    for argument in ["--nmagic", "-Tlink.x", "-Tdefmt.x"] {
        println!("cargo:rustc-link-arg-tests={argument}");
    }
    println!("cargo:rerun-if-changed=build.rs");
}
