//! Answers of Jinja2 3.1.6, as `make macros` has written them down, beside ours.

mod desk;

use macros::{Nothing, compile, rewrite_literal};
use serde_json::Value;

use desk::Desk;

const TABLE: &str = include_str!("jinja2.jsonl");

fn rows() -> impl Iterator<Item = Value> {
    TABLE.lines().map(|line| serde_json::from_str(line).expect("a line of JSON"))
}

/// Our answer to a template: whether it is refused, and its text where there is no error.
fn ours(template: &str, context: &Value) -> (bool, Option<String>) {
    let (mut memory, mut output) = (vec![0; 28 * 1024], vec![0; 12 * 1024]);
    let Ok(program) = compile(&mut template.bytes(), &mut memory) else { return (true, None) };
    let mut machine = Desk::new(context.as_object().expect("variables"));
    let length = program.render(&mut memory, &mut output, &mut machine).ok();
    (false, length.map(|length| String::from_utf8(output[..length].to_vec()).expect("UTF-8")))
}

#[test]
fn templates_are_refused_fail_and_become_texts_as_in_jinja2() {
    let context = rows().next().expect("a table")["context"].clone();
    let mut wrong = Vec::new();
    let mut count = 0;
    for row in rows().filter(|row| row["template"].is_string()) {
        let template = row["template"].as_str().unwrap_or_default();
        let theirs = (row["refused"] == true, row["text"].as_str().map(str::to_owned));
        let ours = ours(template, &context);
        count += 1;
        if ours != theirs {
            wrong.push(format!("{template}\n  Jinja2: {theirs:?}\n  ours:   {ours:?}"));
        }
    }
    assert!(count > 900, "{count} rows");
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn literals_are_read_and_written_as_python_does() {
    let mut count = 0;
    for row in rows().filter(|row| row["literal"].is_string()) {
        let text = row["literal"].as_str().unwrap_or_default();
        let (mut memory, mut output) = ([0; 2048], [0; 256]);
        let length = rewrite_literal(text, &mut memory, &mut output).ok();
        let ours = length.map(|length| String::from_utf8_lossy(&output[..length]).into_owned());
        assert_eq!(ours.as_deref(), row["text"].as_str(), "{text:?}");
        count += 1;
    }
    assert!(count > 40, "{count} rows");
}

#[test]
fn errors_name_the_place_and_the_fix() {
    let error = |template: &str| {
        let (mut memory, mut output) = ([0; 4096], [0; 256]);
        let program = compile(&mut template.bytes(), &mut memory);
        let error = program.and_then(|program| program.render(&mut memory, &mut output, &mut Nothing));
        error.expect_err(template).to_string()
    };
    let fix = "correct the name, or put |default(...) behind it";
    assert_eq!(error("G28\nG1 X{a.b}"), format!("line 2 column 5: a: this is not there: {fix}"));
    assert_eq!(
        error("{% if 1 %}"),
        "line 1 column 4: the tag that begins here has no end: put {% endif %}, {% endfor %} or {% endset %}"
    );
    assert_eq!(error("a\n {5|nonsense}"), "line 2 column 13: nonsense: there is no filter of this name");
    assert_eq!(
        error("{'5' > 3}"),
        "line 1 column 1: int: a string and this have no order: make a number of the string with |int or |float"
    );
    assert_eq!(error("{action_raise_error('no home')}"), "line 1 column 1: no home: raised by the macro");
}

#[test]
fn tags_and_loops_that_are_not_known_are_refused_by_name() {
    for (template, word) in [
        ("{% macro x() %}{% endmacro %}", "macro"),
        ("{% include 'x' %}", "include"),
        ("{% import 'x' as y %}", "import"),
        ("{% from 'x' import y %}", "from"),
        ("{% call x() %}{% endcall %}", "call"),
        ("{% raw %}{x}{% endraw %}", "raw"),
        ("{% filter upper %}a{% endfilter %}", "filter"),
        ("{% with a = 1 %}{a}{% endwith %}", "with"),
        ("{% block a %}{% endblock %}", "block"),
    ] {
        let error = compile(&mut template.bytes(), &mut [0; 1024]).expect_err(template);
        assert_eq!((error.line, error.column, error.detail.as_str()), (1, 4, word), "{error}");
    }
    let error = compile(&mut "{% for x in y recursive %}{% endfor %}".bytes(), &mut [0; 1024]).expect_err("recursive");
    assert_eq!((error.line, error.column), (1, 15), "{error}");
}

#[test]
fn what_does_not_fit_is_refused_with_the_size_and_never_cut() {
    let long = format!("{{% set a = '{}' %}}{{a ~ a}}", "x".repeat(200));
    let mut needed = None;
    for size in 0..2000 {
        let (mut memory, mut output) = (vec![0; size], [0; 512]);
        let program = compile(&mut long.bytes(), &mut memory);
        match program.and_then(|program| program.render(&mut memory, &mut output, &mut Nothing)) {
            Ok(length) => {
                assert_eq!(&output[..length], "x".repeat(400).as_bytes());
                needed.get_or_insert(size);
            }
            Err(error) => {
                assert!(needed.is_none(), "{size} bytes do and then do not");
                assert!(error.words.contains("memory"), "{error}");
            }
        }
    }
    assert!(needed.is_some_and(|needed| needed < 1200), "{needed:?}");
    let (mut memory, mut output) = ([0; 4096], [0; 399]);
    let program = compile(&mut long.bytes(), &mut memory).expect("fits");
    let error = program.render(&mut memory, &mut output, &mut Nothing).expect_err("one byte too few");
    assert_eq!(error.detail, "399");
}

#[test]
fn too_little_memory_is_named_at_any_size() {
    for template in [
        "{% for a, (b, c) in [(1, (2, 3))] %}{a}{% set (d, e), f = (1, 2), 3 %}{d}{% else %}-{% endfor %}",
        "{% set t | upper | replace('A', 'b') %}a{% if 1 < 2 < 3 %}{2 ** 62}{% elif 0 %}x{% endif %}{% endset %}{t}",
        "{ {'a': [1, 2.5, 'x'], 'b': (1,)} }{['b', 'a']|sort|join('-')}{'%5.1f|%s' % (2, 'a')}{'a b'.split()|list}",
        "{[1, 2, 3]|batch(2, 0)|list}{'x'|center(9)}{range(5)|map('string')|list}{dict(a=1, **{'b': 2})|pprint}",
    ] {
        let mut needed = None;
        for size in 0..2500 {
            let (mut memory, mut output) = (vec![0; size], [0; 512]);
            let program = compile(&mut template.bytes(), &mut memory);
            match program.and_then(|program| program.render(&mut memory, &mut output, &mut Nothing)) {
                Ok(length) => assert_eq!(*needed.get_or_insert(length), length, "{template} {size}"),
                Err(error) => {
                    assert!(needed.is_none(), "{template} {size} bytes do and then do not");
                    assert!(error.words.contains("memory"), "{template} {size}: {error}");
                }
            }
        }
        assert!(needed.is_some(), "{template}");
    }
}

#[test]
fn a_loop_makes_no_garbage_that_stays() {
    let template = "{% set n = namespace(s=0) %}{% for i in range(5000) %}{% set t = 'abc' ~ i %}{% set n.s = n.s + t|length %}\
                    {% endfor %}{n.s}";
    let (mut memory, mut output) = ([0; 1024], [0; 64]);
    let program = compile(&mut template.bytes(), &mut memory).expect("fits");
    let length = program.render(&mut memory, &mut output, &mut Nothing).expect("fits");
    assert_eq!(&output[..length], b"33890");
}
