//! Circles: files and rooms of a package that need each other, so that none of them can be understood alone.
//! A room is a file or folder at the top of `src`.

use std::path::Path;

use anyhow::Result;

use crate::limit;
use crate::package::{self, Package};
use crate::structure::Structure;

/// Most files, and most rooms, that may need each other.
const LARGEST: usize = 3;

/// Broken rules of a package.
pub fn faults(package: &Package, structure: &Structure) -> Vec<String> {
    let kinds = [("files", structure.circles()), ("rooms", structure.circles_of_rooms())];
    let fault = |(kind, circles): (&str, Vec<Vec<&str>>)| {
        let largest = circles.first().map_or(&[][..], Vec::as_slice);
        let what = format!("{}: {kind} that need each other", package.name);
        limit::at_most(&what, largest.len(), LARGEST, LARGEST).map(|fault| format!("{fault}: {}", largest.join(" ")))
    };
    kinds.into_iter().filter_map(fault).collect()
}

/// Prints the circles of a package, of files and of rooms, and every arrow between two files.
pub fn report(root: &Path, name: &str) -> Result<()> {
    let structure = Structure::read(&package::named(root, name)?);
    for (from, to) in structure.arrows() {
        println!("{from} -> {to}");
    }
    for (kind, circles) in [("files", structure.circles()), ("rooms", structure.circles_of_rooms())] {
        for circle in circles {
            println!("{name}: {} {kind} need each other: {}", circle.len(), circle.join(" "));
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn found(files: &[(&str, &str)]) -> Vec<String> {
        let package = Package::of("p", files);
        faults(&package, &Structure::read(&package))
    }

    #[test]
    fn four_files_in_a_circle_are_too_many_and_three_are_not() {
        let three = [
            ("lib.rs", "mod a; mod b; mod c; mod d;"),
            ("a.rs", "use crate::b::B; pub struct A;"),
            ("b.rs", "use crate::c::C; pub struct B;"),
            ("c.rs", "use crate::a::A; pub struct C;"),
        ];
        assert!(found(&three).is_empty());
        let mut four = three;
        four[3].1 = "use crate::d::D; pub struct C;";
        let four = [four[0], four[1], four[2], four[3], ("d.rs", "use crate::a::A; pub struct D;")];
        assert_eq!(
            found(&four),
            [
                "p: files that need each other: 4, at most 3 may be: a.rs b.rs c.rs d.rs",
                "p: rooms that need each other: 4, at most 3 may be: a b c d"
            ]
        );
    }

    #[test]
    fn rooms_can_need_each_other_where_no_files_do() {
        let files = [
            ("lib.rs", "mod a; mod b; mod c; mod d;"),
            ("a/mod.rs", "mod x; use crate::b::B;"),
            ("a/x.rs", "pub struct X;"),
            ("b.rs", "use crate::c::C; pub struct B;"),
            ("c.rs", "use crate::d::D; pub struct C;"),
            ("d.rs", "use crate::a::x::X; pub struct D;"),
        ];
        assert_eq!(found(&files), ["p: rooms that need each other: 4, at most 3 may be: a b c d"]);
    }
}
