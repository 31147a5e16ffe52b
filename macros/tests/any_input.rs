//! Any bytes and any words: no panic, no output beyond its place, an end.

use macros::{Action, Environment, Given, Kind, Object, compile, rewrite_literal};
use proptest::prelude::*;

/// A machine that has something of every kind.
struct Anything;

impl Environment for Anything {
    fn variable(&mut self, name: &str) -> Option<Given<'_>> {
        Some(match name {
            "printer" => Given::Object(Object { id: 0, kind: Kind::Lookup }),
            "params" => Given::Object(Object { id: 1, kind: Kind::Dict }),
            "rawparams" => Given::Text("X=1 Y=2"),
            "a" => Given::Int(-7),
            "b" => Given::Literal("[1, 'x', (2.5, None), {'k': [True]}]"),
            "c" => Given::Object(Object { id: 2, kind: Kind::Tuple }),
            "d" => Given::Float(1e300),
            _ => return None,
        })
    }

    fn member(&mut self, object: Object, name: &str) -> Option<Given<'_>> {
        match name.len() % 3 {
            0 => Some(Given::Object(Object { id: object.id + 1, kind: Kind::List })),
            1 => Some(Given::Text("text")),
            _ => None,
        }
    }

    fn length(&mut self, object: Object) -> usize {
        (object.id % 4) as usize
    }

    fn element(&mut self, object: Object, index: usize) -> Option<Given<'_>> {
        match object.kind {
            Kind::Lookup | Kind::Dict => Some(Given::Text(["k", "key", "keys", "k4"][index % 4])),
            Kind::List | Kind::Tuple if index == 1 => Some(Given::Object(Object { id: object.id, ..object })),
            Kind::List | Kind::Tuple => Some(Given::Int(index as i64)),
        }
    }

    fn act(&mut self, _: Action, _: &str) {}

    fn random(&mut self, limit: usize) -> usize {
        limit
    }
}

fn try_out(template: &[u8], size: usize) {
    let (mut memory, mut output) = (vec![0; size], vec![0; 300]);
    if let Ok(program) = compile(&mut template.iter().copied(), &mut memory) {
        assert!(program.size() <= size);
        for _ in 0..2 {
            if let Ok(length) = program.render(&mut memory, &mut output, &mut Anything) {
                assert!(length <= output.len());
            }
        }
    }
}

const WORDS: &[&str] = &[
    "{% if ",
    "{% elif ",
    "{% else %}",
    "{% endif %}",
    "{% for x in ",
    "{% for x, y in ",
    "{% endfor %}",
    "{% set x = ",
    "{% set x %}",
    "{% endset %}",
    "{% set x, y = ",
    "{% set n.z = ",
    " %}",
    "{",
    "}",
    "{#",
    "#}",
    "-%}",
    "{%-",
    "(",
    ")",
    "[",
    "]",
    "[1:]",
    "[::-1]",
    ",",
    ".",
    ":",
    "|",
    "~",
    "+",
    "-",
    "*",
    "**",
    "/",
    "//",
    "%",
    "==",
    "<",
    ">=",
    " in ",
    " not in ",
    " not ",
    " and ",
    " or ",
    " is ",
    " if ",
    " else ",
    "x",
    "y",
    "a",
    "b",
    "c",
    "d",
    "n",
    "loop",
    ".index",
    ".last",
    "printer",
    "params",
    "rawparams",
    "1",
    "0",
    "2.5",
    "1e308",
    "9223372036854775807",
    "'s'",
    "'%s %d'",
    "'{} {:>5}'",
    "\"é\"",
    "none",
    "true",
    "|int",
    "|float",
    "|default(1)",
    "|list",
    "|join(',')",
    "|sort",
    "|map('int')",
    "|select",
    "|round(2)",
    "|length",
    "|sum",
    "|max",
    "|replace('s', '')",
    "|pprint",
    "|string",
    "|batch(2)",
    "|slice(3)",
    "|dictsort",
    "|unique",
    "|truncate(3)",
    "|indent",
    ".append(",
    ".update(",
    ".items()",
    ".pop()",
    ".insert(0, ",
    ".split('s')",
    ".format(",
    ".get(",
    ".join(",
    ".zfill(300)",
    "range(",
    "namespace(",
    "dict(",
    "defined",
    "none",
    "odd",
    "mapping",
    "action_respond_info(",
    "{'k': ",
    "k=",
    "*b",
    "**params",
    "\n",
    "G1 X",
    "\u{a0}",
];

proptest! {
    #![proptest_config(ProptestConfig::with_cases(4000))]

    #[test]
    fn any_bytes_are_read(template in proptest::collection::vec(any::<u8>(), 0..200), size in 0_usize..3000) {
        try_out(&template, size);
    }

    #[test]
    fn any_words_are_read(words in proptest::collection::vec(0..WORDS.len(), 0..40), size in 0_usize..6000) {
        let template: String = words.iter().map(|index| WORDS[*index]).collect();
        try_out(template.as_bytes(), size);
    }

    #[test]
    fn any_expression_is_calculated(words in proptest::collection::vec(0..WORDS.len(), 1..12), begin in 0..5_usize) {
        let begin = ["{a", "{b", "{% set x = b %}{x", "{% for x in b %}{loop.index}{x", "{params"][begin];
        let template: String = core::iter::once(begin).chain(words.iter().map(|index| WORDS[*index])).chain(["}"]).collect();
        try_out(template.as_bytes(), 8000);
    }

    #[test]
    fn any_literal_is_read(text in "[\\[\\](){}:,'\" 0-9a-zA-Z.+\\-\\\\]{0,40}", size in 0_usize..1000) {
        let (mut memory, mut output) = (vec![0; size], [0; 200]);
        if let Ok(length) = rewrite_literal(&text, &mut memory, &mut output) {
            let once = output[..length].to_vec();
            let text = core::str::from_utf8(&once).expect("UTF-8");
            let length = rewrite_literal(text, &mut [0; 4000], &mut output).expect("its own text");
            prop_assert_eq!(&once, &output[..length]);
        }
    }

    #[test]
    fn numbers_read_back_as_they_are_written(bits in any::<u64>()) {
        let number = f64::from_bits(bits);
        prop_assume!(number.is_finite());
        let mut output = [0; 64];
        let length = rewrite_literal(&format!("{number:e}"), &mut [0; 500], &mut output).expect("a number");
        let text = core::str::from_utf8(&output[..length]).expect("ASCII");
        prop_assert_eq!(text.parse::<f64>().ok(), Some(number));
        let digits = |text: &str| {
            let mantissa = text.split('e').next().unwrap_or_default().replace(['-', '.'], "");
            mantissa.trim_matches('0').to_owned()
        };
        // Of two texts of the same length and distance Python takes the even one, Rust does not.
        prop_assert_eq!(digits(text).len(), digits(&format!("{number:e}")).len(), "{}", text);
    }
}
