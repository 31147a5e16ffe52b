//! Names of filters, tests, functions and methods, and the names of their arguments.

use crate::chars::nth;
use crate::value::{Value, types};

/// Names of a kind, in order. Of each: its words with `|` between them, a blank, the names of its arguments
/// with blanks between them (`*` takes any), and `;`.
pub type Table = &'static str;

/// Makes an enum of names, and their table.
macro_rules! names {
    ($(#[$doc:meta])* $kind:ident: $($name:ident $first:literal $(or $more:literal)* ($parameters:literal),)*) => {
        $(#[$doc])*
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        pub enum $kind { $($name,)* }

        impl $kind {
            /// Names of the kind.
            pub const NAMES: $crate::names::Table = concat!($($first, $("|", $more,)* " ", $parameters, ";",)*);

            /// The entry with a number; the first one for numbers beyond them.
            pub fn from_number(number: u8) -> Self {
                const ALL: &[$kind] = &[$($kind::$name,)*];
                ALL.get(usize::from(number)).copied().unwrap_or(ALL[0])
            }
        }
    };
}

pub(crate) use names;

names! {
    /// Filters of Jinja2.
    Filter:
    Abs "abs" (""), Attr "attr" ("name"), Batch "batch" ("linecount fill_with"), Capitalize "capitalize" (""),
    Center "center" ("width"), Length "length" or "count" (""),
    Default "default" or "d" ("default_value boolean"), DictSort "dictsort" ("case_sensitive by reverse"),
    First "first" (""), Float "float" ("default"), Format "format" ("*"), Indent "indent" ("width first blank"),
    Int "int" ("default base"), Join "join" ("d attribute"), Last "last" (""), List "list" (""),
    Lower "lower" (""), Items "items" (""), Map "map" ("*"), Min "min" ("case_sensitive attribute"),
    Max "max" ("case_sensitive attribute"), Pprint "pprint" (""), Random "random" (""), Reject "reject" ("*"),
    RejectAttr "rejectattr" ("*"), Replace "replace" ("old new count"), Reverse "reverse" (""),
    Round "round" ("precision method"), Select "select" ("*"), SelectAttr "selectattr" ("*"),
    Slice "slice" ("slices fill_with"), Sort "sort" ("reverse case_sensitive attribute"), Text "string" (""),
    Sum "sum" ("attribute start"), Title "title" (""), Trim "trim" ("chars"),
    Truncate "truncate" ("length killwords end leeway"), Unique "unique" ("case_sensitive attribute"),
    Upper "upper" (""), WordCount "wordcount" (""),
}

names! {
    /// Tests of Jinja2, which stand behind `is`.
    Test:
    Odd "odd" (""), Even "even" (""), DivisibleBy "divisibleby" ("num"), Defined "defined" (""),
    Undefined "undefined" (""), IsFilter "filter" (""), Known "test" (""), None "none" (""), Boolean "boolean" (""),
    False "false" (""), True "true" (""), Integer "integer" (""), Float "float" (""), Lower "lower" (""),
    Upper "upper" (""), Text "string" (""), Mapping "mapping" (""), Number "number" (""),
    Sequence "sequence" (""), Iterable "iterable" (""), Callable "callable" (""), SameAs "sameas" ("other"),
    Escaped "escaped" (""), In "in" ("seq"), Equal "==" or "eq" or "equalto" ("b"), Unequal "!=" or "ne" ("b"),
    Greater ">" or "gt" or "greaterthan" ("b"), AtLeast ">=" or "ge" ("b"), Less "<" or "lt" or "lessthan" ("b"),
    AtMost "<=" or "le" ("b"),
}

names! {
    /// Functions that a template can call: those of Klipper first.
    Function:
    Respond "action_respond_info" ("msg"), RaiseError "action_raise_error" ("msg"),
    EmergencyStop "action_emergency_stop" ("msg"), CallRemoteMethod "action_call_remote_method" ("*"),
    Range "range" ("start stop step"), Dict "dict" ("*"), Namespace "namespace" ("*"),
}

names! {
    /// Methods of strings.
    OfString:
    Split "split" ("sep maxsplit"), RSplit "rsplit" ("sep maxsplit"), SplitLines "splitlines" (""),
    Format "format" ("*"), StartsWith "startswith" ("prefix"), EndsWith "endswith" ("suffix"), Lower "lower" (""),
    Upper "upper" (""), Capitalize "capitalize" (""), Title "title" (""), SwapCase "swapcase" (""),
    Strip "strip" ("chars"), LStrip "lstrip" ("chars"), RStrip "rstrip" ("chars"), Replace "replace" ("old new count"),
    Join "join" ("iterable"), Find "find" ("sub"), RFind "rfind" ("sub"), Index "index" ("sub"), Count "count" ("sub"),
    IsDigit "isdigit" or "isdecimal" or "isnumeric" (""), IsAlpha "isalpha" (""), IsAlnum "isalnum" (""),
    IsSpace "isspace" (""), IsUpper "isupper" (""), IsLower "islower" (""), ZFill "zfill" ("width"),
    LJust "ljust" ("width fillchar"), RJust "rjust" ("width fillchar"), Center "center" ("width fillchar"),
    RemovePrefix "removeprefix" ("prefix"), RemoveSuffix "removesuffix" ("suffix"), Partition "partition" ("sep"),
    RPartition "rpartition" ("sep"),
}

names! {
    /// Methods of lists, those of tuples first.
    OfList:
    Index "index" ("value"), Count "count" ("value"), Get "__getitem__" ("index"), Length "__len__" (""),
    Append "append" ("object"), Extend "extend" ("iterable"), Insert "insert" ("index object"), Pop "pop" ("index"),
    Remove "remove" ("value"), Reverse "reverse" (""), Sort "sort" (""), Clear "clear" (""), Copy "copy" (""),
    Set "__setitem__" ("index object"),
}

names! {
    /// Methods of dicts.
    OfDict:
    Update "update" ("*"), Get "get" ("key default"), Keys "keys" (""), Values "values" (""), Items "items" (""),
    Pop "pop" ("key default"), PopItem "popitem" (""), SetDefault "setdefault" ("key default"), Copy "copy" (""),
    Clear "clear" (""), Set "__setitem__" ("key value"), Item "__getitem__" ("key"),
    Contains "__contains__" ("key"), Length "__len__" (""),
}

names! {
    /// Members of `loop`.
    OfLoop:
    Index "index" (""), Index0 "index0" (""), First "first" (""), Depth "depth" (""), Depth0 "depth0" (""),
    Cycle "cycle" ("*"), Changed "changed" ("*"), Last "last" (""), Length "length" (""), RevIndex "revindex" (""),
    RevIndex0 "revindex0" (""), Previous "previtem" (""), Next "nextitem" (""),
}

const OF_FLOAT: Table = "is_integer ;";

/// Number of the entry that a word names.
#[inline(never)]
pub fn find(table: Table, word: &[u8]) -> Option<u8> {
    let mut number = 0;
    let (mut fits, mut length) = (true, 0);
    for byte in table.bytes() {
        match byte {
            b'|' | b' ' if fits && length == word.len() => return Some(number),
            b'|' => (fits, length) = (true, 0),
            // The names of arguments are no words of the entry.
            b' ' => fits = false,
            b';' => {
                number += 1;
                (fits, length) = (true, 0);
            }
            _ => {
                fits &= word.get(length) == Some(&byte);
                length += 1;
            }
        }
    }
    None
}

/// Names of the arguments of an entry.
#[inline(never)]
pub fn parameters(table: Table, number: u8) -> &'static [u8] {
    let entry = nth(table, b';', usize::from(number)).as_bytes();
    let end = entry.iter().position(|byte| *byte == b' ').unwrap_or(0);
    entry.get(end + 1..).unwrap_or_default()
}

/// Names of the methods of a value.
pub fn methods(value: Value) -> Table {
    if value.text().is_some() {
        OfString::NAMES
    } else if value.is(types::DICT) {
        OfDict::NAMES
    } else if value.is(types::FLOAT) {
        OF_FLOAT
    } else if value.is(types::LIST | types::TUPLE | types::RANGE) {
        OfList::NAMES
    } else {
        ""
    }
}

/// Number of a method of a value.
#[inline(never)]
pub fn method(value: Value, word: &[u8]) -> Option<u8> {
    let number = find(methods(value), word)?;
    let is_of_tuples = number <= OfList::Length as u8;
    (is_of_tuples || !value.is(types::TUPLE | types::RANGE)).then_some(number)
}

#[cfg(test)]
mod tests {
    use super::{Filter, OfList, Test, find, parameters};

    #[test]
    fn each_word_of_an_entry_names_it() {
        let filter = |word: &str| find(Filter::NAMES, word.as_bytes()).map(Filter::from_number);
        assert_eq!(
            (filter("abs"), filter("count"), filter("length")),
            (Some(Filter::Abs), Some(Filter::Length), Some(Filter::Length))
        );
        assert_eq!((filter("wordcount"), filter("d")), (Some(Filter::WordCount), Some(Filter::Default)));
        assert_eq!((filter("width"), filter("ab"), filter("abso"), filter("")), (None, None, None, None));
        assert_eq!(find(Test::NAMES, b"lessthan").map(Test::from_number), Some(Test::Less));
    }

    #[test]
    fn an_entry_has_the_names_of_its_arguments() {
        let of = |word: &[u8]| parameters(Filter::NAMES, find(Filter::NAMES, word).expect("known"));
        assert_eq!((of(b"abs"), of(b"indent"), of(b"map")), (&b""[..], &b"width first blank"[..], &b"*"[..]));
        assert_eq!(parameters(OfList::NAMES, 200), b"");
    }
}
