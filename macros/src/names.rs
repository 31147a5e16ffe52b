//! Names of filters, tests and functions, and the names of their arguments.

macro_rules! words {
    ($(#[$doc:meta])* $kind:ident $table:ident: $($name:ident $($word:literal)+ ($parameters:literal),)*) => {
        $(#[$doc])*
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        pub enum $kind { $($name,)* }

        const $table: &[($kind, &[&str], &str)] = &[$(($kind::$name, &[$($word,)+], $parameters),)*];

        impl $kind {
            /// The entry with a number, and the names of its arguments.
            pub fn from_number(number: u8) -> Option<(Self, &'static str)> {
                $table.get(usize::from(number)).map(|(entry, _, parameters)| (*entry, *parameters))
            }
        }
    };
}

words! {
    /// Filters of Jinja2. Parameters: `*` takes any arguments.
    Filter FILTERS:
    Abs "abs" (""), Attr "attr" ("name"), Batch "batch" ("linecount fill_with"), Capitalize "capitalize" (""),
    Center "center" ("width"), Length "length" "count" (""), Default "default" "d" ("default_value boolean"),
    DictSort "dictsort" ("case_sensitive by reverse"), First "first" (""), Float "float" ("default"),
    Format "format" ("*"), Indent "indent" ("width first blank"), Int "int" ("default base"),
    Join "join" ("d attribute"), Last "last" (""), List "list" (""), Lower "lower" (""), Items "items" (""),
    Map "map" ("*"), Min "min" ("case_sensitive attribute"), Max "max" ("case_sensitive attribute"),
    Pprint "pprint" (""), Random "random" (""), Reject "reject" ("*"), RejectAttr "rejectattr" ("*"),
    Replace "replace" ("old new count"), Reverse "reverse" (""), Round "round" ("precision method"),
    Select "select" ("*"), SelectAttr "selectattr" ("*"), Slice "slice" ("slices fill_with"),
    Sort "sort" ("reverse case_sensitive attribute"), Text "string" (""), Sum "sum" ("attribute start"),
    Title "title" (""), Trim "trim" ("chars"), Truncate "truncate" ("length killwords end leeway"),
    Unique "unique" ("case_sensitive attribute"), Upper "upper" (""), WordCount "wordcount" (""),
}

words! {
    /// Tests of Jinja2, which stand behind `is`.
    Test TESTS:
    Odd "odd" (""), Even "even" (""), DivisibleBy "divisibleby" ("num"), Defined "defined" (""),
    Undefined "undefined" (""), IsFilter "filter" (""), Known "test" (""), None "none" (""), Boolean "boolean" (""),
    False "false" (""), True "true" (""), Integer "integer" (""), Float "float" (""), Lower "lower" (""),
    Upper "upper" (""), Text "string" (""), Mapping "mapping" (""), Number "number" (""),
    Sequence "sequence" (""), Iterable "iterable" (""), Callable "callable" (""), SameAs "sameas" ("other"),
    Escaped "escaped" (""), In "in" ("seq"), Equal "==" "eq" "equalto" ("b"), Unequal "!=" "ne" ("b"),
    Greater ">" "gt" "greaterthan" ("b"), AtLeast ">=" "ge" ("b"), Less "<" "lt" "lessthan" ("b"),
    AtMost "<=" "le" ("b"),
}

words! {
    /// Functions that a template can call.
    Function FUNCTIONS:
    Range "range" ("start stop step"), Dict "dict" ("*"), Namespace "namespace" ("*"),
    Respond "action_respond_info" ("msg"), RaiseError "action_raise_error" ("msg"),
    EmergencyStop "action_emergency_stop" ("msg"), CallRemoteMethod "action_call_remote_method" ("*"),
}

fn number<T>(table: &[(T, &[&str], &str)], name: &str) -> Option<u8> {
    table.iter().position(|(_, words, _)| words.contains(&name)).map(|index| index as u8)
}

/// Number of a filter.
pub fn filter(name: &str) -> Option<u8> {
    number(FILTERS, name)
}

/// Number of a test.
pub fn test(name: &str) -> Option<u8> {
    number(TESTS, name)
}

/// Number of a function.
pub fn function(name: &str) -> Option<u8> {
    number(FUNCTIONS, name)
}
