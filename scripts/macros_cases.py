"""Small templates for the tests of the crate `macros`, a few for each rule; Jinja2 gives the answers."""

CONTEXT = {
    "printer": {
        "lookup": {
            "toolhead": {
                "homed_axes": "xy", "position": {"tuple": [10.0, 20.5, 0.2, 0.0]}, "max_velocity": 300.0,
                "extruder": "extruder", "axis_maximum": {"tuple": [250.0, 210.0, 200.0]},
            },
            "extruder": {"temperature": 214.97, "target": 215.0, "can_extrude": True},
            "fan": {"speed": 0.5, "rpm": None},
            "gcode_macro STATE": {"mode": {"literal": "'fast'"}, "list": {"literal": "[1, 2.5, 'a']"},
                                  "dict": {"literal": "{'a': 1, 'b': {'c': 2}}"}, "items": 5},
            "bed_mesh": {"profiles": {"default": {"points": [[0.1, 0.2], [0.3, -0.1]]}}, "empty": []},
        }
    },
    "params": {"X": "10", "Y": "2.5", "NAME": "Part One", "EMPTY": ""},
    "rawparams": "X=10 Y=2.5 NAME=\"Part One\"",
    "speed": {"literal": "60"},
    "flow": {"literal": "0.95"},
    "tools": {"literal": "['T0', 'T1', 'T2']"},
    "table": {"literal": "{'b': 2, 'a': 1, 'c': [3, 4]}"},
    "pair": {"literal": "(1, 'one')"},
    "people": {"literal": "[{'n': 'Bea', 'a': 30}, {'n': 'al', 'a': 25}, {'n': 'Cy', 'a': 30}]"},
    "nothing": None,
    "word": "größe",
}


def outputs(*expressions):
    return ["{" + expression + "}" for expression in expressions]


TEXT = [
    "", "G28", "G28\n", "G28\n\n", "\n", "a\r\nb\rc\n", "G1 X{1}Y{2}", "{ 1 }", "{-1}", "a {-1} b", "a {- 1 -} b", "a {+ 1 } b",
    "a\n{# comment #}\nb", "a {#- x -#} b", "{# no end", "{#}", "{##}x", "a{# %} } {% #}b", "x {%- set a = 1 -%} y", "x {%+ set a = 1 +%} y",
    "{%set a=1%}{a}", "  {%- if true %} a {%- endif %}  b", "{", "}", "a } b", "{}", "{ }", "{%", "{% %}", "{% nonsense %}",
    "{'}'}", "{'%}'}", "{% set x = '%}' %}{x}", "{{}}", "{ {} }", "{ {'a': 1} }", "{ {'a': 1}.a }", "größe {word}", "{'ß'|upper}",
    "{'a' 'b'}", "{\"a\" 'b' ~ 'c'}", "{'\\n'}", "{'\\t\\x41\\u00e9\\101\\\\\\''}", "{'\\q'}", "{'\\x4'}", "{'a\nb'}", "{'unfinished}",
    "{1 2}", "{$}", "{a b}", "{(1}", "{1)}", "{[1}", "{a!b}", "{a;b}", "{% if 1 %}", "{% endif %}", "{% else %}", "{% for %}",
    "{% if 1 %}{% endfor %}", "{% set x %}", "{% set %}", "{% set 1 = 2 %}", "{% set true = 2 %}", "{% set x = %}", "{% set x == 1 %}",
    "{% for x in %}{% endfor %}", "{% for 1 in [1] %}{% endfor %}", "{% if %}{% endif %}", "{% if 1 %}{% else %}{% elif 1 %}{% endif %}",
    "a{% if 1: %}b{% else: %}c{% endif %}", "{% for x in [1]: %}{x}{% endfor %}", "{% set a = 1, %}{a}", "{1,}", "{1, 2}", "{()}", "{(1)}", "{(1,)}",
]

NUMBERS = outputs(
    "0", "007", "1_000", "0x1F", "0b101", "0o17", "0xg", "1.5", "1e3", "1E-2", "1.", ".5", "1.5.2", "1e", "5if 1", "9223372036854775807",
    "1e16", "123456789012345.6", "1e15", "1e-4", "0.00001", "1.0", "100.0", "0.1 + 0.2", "1/3", "2/3", "1e22", "1e23", "5e-324", "1.7976931348623157e308",
    "123456789.123456789", "0.1", "1e100", "-0.0", "0.5", "2.5e-7", "3.0e10", "4.35*100", "1.1*3",
    "7 // 2", "-7 // 2", "7 // -2", "-7 // -2", "7 % 3", "-7 % 3", "7 % -3", "7.5 % 2", "-7.5 % 2", "7.5 // 2", "-7.5 // 2", "7.5 % -2", "-0.0 % 3",
    "7 / 2", "6 / 2", "1 / 0", "1 // 0", "1 % 0", "1.0 / 0", "2 ** 10", "2 ** -1", "2 ** 3 ** 2", "-2 ** 2", "(-8) ** 2", "2 ** 0.5", "0 ** 0",
    "2.0 ** 3", "0 ** -1", "1 + 2 * 3", "(1 + 2) * 3", "10 - 2 - 3", "2 * 3 % 4", "1 + 1.0", "True + 1", "True * 2.5", "-True", "+5", "--5", "-+5", "- 5",
    "1 + none", "'a' + 1", "1 + 'a'", "'a' + 'b'", "[1] + [2]", "[1] + (2,)", "(1,) + (2,)", "'ab' * 3", "3 * 'ab'", "[1, 2] * 2", "'a' * -1",
    "'a' * 1.5", "[1] - [1]", "'5' * '5'", "missing + 1", "1 + missing", "-missing", "-'a'", "not missing", "10 ** 18", "3 - -3", "1 - 1",
    "1000000 * 1000000", "5 * 2.0", "300.0 * 60", "60 * 0.95", "1e5 * 1e5", "1 ~ 2 + 3", "1 ~ (2 + 3)", "'a' ~ 1.50 ~ none ~ true ~ missing",
)

COMPARISONS = outputs(
    "1 < 2", "2 < 1", "1 == 1.0", "1 == True", "'a' == 'a'", "'a' == 1", "'1' == 1", "none == none", "none == 0", "[1, 2] == [1, 2]", "[1] == (1,)",
    "{'a': 1, 'b': 2} == {'b': 2, 'a': 1}", "'a' < 'b'", "'B' < 'a'", "'a' < 1", "1 < 'a'", "params.X > 5", "params.X|int > 5", "none < 1", "[1, 2] < [1, 3]",
    "[1] < [1, 2]", "(1, 'a') < (1, 'b')", "[1] < ['a']", "1 < 2 < 3", "1 < 3 < 2", "3 > 2 >= 2 != 1", "1 == 1 in [1]", "1 != 2", "not 1 == 2", "1 <= 1.0", "2 >= 2.5",
    "9007199254740993 == 9007199254740992.0", "9007199254740993 > 9007199254740992.0", "missing == missing", "missing == none", "missing < 1", "missing != 1",
    "1 in [1, 2]", "3 in [1, 2]", "3 not in [1, 2]", "'a' in 'cat'", "'' in 'cat'", "1 in 'cat'", "'a' in {'a': 1}", "1 in {'a': 1}", "'X' in params", "'Z' in params",
    "'toolhead' in printer", "'nothing' in printer", "'gcode_macro STATE' in printer", "1 in missing", "1 in 5", "1 in none", "'x' in printer.toolhead.homed_axes",
    "'z' not in printer.toolhead.homed_axes", "2 in range(3)", "[1] in [[1]]", "'a' in ('a', 'b')", "not 'a' in 'b'", "1 and 2", "0 and 2", "0 or 2", "1 or 2", "'' or 'a'",
    "not 0", "not ''", "not []", "not none", "1 and 0 or 3", "0 or 0 and 1", "not 1 and 0", "not (1 and 0)", "missing and missing.x", "missing or 5", "false or none",
    "1 if 2 else 3", "1 if 0 else 3", "1 if 0", "(1 if 0) is defined", "missing.x if 0 else 3", "1 if 0 else 2 if 0 else 3", "1 if 1 if 0 else 2 else 3", "'a' if 1 else 'b' ~ 'c'",
    "[1 if 0 else 2, 3]", "1 < 2 and 2 < 3", "1 == 1 and 'a' or 'b'", "(1 < 2) == true", "not missing is defined", "-1 < 0",
)

LOOKUPS = outputs(
    "speed", "flow", "tools", "table", "pair", "nothing", "missing", "missing.x", "missing['x']", "missing[0]", "missing()", "speed.x", "speed.x.y", "speed[0]", "nothing.x",
    "printer.toolhead.homed_axes", "printer['toolhead'].max_velocity", "printer[' toolhead '].extruder", "printer[printer.toolhead.extruder].target", "printer.missing", "printer.missing.x",
    "printer.toolhead.position", "printer.toolhead.position.x", "printer.toolhead.position.z", "printer.toolhead.position[1]", "printer.toolhead.position[-1]", "printer.toolhead.position[9]",
    "printer.toolhead.position.q", "printer['gcode_macro STATE'].mode", "printer['gcode_macro state'].mode", "printer['gcode_macro STATE'].list[1]", "printer['gcode_macro STATE'].dict.b.c",
    "printer['gcode_macro STATE']['items']", "printer.bed_mesh.profiles.default.points[1][0]", "printer.bed_mesh.profiles['default']['points'][0]", "printer.bed_mesh.empty", "printer.fan",
    "printer.extruder.temperature|int", "printer.fan.rpm", "printer.fan.rpm is none", "printer.extruder.can_extrude", "printer.extruder|length", "printer.extruder.items()|list",
    "printer.extruder.keys()|list", "printer.extruder.values()|list|length", "params.X", "params.x", "params['X']", "params", "params|length", "params.NAME", "params.EMPTY", "params.Z|default(5)",
    "rawparams", "tools[0]", "tools[-1]", "tools[3]", "tools['a']", "tools[1.0]", "tools[True]", "tools.0", "tools.1", "tools.5", "table.a", "table['b']", "table.c[0]", "table['z']", "table.z.y", "table[0]",
    "table[[1]]", "pair[1]", "pair.0", "'abc'[0]", "'abc'[-1]", "'abc'[5]", "'größe'[2]", "'abc'.x", "word|length", "word[2:4]", "tools[1:]", "tools[:1]", "tools[:-1]", "tools[::-1]", "tools[::2]",
    "tools[5:]", "tools[-2:]", "tools[2:0:-1]", "tools[0:3:0]", "tools['a':]", "pair[:1]", "'hello'[1:3]", "'hello'[::-1]", "'hello'[-3:]", "speed[1:]", "missing[1:]", "range(5)[1:3]",
    "range(10)[2]", "range(10)[-1]", "table['c'][1]", "{'a': {'b': 1}}.a.b", "[[1, 2], [3, 4]][1][0]", "[1, 2, 3].1", "(1, 2).0", "{1: 'a', 'b': 2, none: 3, true: 4}", "{1: 'a', 1.0: 'b'}", "{[1]: 2}",
    "[1, 'a', none, 2.0, true, [1], (1,), {'k': 'v'}]", "['it\\'s', 'a\"b', '\\n', 'ä', '\\x07', 'a\\'\"b']", "loop", "loop.index", "printer.toolhead.position|length", "tools.missing()", "speed()", "none()",
)

FILTERS = outputs(
    "[printer.fan, 1]", "{'f': printer.fan}", "[printer.toolhead.position]", "false|map('int')|list", "none|select|list", "[none, none]|sort", "[none, 1]|sort", "missing|last", "[1, 2]|truncate(3)", "'%d' is odd", "2.5 ** 2",
    "printer.toolhead.position in {'k': 1}", "printer.fan in {'k': 1}", "range(4).count(1)", "{'k': 1, 1: 'a', none: 2}|pprint", "1 if 1 else 2|list.upper()", "0|d(1)|list.upper()",
    "5|abs", "-5|abs", "-2.5|abs", "'a'|abs", "missing|abs", "missing|default(1)", "missing|default", "''|default(1)", "''|default(1, true)", "none|default(1)", "none|d(1, boolean=true)", "missing.x|default(1)",
    "0|default(5, true)", "missing|default(none)", "speed|default(1)", "'5'|int", "'5.9'|int", "'-5.9'|int", "'abc'|int", "'abc'|int(7)", "'abc'|int(default=8)", "5.9|int", "-5.9|int", "true|int", "none|int", "missing|int", "[]|int",
    "'1e3'|int", "' 12 '|int", "'1_000'|int", "'0x1A'|int(0, 16)", "'ff'|int(base=16)", "'1A'|int(0, 16)", "'inf'|int", "'nan'|int", "'--5'|int", "'+5'|int", "'5'|float", "'abc'|float", "'abc'|float(1.5)", "5|float", "none|float",
    "missing|float", "'1e3'|float", "' 2.50 '|float", "'inf'|float", "true|float", "'.5'|float", "'5.'|float", "'1_0.5'|float", "2.5|round", "3.5|round", "-2.5|round", "2.675|round(2)", "2.345|round(2)", "1.005|round(2)", "5|round", "1234|round(-2)",
    "1250|round(-2)", "1350|round(-2)", "1234.5|round(-2)", "0.5|round", "1.5|round", "2.4|round|int", "2.449|round(1, 'floor')", "2.41|round(1, 'ceil')", "2.5|round(0, 'x')", "'a'|round", "2.5|round(method='ceil')", "0.1|round(20)", "123.456|round(1)",
    "1e300|round(2)", "'AbC'|lower", "'AbC'|upper", "5|upper", "none|lower", "'hello wORLD'|capitalize", "'hello big-world (x)'|title", "'  a b '|trim", "'xxaxx'|trim('x')", "' a '|trim ~ '|'", "'a,b,a'|replace('a', 'x')", "'a,b,a'|replace('a', 'x', 1)",
    "'abc'|replace('', '-')", "5|replace(5, 6)", "'abc'|length", "[1, 2]|length", "table|count", "5|length", "none|length", "missing|length", "range(5)|length", "[3, 1, 2]|sort", "[3, 1, 2]|sort(reverse=true)", "['b', 'A', 'c']|sort",
    "['b', 'A', 'c']|sort(case_sensitive=true)", "[1, 'a']|sort", "people|sort(attribute='a')", "people|sort(attribute='a,n')", "people|map(attribute='n')|list", "people|sort(attribute='n')|map(attribute='n')|join(' ')", "table|dictsort", "table|dictsort(by='value')",
    "{'a': 2, 'b': 1}|dictsort(false, 'value')", "{'b': 2, 'A': 1}|dictsort(true)", "[1, 2, 3]|sum", "[1.5, 2]|sum", "people|sum(attribute='a')", "[[1], [2]]|sum(start=[])", "['a']|sum", "[]|sum", "[1, 2]|sum(start=10)", "[3, 1]|min", "[3, 1]|max", "['b', 'A']|min", "[]|max",
    "[]|max is defined", "'hello'|max", "[1, 'a']|max", "[1, 2.5]|max", "people|max(attribute='a')", "(5, 2)|min", "[1, 2, 3]|join", "[1, 2, 3]|join(', ')", "people|join('-', attribute='n')", "'abc'|join('.')", "table|join", "5|join", "missing|join('x')", "[1, none, 2.0]|join(' ')",
    "[1, 2]|first", "[1, 2]|last", "[]|first", "'abc'|first", "'abc'|last", "table|first", "table|list", "'abc'|list", "5|list", "missing|list", "range(3)|list", "range(3)|last", "[1, 2]|reverse|list", "'abc'|reverse", "range(3)|reverse|list", "['1', '2']|map('int')|list",
    "['1', '2']|map('int')|sum", "['a', 'b']|map('upper')|join", "[1, 2]|map('string')|list", "[1.55, 2.44]|map('round', 1)|list", "['x']|map('int', 5)|list", "['x']|map('int', default=6)|list", "[1]|map('nonsense')|list", "people|map(attribute='z', default=0)|list",
    "[{'a': {'b': 1}}]|map(attribute='a.b')|list", "[[1, 2], [3, 4]]|map(attribute=1)|list", "[[1, 2], [3, 4]]|map(attribute='0')|list", "[[3, 1], [2]]|map('max')|list", "[0, 1, 2]|select|list", "[1, 2, 3]|select('odd')|list", "[1, 2, 3]|reject('odd')|list", "[1, 2, 3]|select('>', 1)|list",
    "[1, 2, 3]|select('equalto', 2)|list", "['a', 'b']|reject('in', ['a'])|list", "people|selectattr('a', 'equalto', 30)|map(attribute='n')|list", "people|rejectattr('a', '==', 30)|map(attribute='n')|list", "people|selectattr('z')|list", "people|selectattr('n', 'defined')|list|length",
    "[1, 2]|select('nonsense')|list", "[1, 1, 2]|unique|list", "['a', 'A', 'b']|unique|list", "['a', 'A']|unique(true)|list", "[1, 2, 3, 4, 5]|batch(2)|list", "[1, 2, 3]|batch(2, 0)|list", "[1, 2, 3, 4, 5]|slice(2)|list", "[1, 2, 3]|slice(2, 'x')|list", "'a'|string ~ 5|string",
    "none|string", "2.0|string", "[1, 'a']|string", "'%s and %s'|format(1, 2)", "'%(a)s'|format(a=5)", "'%s'|format('x', 'y')", "'a'|center(5) ~ '|'", "'ab'|center(5) ~ '|'", "'hello world foo bar'|truncate(11)", "'hello world foo bar'|truncate(11, true)", "'short'|truncate(3)",
    "'a b c'|wordcount", "'a\nb'|indent", "'a\nb'|indent(2, true)", "'a\n\nb'|indent(2)", "table|items|list", "5|items|list", "table|attr('b')", "[1, 2]|random", "[]|random", "table|pprint", "[1, 'a']|pprint", "'x'|pprint", "range(40)|list|pprint",
    "{'zebra': 'a long value that takes room', 'apple': 'another long value of this kind', 'b': [1, 2, 3]}|pprint", "-5.5|abs|int", "'5'|int + 1", "1|nonsense", "5|int|float|string|length", "[1, 2]|map('int')|first", "missing|upper", "missing|string", "missing|sort", "missing|map('int')|list",
    "2|float / 3|float", "5.0|int ~ ''", "10|default(2) * 3", "[1,2,3]|length > 2 and 'yes'", "'a'|default('b') ~ 'c'", "(1 + 2)|string + 'x'", "1 + 2|string|int", "true|string|lower", "[1, 2] | map('float') | join('/')", "'abc'|first|upper",
)

TESTS = outputs(
    "missing is defined", "speed is defined", "missing is undefined", "missing is not defined", "missing.x is defined", "table.a is defined", "table.z is defined", "printer.toolhead.x is defined", "none is none", "0 is none", "5 is not none", "5 is number", "5.0 is number", "true is number",
    "'a' is number", "5 is integer", "true is integer", "5.0 is integer", "5.0 is float", "5 is float", "'a' is string", "5 is string", "true is boolean", "1 is boolean", "true is true", "1 is true", "false is false", "0 is false", "{} is mapping", "[] is mapping", "params is mapping",
    "printer.toolhead is mapping", "[] is sequence", "'a' is sequence", "{} is sequence", "5 is sequence", "(1,) is sequence", "missing is sequence", "[] is iterable", "5 is iterable", "'' is iterable", "missing is iterable", "5 is odd", "4 is odd", "4 is even", "4.0 is even", "'a' is odd", "9 is divisibleby 3",
    "9 is divisibleby(4)", "9 is divisibleby 0", "'abc' is lower", "'aBc' is lower", "'ABC' is upper", "'123' is lower", "1 is in [1, 2]", "3 is in([1, 2])", "3 is not in [1, 2]", "'a' is in 'abc'", "5 is eq 5", "5 is ne 5", "5 is gt 4", "5 is ge 5", "5 is lt 4", "5 is le 5", "5 is equalto 5.0", "5 is sameas 5",
    "none is sameas none", "5 is lessthan 6", "'a' is lessthan 5", "5 is nonsense", "5 is defined is none", "5 is not odd", "not 5 is odd", "5 is odd and 4 is even", "5 is odd or missing.x", "'int' is filter", "'nonsense' is filter", "'odd' is test", "range is callable", "5 is callable", "'a' is escaped",
    "missing is none", "1 + 1 is odd", "(1 + 1) is odd", "-1 is odd", "5 is number if 1 else 2", "(5 is number) if 1 else 2",
)

METHODS = outputs(
    "'a,b,c'.split(',')", "'a b  c'.split()", "' a b '.split(' ')", "'a,b,c'.split(',', 1)", "'a b c'.split(none, 1)", "'a,b,c'.split(',', maxsplit=1)", "'a,b,c'.rsplit(',', 1)", "''.split()", "''.split(',')", "'a'.split('')", "'a\\nb\\r\\nc'.splitlines()", "'abc'.startswith('a')", "'abc'.endswith('c')",
    "'abc'.startswith(('x', 'a'))", "'abc'.startswith(1)", "'AbC'.lower()", "'AbC'.upper()", "'abC dE'.capitalize()", "'abC dE f2g'.title()", "'aBc'.swapcase()", "' a '.strip() ~ '|'", "'xax'.strip('x')", "'xax'.lstrip('x')", "'xax'.rstrip('x')", "'a-b'.replace('-', '+')", "'aaa'.replace('a', 'b', 2)", "','.join(['a', 'b'])",
    "','.join([1])", "', '.join(tools)", "'abc'.find('c')", "'abc'.find('z')", "'abcabc'.rfind('b')", "'abc'.index('z')", "'banana'.count('a')", "'123'.isdigit()", "'12a'.isdigit()", "''.isdigit()", "'abc'.isalpha()", "'ab1'.isalnum()", "' '.isspace()", "'ABC'.isupper()", "'abc'.islower()", "'42'.zfill(5)", "'-42'.zfill(5)",
    "'a'.ljust(3) ~ '|'", "'a'.rjust(3, '*')", "'a'.center(4, '-')", "'prefix_x'.removeprefix('prefix_')", "'x.cfg'.removesuffix('.cfg')", "'a=b=c'.partition('=')", "'a=b=c'.rpartition('=')", "'abc'.nonsense()", "[1, 2].append(3)", "tools.index('T1')", "tools.count('T1')", "tools.index('x')", "[1, 2].copy()",
    "table.get('a')", "table.get('z')", "table.get('z', 5)", "table.keys()", "table.values()", "table.items()", "table.keys()|list", "table.items()|list", "table.keys()[0]", "table.items()|length", "dict(a=1, b='x')", "dict([('a', 1)])", "dict({'a': 1}, b=2)", "dict(1)", "table.copy()", "params.get('X', 0)", "params.items()|list",
    "'{}'.format(1)", "'{} {}'.format(1, 'a')", "'{1} {0}'.format(1, 2)", "'{a}'.format(a=5)", "'{:.2f}'.format(3.14159)", "'{:5d}|'.format(42)", "'{:<5}|{:>5}|{:^5}'.format('a', 'b', 'c')", "'{:05.1f}'.format(3.14159)", "'{:+d}'.format(5)", "'{:x} {:X} {:o} {:b}'.format(255, 255, 8, 5)", "'{:#x}'.format(255)", "'{:,}'.format(1234567)",
    "'{:.3e}'.format(12345.678)", "'{:g}'.format(0.00001234)", "'{:g}'.format(1234567.0)", "'{:.3g}'.format(1234.5)", "'{:%}'.format(0.25)", "'{:.1%}'.format(0.256)", "'{!r}'.format('a')", "'{!s}'.format(1.0)", "'{{}}'.format()", "'{}'.format()", "'{'.format()", "'}'.format()", "'{:d}'.format(1.5)", "'{:d}'.format('a')",
    "'{:s}'.format(1)", "'{:*^9}'.format('mid')", "'{:.3}'.format('abcdef')", "'{:.3}'.format(3.14159)", "'{:10.3f}|'.format(3.14159)", "'{:<10.2f}|'.format(2.5)", "'{0:.{1}f}'.format(3.14159, 2)", "'{:5}|'.format(true)", "'{}'.format(true)", "'{}'.format(none)", "'{}'.format([1, 'a'])", "'{}'.format(missing)", "'{:_}'.format(1234567)", "'{: d}'.format(5)",
    "'{:,.2f}'.format(1234567.891)", "'{:.0f}'.format(2.5)", "'{:.0f}'.format(0.5)", "'{:e}'.format(0)", "'{:f}'.format(5)", "'%d' % 5", "'%d' % 5.9", "'%d' % '5'", "'%i' % 7", "'%s' % 'a'", "'%s' % none", "'%s %s' % ('a', 1)", "'%s' % ('a', 'b')", "'%s %s' % 'a'", "'%.2f' % 3.14159", "'%5.1f|' % 3.14159", "'%-8s|' % 'ab'", "'%8s|' % 'ab'",
    "'%05d' % 42", "'%+d' % 5", "'%x' % 255", "'%X' % 255", "'%#x' % 255", "'%o' % 8", "'%e' % 12345.678", "'%g' % 0.00001", "'%g' % 1234567.0", "'%G' % 1e-10", "'%c' % 65", "'%c' % 'z'", "'%r' % 'a'", "'%%' % ()", "'100%%' % ()", "'%' % 5", "'%z' % 5", "'%(a)s %(b)d' % {'a': 1, 'b': 2}", "'%(z)s' % {'a': 1}", "'%s' % [1, 2]", "'%s' % (1,)", "'%s' % {'a': 1}",
    "'%s' % missing", "'%d' % missing", "'%.1f' % none", "'%*d' % (5, 42)", "'%.3s' % 'abcdef'", "'abc' % ()", "'abc' % 5", "'%.0f' % 2.5", "'%.0f' % 3.5", "'%.1f' % 0.25", "'%.2f' % 1.005", "'%.3f' % 2.0005", "'%f' % 1e20", "'%.10f' % 0.1", "'%.20f' % 0.1", "'%d' % true", "'% d' % 5", "'%5s%%' % 50", "'%s' % printer.toolhead.position", "'%s-%s' % pair",
    "'%.2f' % 1e-5", "'%g' % 100000.0", "'%g' % 1000000.0", "'%g' % 0", "'%e' % 0.0", "'%.15g' % 0.1", "'%.17g' % 0.1", "'%08.3f' % -3.14159",
    "range(3)", "range(1, 5)|list", "range(0, 10, 3)|list", "range(5, 0, -2)|list", "range(5, 0)|list", "range(0)|list", "range(2.5)", "range('3')", "range()", "range(1, 2, 0)", "range(1, 5, 2)", "range(3) == range(0, 3)", "namespace(a=1).a", "namespace(a=1)", "namespace().x", "namespace({'a': 2}).a", "5.0.is_integer()", "2.5.is_integer()",
    "action_respond_info('hello')", "action_respond_info(5)", "action_raise_error('stop')", "action_emergency_stop()", "action_call_remote_method('x', a=1)", "action_respond_info()", "range(*[1, 4])|list", "dict(**table)", "'{}-{}'.format(*[1, 2])", "dict(a=1, **{'b': 2})", "range(start=1)",
)

STATEMENTS = [
    "{% set a = 1 %}{a}", "{% set a = 1 %}{% set a = a + 1 %}{a}", "{% set a, b = 1, 2 %}{a}{b}", "{% set a, b = [1, 2] %}{b}{a}", "{% set a, b = 1 %}", "{% set a, b = [1, 2, 3] %}", "{% set (a, b) = (1, 2) %}{a}{b}", "{% set a, b = 'xy' %}{a}-{b}", "{% set a = 1 %}{% set b = 2 %}{% set a, b = b, a %}{a}{b}",
    "{% set a %}x{1 + 1}y{% endset %}[{a}]", "{% set a %}{% set b = 5 %}{b}{% endset %}{a}{b}", "{% if 1 %}a{% endif %}", "{% if 0 %}a{% else %}b{% endif %}", "{% if 0 %}a{% elif 1 %}b{% else %}c{% endif %}", "{% if 0 %}a{% elif 0 %}b{% elif 1 %}c{% elif 1 %}d{% endif %}", "{% if '' %}a{% elif none %}b{% else %}c{% endif %}",
    "{% if missing %}a{% else %}b{% endif %}", "{% if missing.x %}a{% endif %}", "{% if 1 %}{% if 0 %}a{% else %}b{% endif %}{% endif %}", "{% if 1 %}{% set x = 5 %}{% endif %}{x}", "{% if 0 %}{% set x = 5 %}{% endif %}{x}", "{% if 0 %}{% set speed = 5 %}{% endif %}{speed}", "{% if 0 %}{missing|nonsense}{% endif %}", "{% if 1 %}{5|nonsense}{% endif %}",
    "{5|nonsense if 0 else 1}", "{% if 0 %}{% for x in [1] %}{x|nonsense}{% endfor %}{% endif %}", "{% if 0 %}{5 is nonsense}{% endif %}", "{% for x in [1, 2, 3] %}{x}{% endfor %}", "{% for x in [] %}{x}{% else %}none{% endfor %}", "{% for x in [1] %}{x}{% else %}none{% endfor %}", "{% for x in range(3) %}{x},{% endfor %}", "{% for x in 'abc' %}{x}-{% endfor %}",
    "{% for k in table %}{k}{% endfor %}", "{% for k, v in table.items() %}{k}={v};{% endfor %}", "{% for k, v in table|dictsort %}{k}={v};{% endfor %}", "{% for k in params %}{k} {% endfor %}", "{% for k, v in params.items() %}{k}={v} {% endfor %}", "{% for x in 5 %}{% endfor %}", "{% for x in none %}{% endfor %}", "{% for x in missing %}{x}{% else %}e{% endfor %}",
    "{% for x in printer %}{x} {% endfor %}", "{% for x in printer.toolhead.position %}{x} {% endfor %}", "{% for x in printer.extruder %}{x} {% endfor %}", "{% for k, v in printer.extruder.items() %}{k}={v} {% endfor %}", "{% for a, b in [(1, 2), (3, 4)] %}{a}{b}{% endfor %}", "{% for a, b in [1, 2] %}{a}{% endfor %}", "{% for a in 1, 2 %}{a}{% endfor %}",
    "{% for x in [1, 2, 3, 4] if x is even %}{x}{% endfor %}", "{% for x in [1, 2, 3] if x > 5 %}{x}{% else %}e{% endfor %}", "{% for x in [1, 2, 3, 4] if x > 1 %}{loop.index}:{x} {% endfor %}", "{% set n = namespace(done=false) %}{% for x in range(5) if not n.done %}{x}{% if x == 2 %}{% set n.done = true %}{% endif %}{% endfor %}",
    "{% for x in 'abc' %}{loop.index}{loop.index0}{loop.revindex}{loop.revindex0}{loop.first}{loop.last}{loop.length} {% endfor %}", "{% for x in [1, 2, 3] %}{loop.cycle('a', 'b')}{% endfor %}", "{% for x in [1, 2] %}{loop.previtem}|{loop.nextitem};{% endfor %}", "{% for x in [1, 2] %}{loop.depth}{loop.depth0}{loop.x}{% endfor %}",
    "{% for x in [1, 2] %}{% for y in [1, 2] %}{loop.index}{% endfor %}{loop.index} {% endfor %}", "{% for x in [1, 2] %}{% set o = loop %}{% for y in [1] %}{o.index}{% endfor %}{% endfor %}", "{% for x in [1] %}{% set loop = 1 %}{% endfor %}", "{% set x = 0 %}{% for y in [1, 2] %}{% set x = x + y %}{x} {% endfor %}{x}", "{% for y in [1, 2] %}{% set x = y %}{% endfor %}{x}",
    "{% for y in [1, 2] %}{z}{% set z = y %}{% endfor %}", "{% for y in [1, 2] %}{% if y == 1 %}{% set z = 5 %}{% endif %}{z} {% endfor %}", "{% for y in [1, 2] %}{speed}{% set speed = speed + 1 %}{speed} {% endfor %}{speed}", "{% set n = namespace(x=0) %}{% for y in [1, 2] %}{% set n.x = n.x + y %}{% endfor %}{n.x}", "{% set n = namespace() %}{% set n.a = [1] %}{n.a}{n.b}",
    "{% set n = namespace(s='') %}{% for y in range(5) %}{% set n.s = n.s ~ y ~ ',' %}{% endfor %}{n.s}", "{% set d = {} %}{% set d.x = 1 %}", "{% set missing.x = 1 %}", "{% set n = namespace(a=1) %}{% set n.a, b = 2, 3 %}{n.a}{b}", "{% for n.x in [1] %}{% endfor %}", "{% set l = [] %}{% for y in range(3) %}{% set _ = l.append(y * 2) %}{% endfor %}{l}",
    "{% set l = [] %}{% for y in 'abc' %}{% set _ = l.append(y ~ '!') %}{% endfor %}{l|join(' ')}", "{% set d = {} %}{% for y in 'ab' %}{% set _ = d.update({y: y ~ y}) %}{% endfor %}{d}", "{% set d = {'a': 1} %}{% set _ = d.__setitem__('b', 2) %}{% set _ = d.__setitem__('a', 3) %}{d}", "{% set l = [1, 2, 3] %}{% set x = l.pop() %}{x}{l}{l.pop(0)}{l}", "{% set l = [] %}{l.pop()}",
    "{% set d = {'a': 1} %}{d.pop('a')}{d}{d.pop('z', 5)}{d.pop('z')}", "{% set l = [3, 1, 2] %}{% set _ = l.insert(1, 'x') %}{l}{% set _ = l.extend([7, 8]) %}{l}{% set _ = l.remove(1) %}{l}{% set _ = l.reverse() %}{l}", "{% set a = [1] %}{% set b = a %}{% set _ = b.append(2) %}{a}", "{% set a = [1] %}{% set b = a + [2] %}{% set _ = b.append(3) %}{a}{b}",
    "{% set l = [1, 2] %}{% for x in l %}{x}{% if x < 5 %}{% set _ = l.append(x + 2) %}{% endif %}{% endfor %}", "{% set m = [1, 2]|map('string') %}{m|list}{m|list}", "{% set m = [1]|map('string') %}{m|length}", "{% set x = params %}{% set _ = x.update({'Q': 5}) %}{params.Q}{params|length}", "{% set t = printer['gcode_macro STATE'] %}{% set _ = t.dict.update({'z': 9}) %}{t.dict.z}{printer['gcode_macro STATE'].dict}",
    "{% set _ = tools.append('T3') %}{tools}", "{% set a = 'x' %}{% for i in range(3) %}{% set a = a ~ i %}{a} {% endfor %}{a}", "{% set a = 'abc' %}{% set b = a ~ 'd' %}{% set c = b ~ 'e' %}{a}{b}{c}", "{% for i in range(3) %}{% set s = 'n' ~ i %}{% set l = [s, i] %}{l}{% endfor %}", "{% for i in range(2) %}{% for j in range(2) %}{% set k = i * 2 + j %}{k}{% endfor %}{k}{% endfor %}",
    "{% set x = {'a': [1, 2], 'b': {'c': 'd'}} %}{x.a[1]}{x.b.c}{x['b']['c']}", "{% set big = range(1000)|list %}{big|length}{big[999]}", "{% do x.append(1) %}", 
    "{% set a = 1 if 0 else 'b' %}{a}", "{% set a = 1 if 0 %}{a}{a is defined}", "{% set a = [x for x in y] %}", "G1 X{params.X|default(5)|float + 1} F{(speed * 60)|int}", "{% if params.X is defined and params.X|int > 5 %}M117 {params.NAME}{% endif %}", "{% if 'xyz' != printer.toolhead.homed_axes %}G28{% endif %}", "{% set x = params.X|default(0)|float %}{% set y = x / 3 %}G1 X{y|round(3)} Y{'%.3f' % y}",
    "{% for i in range(3) %}\nG1 X{i * 10}\n{% endfor %}\nM400", "{% set x = 5 %}{% if x > 3 %}\n  G1 X{x}\n{% else %}\n  G1 X0\n{% endif %}", "M117 \"{params.NAME}\" {'%d%%' % (0.5 * 100)}", "{% set tool = 'T%d' % 1 %}{tool in tools}{tools.index(tool)}", "{% set v = printer.toolhead.axis_maximum.x / 2 %}G1 X{v}", "{action_respond_info('a: %s' % params)}", "{% set _ = action_respond_info('x') %}{_}|",
    "{% if 0 %}{action_raise_error('no')}{% endif %}yes", "{% for x in range(3) %}{action_respond_info(x)}{% endfor %}", "{% set x = 5 %}{% set y %}{% for i in range(x) %}{i}{% endfor %}{% endset %}{y|length}", "{% for x in [1,2] %}a{% if loop.last %}z{% else %},{% endif %}{% endfor %}", "{% for i in range(2) %}{% for j in [] %}x{% else %}{% set q = i %}{q}{% endfor %}{q}{% endfor %}",
]

TEMPLATES = TEXT + NUMBERS + COMPARISONS + LOOKUPS + FILTERS + TESTS + METHODS + STATEMENTS

LITERALS = [
    "1", "-1", "+1", "1.5", "-.5", "5.", "1e3", "0x1F", "1_000", "True", "False", "None", "true", "none", "'a'", "\"it's\"", "'a' 'b'", "[1, 2]", "[1, 2,]", "[]", "()", "(1)", "(1,)", "1, 2", "1,", "(1, (2, 3))",
    "{'a': 1}", "{}", "{'a': [1, {'b': None}]}", "{'a': 1, 'a': 2}", "{1: 2}", "[1", "1]", "", "abc", "1 2", "'a", "--1", "-'a'", "not True", "1 + 1", "f()", "[1, [2, [3]]]", "'\\n\\t\\''", "'ä€'", "1e400x", "1.0", "100000000000000000.0", "1e-7",
    "[-1, -2.5]", " 5", "{'x': -1.5, 'y': (1, 2)}", "\"a\" \"b\"", "007", "0", "-0", "-0.0", "{'name': 'PLA', 'temp': 215, 'fan': True}", "'{}'", "[{'a': 1}, {'b': 2}]",
]
