//! Rules of the language, one test each: Python's where Jinja2 leaves them to Python.

use macros::{Nothing, compile};

/// The text of a template without variables, or none where there is an error.
fn rendered(template: &str) -> Option<String> {
    let (mut memory, mut output) = ([0; 4096], [0; 512]);
    let program = compile(&mut template.bytes(), &mut memory).ok()?;
    let length = program.render(&mut memory, &mut output, &mut Nothing).ok()?;
    Some(String::from_utf8_lossy(&output[..length]).into_owned())
}

fn becomes(template: &str, text: &str) {
    assert_eq!(rendered(template).as_deref(), Some(text), "{template}");
}

fn fails(template: &str) {
    assert_eq!(rendered(template), None, "{template}");
}

#[test]
fn real_division_gives_a_real_number() {
    becomes("{6 / 2} {7 / 2}", "3.0 3.5");
}

#[test]
fn floor_division_rounds_down() {
    becomes("{7 // 2} { -7 // 2} {7 // -2} { -7.5 // 2}", "3 -4 -4 -4.0");
}

#[test]
fn the_rest_has_the_sign_of_the_divisor() {
    becomes("{7 % 3} { -7 % 3} {7 % -3} { -7.5 % 2}", "1 2 -2 0.5");
}

#[test]
fn nothing_is_divided_by_zero() {
    fails("{1 / 0}");
    fails("{1 // 0}");
    fails("{1.0 % 0}");
}

#[test]
fn powers_bind_from_the_left() {
    becomes("{2 ** 3 ** 2} { -2 ** 2} {2 ** -1}", "64 4 0.5");
}

#[test]
fn whole_numbers_beyond_64_bits_are_refused() {
    fails("{9223372036854775807 + 1}");
    fails("{2 ** 64}");
    fails("{9223372036854775808}");
}

#[test]
fn real_numbers_print_as_in_python() {
    becomes("{10.0} {0.00001} {1e16} {123456.789} { -0.0}", "10.0 1e-05 1e+16 123456.789 -0.0");
}

#[test]
fn the_fewest_digits_that_read_back_are_printed() {
    becomes("{0.1 + 0.2} {1 / 3} {2 / 3.0}", "0.30000000000000004 0.3333333333333333 0.6666666666666666");
}

#[test]
fn round_gives_a_real_number_and_halves_go_to_the_even_digit() {
    becomes("{2.5|round} {3.5|round} {2.675|round(2)} {5|round}", "2.0 4.0 2.67 5");
}

#[test]
fn round_up_and_down_by_name() {
    becomes("{2.41|round(1, 'ceil')} {2.49|round(1, 'floor')}", "2.5 2.4");
}

#[test]
fn int_cuts_and_takes_texts() {
    becomes("{'12.5'|int} {'x'|int} {'x'|int(3)} { -5.9|int} {'ff'|int(base=16)}", "12 0 3 -5 255");
}

#[test]
fn float_takes_texts() {
    becomes("{'2.50'|float} {'x'|float} {'1e3'|float}", "2.5 0.0 1000.0");
}

#[test]
fn default_is_for_what_is_not_there() {
    becomes("{no|default(1)} {''|default(1)}|{''|default(1, true)} {none|default(2)}", "1 |1 None");
}

#[test]
fn what_is_not_there_prints_nothing() {
    becomes("[{no}]", "[]");
}

#[test]
fn attributes_of_what_is_not_there_are_errors() {
    fails("{no.x}");
    fails("{no[0]}");
    fails("{no + 1}");
    fails("{no < 1}");
}

#[test]
fn truth_values_print_as_words() {
    becomes("{true} {1 == 1} {none}", "True True None");
}

#[test]
fn truth_values_count_as_numbers() {
    becomes("{true + 1} {2.5 * false}", "2 0.0");
}

#[test]
fn a_text_has_no_order_with_a_number() {
    fails("{'5' < 6}");
    becomes("{'5' == 5}", "False");
}

#[test]
fn lists_are_ordered_by_elements() {
    becomes("{[1, 2] < [1, 3]} {[1] < [1, 0]} {(1, 'a') < (1, 'b')}", "True True True");
}

#[test]
fn whole_and_real_numbers_are_compared_exactly() {
    becomes("{9007199254740993 == 9007199254740992.0}", "False");
}

#[test]
fn comparisons_are_chained() {
    becomes("{1 < 2 < 3} {1 < 3 < 2} {3 > 2 == 2}", "True False True");
}

#[test]
fn in_looks_at_keys_elements_and_parts() {
    becomes("{'a' in {'a': 1}} {2 in [1, 2]} {'b' in 'abc'} {1 not in [2]}", "True True True True");
}

#[test]
fn in_a_text_only_texts_are_looked_for() {
    fails("{1 in '123'}");
}

#[test]
fn and_and_or_give_values() {
    becomes("{0 or 'a'} {1 and 'b'} {'' and no.x}|", "a b |");
}

#[test]
fn not_binds_weaker_than_comparison() {
    becomes("{not 1 == 2} {not 0 and 1}", "True 1");
}

#[test]
fn a_condition_is_looked_at_before_its_value() {
    becomes("{no.x if 0 else 'b'} {1 if 0}|", "b |");
}

#[test]
fn tilde_joins_texts() {
    becomes("{1 ~ 'a' ~ 2.0 ~ none}", "1a2.0None");
}

#[test]
fn plus_does_not_join_text_and_number() {
    fails("{'a' + 1}");
    becomes("{'a' + 'b'}", "ab");
}

#[test]
fn lists_are_added_and_repeated() {
    becomes("{[1] + [2]} {[0] * 3} {'-' * 3}", "[1, 2] [0, 0, 0] ---");
}

#[test]
fn elements_count_from_both_ends() {
    becomes("{[1, 2, 3][0]}{[1, 2, 3][-1]}{[1][5]}{'abc'[1]}", "13b");
}

#[test]
fn slices_clamp_their_bounds() {
    becomes("{[1, 2, 3][1:]} {'hello'[::-1]} {[1, 2][5:]} {[1, 2, 3][::2]}", "[2, 3] olleh [] [1, 3]");
}

#[test]
fn dicts_keep_the_order_of_their_keys() {
    becomes("{ {'b': 1, 'a': 2, 'b': 3} }", "{'b': 3, 'a': 2}");
}

#[test]
fn keys_are_equal_as_numbers() {
    becomes("{ {1: 'a', 1.0: 'b', true: 'c'} }", "{1: 'c'}");
}

#[test]
fn lists_cannot_be_keys() {
    fails("{ {[1]: 2} }");
}

#[test]
fn texts_are_quoted_in_lists() {
    becomes("{['it\\'s', 'a\"', '\\n']}", "[\"it's\", 'a\"', '\\n']");
}

#[test]
fn tuples_of_one_have_a_comma() {
    becomes("{(1,)} {(1)} {1, 2}", "(1,) 1 (1, 2)");
}

#[test]
fn variables_of_a_loop_are_gone_behind_it() {
    becomes("{% set x = 0 %}{% for i in [1] %}{% set x = 5 %}{% endfor %}{x}", "0");
}

#[test]
fn variables_of_a_condition_stay() {
    becomes("{% if 1 %}{% set x = 5 %}{% endif %}{x}", "5");
}

#[test]
fn each_turn_begins_with_the_variables_outside() {
    becomes("{% set x = 1 %}{% for i in [1, 2] %}{% set x = x + i %}{x} {% endfor %}", "2 3 ");
}

#[test]
fn namespaces_last_beyond_a_loop() {
    becomes("{% set n = namespace(x=1) %}{% for i in [1, 2] %}{% set n.x = n.x + i %}{% endfor %}{n.x}", "4");
}

#[test]
fn only_namespaces_have_members_that_are_set() {
    fails("{% set d = {} %}{% set d.x = 1 %}");
}

#[test]
fn several_names_take_the_parts_of_a_value() {
    becomes("{% set a, b = 1, 2 %}{% set a, b = b, a %}{a}{b}", "21");
    fails("{% set a, b = [1] %}");
}

#[test]
fn a_text_between_tags_is_a_value() {
    becomes("{% set t %}a{1 + 1}{% endset %}[{t}]", "[a2]");
}

#[test]
fn a_text_between_tags_goes_through_filters() {
    becomes("{% set t | upper | replace('B', 'x'~1) %}ab{1 + 1}{% endset %}[{t}]", "[Ax12]");
    becomes("{% for i in 'ab' %}{% set t|upper %}{% if 1 %}{i}{% endif %}{% endset %}{t}{% endfor %}", "AB");
    fails("{% set t | nonsense %}a{% endset %}");
}

#[test]
fn names_within_parentheses_take_the_parts_of_parts() {
    becomes("{% for a, (b, c) in [(1, (2, 3)), (4, (5, 6))] %}{a}{b}{c} {% endfor %}", "123 456 ");
    becomes("{% set (a, b), c = (1, 2), 3 %}{a}{b}{c}", "123");
    becomes("{% set ((a, b), c), d = ((1, 2), 3), 4 %}{a}{b}{c}{d}", "1234");
    becomes("{% set a, = [7] %}{a}{% set (b) = 8 %}{b}", "78");
    becomes("{% set n = namespace() %}{% set n.x, (b, n.y) = 1, (2, 3) %}{n.x}{b}{n.y}", "123");
    fails("{% for a, (b, c) in [(1, 2)] %}{% endfor %}");
}

#[test]
fn whole_numbers_of_all_64_bits_are_kept() {
    becomes(
        "{9223372036854775807} { -9223372036854775807} {[140737488355328, -140737488355329]}",
        "9223372036854775807 -9223372036854775807 [140737488355328, -140737488355329]",
    );
    becomes(
        "{% set a = 2 ** 62 %}{% for i in [1, 2] %}{a + i} {% endfor %}{a == 2 ** 62}",
        "4611686018427387905 4611686018427387906 True",
    );
}

#[test]
fn endless_repetition_ends_with_the_memory() {
    fails("{'ab' * 1000000000000}");
    fails("{[1] * 1000000000000}");
    fails("{'a'|center(1000000000000)}");
    fails("{'a'.zfill(4000000000)}");
    fails("{[1]|batch(1000000000000, 0)|list}");
    fails("{[1]|slice(1000000000000)|list}");
}

#[test]
fn loops_tell_where_they_are() {
    becomes(
        "{% for x in 'ab' %}{loop.index}{loop.revindex}{loop.first}{loop.last} {% endfor %}",
        "12TrueFalse 21FalseTrue ",
    );
}

#[test]
fn loops_take_turns() {
    becomes("{% for x in range(3) %}{loop.cycle('a', 'b')}{% endfor %}", "aba");
}

#[test]
fn else_of_a_loop_is_for_no_turns() {
    becomes("{% for x in [] %}{x}{% else %}none{% endfor %}", "none");
}

#[test]
fn loops_pass_over_elements() {
    becomes("{% for x in [1, 2, 3] if x != 2 %}{loop.index}{x} {% endfor %}", "11 23 ");
}

#[test]
fn loops_take_pairs() {
    becomes("{% for k, v in {'a': 1}.items() %}{k}={v}{% endfor %}", "a=1");
}

#[test]
fn a_list_that_grows_in_its_loop_is_gone_through() {
    becomes(
        "{% set l = [1] %}{% for x in l %}{x}{% if x < 3 %}{% set _ = l.append(x + 1) %}{% endif %}{% endfor %}",
        "123",
    );
}

#[test]
fn lists_are_changed_wherever_they_are_known() {
    becomes("{% set a = [1] %}{% set b = a %}{% set _ = b.append(2) %}{a}", "[1, 2]");
}

#[test]
fn results_of_map_are_gone_through_once() {
    becomes("{% set m = ['1', '2']|map('int') %}{m|list}{m|list}", "[1, 2][]");
}

#[test]
fn sort_keeps_the_order_of_equals() {
    becomes("{[(1, 'b'), (0, 'x'), (1, 'a')]|sort(attribute='0')}", "[(0, 'x'), (1, 'b'), (1, 'a')]");
}

#[test]
fn sort_of_mixed_types_is_an_error() {
    fails("{[1, 'a']|sort}");
}

#[test]
fn sort_does_not_mind_case() {
    becomes("{['b', 'A']|sort} {['b', 'A', 'a']|sort(case_sensitive=true)}", "['A', 'b'] ['A', 'a', 'b']");
}

#[test]
fn select_takes_tests() {
    becomes("{[1, 2, 3]|select('>', 1)|list} {[1, 2]|reject('odd')|list}", "[2, 3] [2]");
}

#[test]
fn percent_forms_round_on_all_digits() {
    becomes("{'%.2f' % 1.005} {'%.0f' % 2.5} {'%5.1f|' % 3.14}", "1.00 2   3.1|");
}

#[test]
fn percent_wants_as_many_values_as_forms() {
    fails("{'%s' % (1, 2)}");
    fails("{'%s %s' % 1}");
    becomes("{'%d%%' % 5}", "5%");
}

#[test]
fn braces_take_places_names_and_forms() {
    fails("{'{1}{0} {a:>3} {:.1f}'.format}");
    becomes("{'{}-{a:>3}-{:.1f}'.format(1, 2.25, a='x')}", "1-  x-2.2");
}

#[test]
fn texts_have_methods() {
    becomes("{'a,b'.split(',')} {'abc'.startswith('a')} {' x '.strip()}", "['a', 'b'] True x");
}

#[test]
fn a_dash_takes_blanks_away() {
    becomes("a \n{%- if 1 -%}\n b {%- endif %}", "ab");
    becomes("a {- 1 -} b", "a1b");
}

#[test]
fn comments_vanish() {
    becomes("a{# {{ %} #}b", "ab");
    fails("{# no end");
}

#[test]
fn one_end_of_line_at_the_end_goes() {
    becomes("a\n", "a");
    becomes("a\n\n", "a\n");
    becomes("a\r\nb", "a\nb");
}

#[test]
fn text_is_not_touched() {
    becomes("G1 X1 ; größe } %}", "G1 X1 ; größe } %}");
}

#[test]
fn numbers_may_have_another_base() {
    becomes("{0x1F} {0b101} {0o17} {1_000}", "31 5 15 1000");
    fails("{007}");
}

#[test]
fn actions_write_nothing() {
    becomes("[{action_respond_info('x')}]", "[]");
    fails("{action_raise_error('x')}");
}
