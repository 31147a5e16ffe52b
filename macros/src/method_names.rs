//! Names of the methods of each type, and of their arguments: `*` takes any.

use crate::environment::Kind;
use crate::value::{Map, Seq, Value, View};

/// Names of the methods of a value, and of each method's arguments.
pub fn methods(value: Value) -> &'static [(&'static str, &'static str)] {
    match value.view() {
        View::Str(_) => OF_STRINGS,
        View::Map(Map::Dict, _) => OF_DICTS,
        View::Seq(Seq::List, _) => OF_LISTS,
        View::Seq(Seq::Tuple, _) | View::Range(_) => OF_TUPLES,
        View::Float(_) => &[("is_integer", "")],
        View::Object(object) => match object.kind {
            Kind::Dict => OF_DICTS,
            Kind::List => OF_LISTS,
            Kind::Tuple => OF_TUPLES,
            Kind::Lookup => &[],
        },
        _ => &[],
    }
}

/// Whether a name is that of a method of a value.
pub fn is_method(name: &str, value: Value) -> bool {
    methods(value).iter().any(|(known, _)| *known == name)
}

const OF_STRINGS: &[(&str, &str)] = &[
    ("split", "sep maxsplit"),
    ("rsplit", "sep maxsplit"),
    ("splitlines", ""),
    ("format", "*"),
    ("startswith", "prefix"),
    ("endswith", "suffix"),
    ("lower", ""),
    ("upper", ""),
    ("capitalize", ""),
    ("title", ""),
    ("swapcase", ""),
    ("strip", "chars"),
    ("lstrip", "chars"),
    ("rstrip", "chars"),
    ("replace", "old new count"),
    ("join", "iterable"),
    ("find", "sub"),
    ("rfind", "sub"),
    ("index", "sub"),
    ("count", "sub"),
    ("isdigit", ""),
    ("isdecimal", ""),
    ("isnumeric", ""),
    ("isalpha", ""),
    ("isalnum", ""),
    ("isspace", ""),
    ("isupper", ""),
    ("islower", ""),
    ("zfill", "width"),
    ("ljust", "width fillchar"),
    ("rjust", "width fillchar"),
    ("center", "width fillchar"),
    ("removeprefix", "prefix"),
    ("removesuffix", "suffix"),
    ("partition", "sep"),
    ("rpartition", "sep"),
];

const OF_LISTS: &[(&str, &str)] = &[
    ("append", "object"),
    ("extend", "iterable"),
    ("insert", "index object"),
    ("pop", "index"),
    ("remove", "value"),
    ("reverse", ""),
    ("sort", ""),
    ("clear", ""),
    ("copy", ""),
    ("index", "value"),
    ("count", "value"),
    ("__setitem__", "index object"),
    ("__getitem__", "index"),
    ("__len__", ""),
];

const OF_TUPLES: &[(&str, &str)] = &[("index", "value"), ("count", "value"), ("__getitem__", "index"), ("__len__", "")];

const OF_DICTS: &[(&str, &str)] = &[
    ("get", "key default"),
    ("keys", ""),
    ("values", ""),
    ("items", ""),
    ("update", "mapping"),
    ("pop", "key default"),
    ("popitem", ""),
    ("setdefault", "key default"),
    ("copy", ""),
    ("clear", ""),
    ("__setitem__", "key value"),
    ("__getitem__", "key"),
    ("__contains__", "key"),
    ("__len__", ""),
];
