//! The declaration of settings: a struct, and behind each field the line of the file that fills it.
//!
//! ```text
//! settings! {
//!     /// Look-ahead: how fast corners are taken.      documentation of the section and of the struct
//!     #[derive(Clone, Copy, Debug, Default)]
//!     pub struct PlannerConfig {
//!         /// Slowest speed at corners.                help in the reference, documentation of the field
//!         minimum_planner_speed: MmPerSecond = number("0", &(0.0, 1_000.0)).unit("mm/s");
//!         /// Moves the planner looks ahead.           a key that is not the field's name
//!         "planner_queue_size" queue_size: u16 = integer("32", &(1, 65_535));
//!         /// Limit of the jerk; 0: none.              a field that is not simply the value
//!         jerk: Option<MmPerSecond3> = number("0", NOT_NEGATIVE) => some_jerk;
//!         /// Limits of the jerk of X, Y and Z.        a field without a setting of its own
//!         axis_jerk: [Option<MmPerSecond3>; 3];
//!         /// The same for X.                          a setting that fills a part of a field
//!         "x_axis_max_jerk" axis_jerk[0] = number("0", NOT_NEGATIVE) => some_jerk;
//!         /// Which corners are meant.                 a setting that fills several fields
//!         "corners" = word("all", CORNERS) => PlannerConfig::set_corners;
//!         /// Speed of a function to come.             a setting that nothing reads yet
//!         "leap_speed" = number("0", ANY).dormant();
//!     }
//! }
//! ```
//!
//! A line `rows NAME:` in a struct ends a list of rows and begins the next, so that rows of another struct
//! can stand between. Rows for a struct that is declared elsewhere are `rows NAME of STRUCT { ... }`. The
//! table of sections (`schema/table.rs`) says which lists a section consists of.
//!
//! A row begins with a builder of [`super::build`], which takes the default and the range. The value is
//! converted to the field's type by [`super::field`], or by the function behind `=>`.

use super::{Docs, Setting};
use crate::setting::value::Value;

/// Puts a value into a field of the struct `S`. A value of another kind cannot come from the reader, and is
/// left out.
pub(crate) type Setter<S> = for<'v> fn(&mut S, &'v Value<'v>);

/// Settings that fill one struct, in the order of the reference.
pub(crate) trait Rows {
    /// Struct that holds the values.
    type Target: 'static;
    /// Documentation of the section.
    const DOCS: Docs;
    /// Rows of the schema.
    const SETTINGS: &'static [Setting];
    /// Setters of the rows, in the same order.
    const SETTERS: &'static [Setter<Self::Target>];
}

/// Declares a struct and its settings; see the head of this file.
macro_rules! settings {
    (
        $(#[doc = $about:literal])+
        #[derive($($derived:ident),+)]
        pub struct $name:ident { $($body:tt)* }
    ) => {
        settings!(@next {[$($about)+] [$($derived),+]} $name of $name {} {} {} $($body)*);
    };
    ($(#[doc = $about:literal])+ rows $name:ident of $target:ident { $($body:tt)* }) => {
        settings!(@next {[$($about)+] []} $name of $target {} {} {} $($body)*);
    };
    // `field: Type;`
    (
        @next $head:tt $name:ident of $target:ident {$($fields:tt)*} $rows:tt $setters:tt
        $(#[$doc:meta])+ $field:ident: $type:ty; $($rest:tt)*
    ) => {
        settings!(@next $head $name of $target {$($fields)* $(#[$doc])+ pub $field: $type,} $rows $setters $($rest)*);
    };
    // `field: Type = row;`
    (
        @next $head:tt $name:ident of $target:ident $fields:tt $rows:tt $setters:tt
        $(#[doc = $help:literal])+ $field:ident: $type:ty = $row:expr $(=> $convert:expr)?; $($rest:tt)*
    ) => {
        settings!(@field $head $name of $target $fields $rows $setters [$($help)+] [stringify!($field)]
            $field [$type] [$row] [$(=> $convert)?] $($rest)*);
    };
    // `"key" field: Type = row;`
    (
        @next $head:tt $name:ident of $target:ident $fields:tt $rows:tt $setters:tt
        $(#[doc = $help:literal])+ $key:literal $field:ident: $type:ty = $row:expr $(=> $convert:expr)?; $($rest:tt)*
    ) => {
        settings!(@field $head $name of $target $fields $rows $setters [$($help)+] [$key]
            $field [$type] [$row] [$(=> $convert)?] $($rest)*);
    };
    (
        @field $head:tt $name:ident of $target:ident {$($fields:tt)*} $rows:tt $setters:tt [$($help:literal)+] $key:tt
        $field:ident [$type:ty] $row:tt $convert:tt $($rest:tt)*
    ) => {
        settings!(@row $head $name of $target {$($fields)* $(#[doc = $help])+ pub $field: $type,} $rows $setters
            [$($help)+] $key [.$field] $row $convert $($rest)*);
    };
    // `"key" = row;`
    (
        @next $head:tt $name:ident of $target:ident $fields:tt $rows:tt $setters:tt
        $(#[doc = $help:literal])+ $key:literal = $row:expr $(=> $convert:expr)?; $($rest:tt)*
    ) => {
        settings!(@row $head $name of $target $fields $rows $setters
            [$($help)+] [$key] [] [$row] [$(=> $convert)?] $($rest)*);
    };
    // `"key" field[0].part = row;`
    (
        @next $head:tt $name:ident of $target:ident $fields:tt $rows:tt $setters:tt
        $(#[doc = $help:literal])+ $key:literal $($field:ident)? $([$place:literal])? $(.$part:ident $([$at:literal])?)*
        = $row:expr $(=> $convert:expr)?; $($rest:tt)*
    ) => {
        settings!(@row $head $name of $target $fields $rows $setters
            [$($help)+] [$key] [$(.$field)? $([$place])? $(.$part $([$at])?)*] [$row] [$(=> $convert)?] $($rest)*);
    };
    // A row and its setter.
    (
        @row $head:tt $name:ident of $target:ident $fields:tt {$($rows:tt)*} {$($setters:tt)*}
        [$($help:literal)+] [$key:expr] $place:tt [$row:expr] $convert:tt $($rest:tt)*
    ) => {
        settings!(@next $head $name of $target $fields
            {$($rows)* $row.named($key, concat!($($help),+)),}
            {$($setters)* $crate::setting::declare::setter!($target, $place $convert),}
            $($rest)*);
    };
    // `rows NAME:`
    (
        @next {[$($about:literal)+] $derived:tt} $name:ident of $target:ident $fields:tt $rows:tt $setters:tt
        rows $next:ident: $($rest:tt)*
    ) => {
        settings!(@rows $name of $target [$($about)+] $rows $setters);
        /// Further rows of the struct.
        pub(crate) struct $next;
        settings!(@next {[$($about)+] $derived} $next of $target $fields {} {} $($rest)*);
    };
    // The end: without fields it is no struct.
    (@next {[$($about:literal)+] []} $name:ident of $target:ident {} $rows:tt $setters:tt) => {
        $(#[doc = $about])+
        pub(crate) struct $name;
        settings!(@rows $name of $target [$($about)+] $rows $setters);
    };
    (
        @next {[$($about:literal)+] [$($derived:ident),+]} $name:ident of $target:ident {$($fields:tt)*} $rows:tt $setters:tt
    ) => {
        $(#[doc = $about])+
        #[derive($($derived),+)]
        pub struct $target {
            $($fields)*
        }
        settings!(@rows $name of $target [$($about)+] $rows $setters);
    };
    (@rows $name:ident of $target:ident [$($about:literal)+] {$($rows:tt)*} {$($setters:tt)*}) => {
        #[allow(clippy::redundant_closure_call, reason = "the conversion may be a closure or the name of a function")]
        impl $crate::setting::declare::Rows for $name {
            type Target = $target;
            const DOCS: $crate::setting::Docs = $crate::setting::Docs::new(concat!($($about),+));
            const SETTINGS: &'static [$crate::setting::Setting] = &[$($rows)*];
            const SETTERS: &'static [$crate::setting::declare::Setter<$target>] = &[$($setters)*];
        }
    };
}

/// The setter of a place in a struct, with the conversion behind `=>` where there is one.
macro_rules! setter {
    ($target:ident, [] []) => {
        |_, _| {}
    };
    ($target:ident, [] [=> $convert:expr]) => {
        |target, value| $crate::setting::field::with(value, |value| ($convert)(target, value))
    };
    ($target:ident, [$($place:tt)+] []) => {
        |target: &mut $target, value| $crate::setting::field::Field::set(&mut target$($place)+, value)
    };
    ($target:ident, [$($place:tt)+] [=> $convert:expr]) => {
        |target: &mut $target, value| $crate::setting::field::with(value, |value| target$($place)+ = ($convert)(value))
    };
}

/// Declares words of the file and what they mean: an enum, in the order of the reference. The first variant
/// may be marked `#[default]`, or any other.
macro_rules! words {
    (
        $(#[$attr:meta])*
        pub enum $name:ident { $($(#[$doc:meta])* $variant:ident = $word:literal),+ $(,)? }
    ) => {
        $(#[$attr])*
        pub enum $name {
            $($(#[$doc])* $variant,)+
        }

        impl $name {
            /// All values, in the order of [`Self::WORDS`].
            pub const ALL: &'static [Self] = &[$(Self::$variant),+];
            /// Words in the file, in the order of [`Self::ALL`].
            pub const WORDS: &'static $crate::setting::Words = &$crate::setting::Words(&[$($word),+]);

            /// Returns the word in the file.
            #[must_use]
            pub const fn word(self) -> &'static str {
                match self {
                    $(Self::$variant => $word,)+
                }
            }
        }

        $crate::setting::field::word_field!($name);
    };
}

pub(crate) use {setter, settings, words};
