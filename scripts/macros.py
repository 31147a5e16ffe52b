"""Compares Velvet's macros with Jinja2, which Klipper uses.

    macros.py corpus DESK FOLDER OUT   every template of the .cfg files in FOLDER, on made values
    macros.py table DESK FILE          writes the answers of Jinja2 into FILE, for the tests of the crate
    macros.py random DESK COUNT SEED   so many templates made at random

DESK is the program of macros/examples/desk.rs. Jinja2 is installed from PyPI into target/macros.
"""

import ast
import configparser
import copy
import json
import os
import re
import subprocess
import sys
import venv
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
HOME = ROOT / "target" / "macros"
JINJA = "jinja2==3.1.6"


def enter_environment():
    """Starts the script anew where Jinja2 is installed."""
    python = HOME / "bin" / "python"
    if Path(sys.prefix).resolve() == HOME.resolve():
        return
    if not (HOME / "installed").exists():
        venv.create(HOME, with_pip=True)
        subprocess.run([python, "-m", "pip", "install", "-q", "--disable-pip-version-check", JINJA], check=True)
        (HOME / "installed").touch()
    os.execv(python, [python, *sys.argv])


enter_environment()
import jinja2  # noqa: E402
import random  # noqa: E402

sys.path.insert(0, str(Path(__file__).resolve().parent))
from macros_status import statuses  # noqa: E402

random.choice = lambda sequence: sequence[0]
ENVIRONMENT = jinja2.Environment("{%", "%}", "{", "}")


class Raised(Exception):
    """A macro's own error."""


class Coord(tuple):
    """A position as Klipper has it: a tuple whose first parts have names."""

    def __getattr__(self, name):
        if name in ("x", "y", "z", "e") and "xyze".index(name) < len(self):
            return self["xyze".index(name)]
        raise AttributeError(name)


class Lookup:
    """Klipper's `printer`: members by name and nothing else."""

    def __init__(self, members):
        self.members = members

    def __getitem__(self, name):
        return self.members[str(name).strip()]

    def __contains__(self, name):
        return str(name).strip() in self.members

    def __iter__(self):
        return iter(self.members)


def to_python(value):
    """The value that the desk program makes of a piece of JSON."""
    if isinstance(value, list):
        return [to_python(part) for part in value]
    if not isinstance(value, dict):
        return value
    key = next(iter(value), None)
    if key == "literal":
        return ast.literal_eval(value["literal"])
    if key == "tuple":
        return Coord(to_python(part) for part in value["tuple"])
    if key == "lookup":
        return Lookup({name: to_python(part) for name, part in sorted(value["lookup"].items())})
    return {name: to_python(part) for name, part in sorted(value.items())}


def render_jinja(template, context):
    """What Jinja2 makes of a template: text or error, and what it asked the machine to do."""
    said = []

    def raise_error(msg):
        said.append(["RaiseError", str(msg)])
        raise Raised(msg)

    def say(kind, default=None):
        def action(msg=default):
            said.append([kind, str(msg)])
            return ""

        return action

    def remote(method, **_):
        said.append(["CallRemoteMethod", str(method)])
        return ""

    def respond(msg):
        said.append(["Respond", str(msg)])
        return ""

    values = {name: to_python(value) for name, value in context.items()}
    values |= {
        "action_respond_info": respond,
        "action_raise_error": raise_error,
        "action_emergency_stop": say("EmergencyStop", "action_emergency_stop"),
        "action_call_remote_method": remote,
    }
    try:
        return {"text": str(template.render(values)), "said": said}
    except Exception as error:  # noqa: BLE001
        return {"error": f"{type(error).__name__}: {error}", "said": said}


def ask_jinja(question):
    """Answers as the desk program does."""
    if "literal" in question:
        try:
            value = ast.literal_eval(question["literal"])
            json.dumps(value)
            return {"text": repr(value)}
        except (SyntaxError, TypeError, ValueError) as error:
            return {"error": str(error)}
    try:
        template = ENVIRONMENT.from_string(question["template"])
    except jinja2.TemplateSyntaxError as error:
        return {"refused": f"line {error.lineno}: {error.message}"}
    return {"results": [render_jinja(template, context) for context in question["contexts"]]}


def ask_desk(desk, questions):
    """The desk program's answers."""
    text = "".join(json.dumps(question) + "\n" for question in questions)
    answers = subprocess.run([desk], input=text, capture_output=True, text=True, check=True).stdout
    return [json.loads(line) for line in answers.splitlines()]


def read_sections(path):
    """Sections of a file by Klipper's rules: `#` ends a line anywhere, `;` behind a blank."""
    text = path.read_text(encoding="utf-8", errors="strict").split("#*# <---")[0]
    lines = [line.split("#", 1)[0] for line in text.replace("\r\n", "\n").split("\n")]
    parser = configparser.RawConfigParser(strict=False, inline_comment_prefixes=(";", "#"))
    parser.read_string("\n".join(lines))
    return {name: dict(parser.items(name)) for name in parser.sections()}


def literal_of(text):
    """The text, if it is a literal that Klipper takes."""
    try:
        json.dumps(ast.literal_eval(text))
        return text
    except (SyntaxError, TypeError, ValueError):
        return None


def read_corpus(folder):
    """Templates with their place, each once, and the macros' variables of each set."""
    templates, variables, seen = [], {}, set()
    for path in sorted(folder.rglob("*.cfg")):
        if not path.is_file():
            continue
        group = path.relative_to(folder).parts[0]
        try:
            sections = read_sections(path)
        except (configparser.Error, UnicodeDecodeError):
            continue
        for section, options in sections.items():
            own = {}
            for name, value in options.items():
                if name.startswith("variable_") and literal_of(value) is not None:
                    own[name.removeprefix("variable_")] = {"literal": value}
            if section.startswith("gcode_macro "):
                variables.setdefault(group, {})[section] = own
            if section.split()[0] in ("menu", "display", "display_template", "display_data", "display_glyph"):
                continue
            for name, value in options.items():
                if name.endswith("gcode") and value and value not in seen:
                    seen.add(value)
                    templates.append((group, f"{path.relative_to(folder)} [{section}] {name}", value, own))
    return templates, variables


PATHS = re.compile(r"""printer(?:\.(\w+)|\[\s*['"]([^'"]+)['"]\s*\])((?:\.\w+|\[\s*['"][^'"]+['"]\s*\])+)""")
STEPS = re.compile(r"""\.(\w+)|\[\s*['"]([^'"]+)['"]\s*\]""")
METHODS = {"items", "keys", "values", "get", "split", "lower", "upper", "format", "update", "append", "copy"}


def complete(status, template):
    """A status in which each path that a template names leads somewhere."""
    status = copy.deepcopy(status)
    for match in PATHS.finditer(template):
        node = status.setdefault(match[1] or match[2], {})
        steps = [step[0] or step[1] for step in STEPS.findall(match[3])]
        steps = steps[: next((index for index, step in enumerate(steps) if step in METHODS), len(steps))]
        for index, step in enumerate(steps):
            if not isinstance(node, dict) or "literal" in node or "tuple" in node:
                break
            node = node.setdefault(step, 7.5 if index + 1 == len(steps) else {})
    return status


def contexts(template, own, macros):
    """Made values for a template: the machine in two states, without parameters and with three kinds."""
    names = set(re.findall(r"params\.([A-Za-z_0-9]+)", template)) | set(re.findall(r"params\[\s*['\"](\w+)", template))
    names -= METHODS
    made = []
    for status, value in ((0, None), (0, "1"), (1, "12.5"), (1, "abc"), (1, None)):
        params = {} if value is None else {name.upper(): value for name in sorted(names)}
        printer = complete({**statuses()[status], **macros}, template)
        raw = " ".join(f"{name}={text}" for name, text in params.items())
        made.append({**own, "printer": {"lookup": printer}, "params": params, "rawparams": raw})
    return made


# Tags and words that Velvet refuses by name: docs/macros.md.
KNOWN = re.compile(r"\{%[-+]?\s*(macro|call|include|import|from|extends|block|filter|with|autoescape|print|raw)\b|recursive")


def compare_corpus(desk, folder, out):
    """Compares all templates of a folder and writes what differs."""
    templates, variables = read_corpus(Path(folder))
    questions = [
        {"template": text, "contexts": contexts(text, own, variables.get(group, {}))}
        for group, _, text, own in templates
    ]
    count = dict.fromkeys(("templates", "jinja", "velvet", "known", "large", "renderings", "texts", "equal", "beyond"), 0)
    faults, sizes = [], []
    for (_, place, text, _), question, velvet in zip(templates, questions, ask_desk(desk, questions)):
        jinja = ask_jinja(question)
        count["templates"] += 1
        sizes.append(velvet.get("size", 0))
        if "refused" in jinja:
            if "refused" not in velvet:
                faults.append((place, f"Jinja2 refuses it: {jinja['refused']}", text))
            continue
        count["jinja"] += 1
        if "refused" in velvet:
            is_known = KNOWN.search(text) is not None
            count["known"] += is_known
            faults.append((place, f"refused{' by name' if is_known else ''}: {velvet['refused']}", text))
            continue
        count["velvet"] += 1
        count["large"] += velvet.get("large", False)
        for index, (theirs, ours) in enumerate(zip(jinja["results"], velvet["results"])):
            count["renderings"] += 1
            count["texts"] += "text" in theirs
            is_same = theirs.get("text") == ours.get("text") and theirs["said"] == ours["said"]
            is_address = " at 0x" in theirs.get("text", "") + json.dumps(theirs["said"])
            is_beyond = ": bytes of " in ours.get("error", "")
            count["equal"] += is_same or is_address
            count["beyond"] += is_beyond
            if not is_same and not is_address:
                faults.append((f"{place} #{index}", f"\n  Jinja2: {theirs}\n  Velvet: {ours}", text))
    report(count, faults, sizes, Path(out))
    return count["equal"] + count["beyond"] < count["renderings"] or count["velvet"] + count["known"] < count["jinja"]


def report(count, faults, sizes, out):
    out.mkdir(parents=True, exist_ok=True)
    (out / "differences.txt").write_text("\n\n".join(f"== {place}: {what}\n{text}" for place, what, text in faults))
    print(f"{count['templates']} templates, {count['jinja']} accepted by Jinja2, of these {count['velvet']} by Velvet,")
    print(f"{count['known']} refused for a tag that docs/macros.md names")
    print(f"{count['renderings']} renderings, {count['texts']} of them texts, the others errors: {count['equal']} equal,")
    print(f"{count['beyond']} refused for their size")
    print(f"{count['large']} templates want more memory or more lines than the board has: compared with more")
    print(f"largest program {max(sizes, default=0)} bytes; differences: {out / 'differences.txt'}")


def write_table(desk, path):
    """Writes Jinja2's answers to small templates beside the templates."""
    from macros_cases import CONTEXT, LITERALS, TEMPLATES

    lines = [json.dumps({"context": CONTEXT}, sort_keys=True)]
    questions = [{"template": text, "contexts": [CONTEXT]} for text in TEMPLATES]
    differ = 0
    for question, velvet in zip(questions, ask_desk(desk, questions)):
        answer = ask_jinja(question)
        is_refused = "refused" in answer
        result = {} if is_refused else answer["results"][0]
        row = {"template": question["template"], "text": result.get("text"), "refused": is_refused}
        lines.append(json.dumps(row))
        ours = {} if "refused" in velvet else velvet["results"][0]
        if (is_refused, result.get("text")) != ("refused" in velvet, ours.get("text")):
            differ += 1
            print(f"{question['template']!r}\n  Jinja2: {answer}\n  Velvet: {velvet}")
    questions = [{"literal": text} for text in LITERALS]
    for question, velvet in zip(questions, ask_desk(desk, questions)):
        answer = ask_jinja(question)
        lines.append(json.dumps({"literal": question["literal"], "text": answer.get("text")}))
        if answer.get("text") != velvet.get("text"):
            differ += 1
            print(f"{question['literal']!r}\n  Python: {answer}\n  Velvet: {velvet}")
    Path(path).write_text("\n".join(lines) + "\n")
    print(f"{len(lines) - 1} rows, {differ} differ")
    return differ > 0


def random_expression(draw, depth):
    """An expression of what macros are made of."""
    atoms = ["1", "0", "2.5", "-3", "'a'", "'12'", "'b c'", "''", "true", "none", "x", "y", "z", "s", "l", "d", "t", "missing", "[1, 2, 3]", "['b', 'A']",
             "{'k': 1}", "(1, 'a')", "range(4)", "params.X", "params", "rawparams", "speed", "tools", "table", "people", "printer.toolhead.position",
             "printer.extruder.temperature", "[[1, 2], [3]]", "[]", "1e20", "'%s'", "'%.2f'", "'{}'", "'x=1,y=2'", "printer.fan"]
    if depth <= 0 or draw.random() < 0.2:
        return draw.choice(atoms)
    inner = lambda: random_expression(draw, depth - 1)  # noqa: E731
    kind = draw.randrange(12)
    if kind < 3:
        operator = draw.choice("+ - * / // % ** ~ == != < > <= >= in and or".split() + ["not in"])
        return f"({inner()} {operator} {inner()})"
    if kind < 6:
        name = draw.choice(["abs", "int", "float", "default(1)", "d('q', true)", "round", "round(1)", "round(2, 'floor')", "string", "lower", "upper", "length",
                            "list", "sort", "sort(reverse=true)", "min", "max", "sum", "join(',')", "join", "first", "last", "reverse", "reverse|list", "trim", "title",
                            "capitalize", "map('int')|list", "map('string')|join('-')", "select|list", "reject('none')|list", "select('string')|list", "unique|list",
                            "replace('a', 'b')", "dictsort", "items|list", "count", "batch(2)|list", "slice(2)|list", "pprint", "int(5)", "float(2)", "wordcount",
                            "truncate(3)", "indent(2)", "center(7)", "map(attribute='a')|list", "map('upper')|list", "selectattr('a')|list", "format(1, 2)"])
        return f"{inner()}|{name}"
    if kind == 6:
        test = draw.choice("defined undefined none number string mapping sequence iterable integer float boolean odd even lower upper true false".split())
        return f"({inner()} is {draw.choice(['', 'not '])}{test})"
    if kind == 7:
        return f"({inner()} if {inner()} else {inner()})"
    if kind == 8:
        index = draw.choice(["0", "-1", "1", "'k'", "'a'", "1:", ":1", "::-1", "5", "x"])
        return f"{inner()}[{index}]"
    if kind == 9:
        method = draw.choice(["split(',')", "split()", "keys()|list", "items()|list", "get('k', 0)", "upper()", "strip('a')", "replace('1', '2')", "format(1, x)", "join(['a', 'b'])",
                              "count('a')", "index(1)", "find('a')", "startswith('a')", "zfill(5)", "isdigit()", "append(1)", "pop()", "copy()", "values()|list", "title()"])
        return f"{inner()}.{method}"
    if kind == 10:
        return draw.choice(["-", "+", "not "]) + inner()
    return draw.choice(["[{}, {}]", "({}, {})", "{{'k': {}, 1: {}}}"]).format(inner(), inner())


def random_block(draw, depth):
    """Tags within tags, which set and read a few variables."""
    out = []
    for _ in range(draw.randrange(1, 4)):
        name = draw.choice("x y s n.a speed u".split())
        value = draw.choice(["1", "x", "y", "s ~ 'q'", "x + 1", "[x, y]", "n.a", "speed", "u", "loop.index", "l|length", "'t' ~ x"])
        kind = draw.randrange(8 if depth > 0 else 3)
        if kind == 0:
            out.append("{%% set %s = %s %%}" % (name, value))
        elif kind < 3:
            out.append("<{%s}>" % value)
        elif kind < 5:
            middle = draw.choice(["", "{% else %}" + random_block(draw, depth - 1), "{% elif y %}" + random_block(draw, depth - 1)])
            out.append("{%% if %s %%}%s%s{%% endif %%}" % (draw.choice(["x", "0", "1", "u is defined", "x == 1", "y == x"]), random_block(draw, depth - 1), middle))
        elif kind < 7:
            head = draw.choice(["i in [1, 2]", "x in [5, 6]", "i in [4]", "x, y in [(1, 2), (3, 4)]", "i in []", "i in [1, 2, 3] if i != x", "u in 'ab'"])
            end = draw.choice(["", "", "{% else %}" + random_block(draw, depth - 1)])
            out.append("{%% for %s %%}%s%s{%% endfor %%}" % (head, random_block(draw, depth - 1), end))
        else:
            out.append(draw.choice(["{%% set %s %%}%s{%% endset %%}" % (name, random_block(draw, depth - 1)), "{% set _ = l.append(x) %}", "{% set x, y = y, x %}"]))
    return "".join(out)


def random_template(draw):
    """A template with variables, branches and loops."""
    if draw.random() < 0.4:
        return draw.choice(["", "{% set x = 3 %}{% set y = 2 %}"]) + "{% set s = 'abc' %}{% set l = [1] %}{% set n = namespace(a=1) %}" + random_block(draw, 3)
    parts = ["{% set x = 3 %}{% set y = 2.5 %}{% set z = -7 %}{% set s = 'abc' %}{% set l = [3, 1, 2] %}{% set d = {'k': 1, 'b': [2]} %}{% set t = (1, 'a') %}"]
    for _ in range(draw.randrange(1, 4)):
        expression = random_expression(draw, draw.randrange(1, 4))
        parts.append(draw.choice([
            "{ %s }", "{ %s }", "{ %s }", "{%% set x = %s %%}{x}", "{%% if %s %%}a{%% else %%}b{%% endif %%}", "{%% for i in %s %%}{i},{%% else %%}e{%% endfor %%}",
            "{%% set s %%}{%s}{%% endset %%}[{s}]", "{%% for i in [1, 2] %%}{%% set x = %s %%}{x};{%% endfor %%}{x}",
        ]) % expression)
    return "".join(parts)


def compare_random(desk, count, seed):
    """Compares templates made at random."""
    from macros_cases import CONTEXT

    draw = random.Random(int(seed))
    templates = [random_template(draw) for _ in range(int(count))]
    questions = [{"template": text, "contexts": [CONTEXT]} for text in templates]
    differ = texts = 0
    for question, velvet in zip(questions, ask_desk(desk, questions)):
        answer = ask_jinja(question)
        theirs = {} if "refused" in answer else answer["results"][0]
        ours = {} if "refused" in velvet else velvet["results"][0]
        texts += "text" in theirs
        if theirs.get("text") != ours.get("text") and " at 0x" not in theirs.get("text", ""):
            differ += 1
            print(f"{question['template']}\n  Jinja2: {answer}\n  Velvet: {velvet}")
    print(f"{count} templates, {texts} of them texts, {differ} differ")
    return differ > 0


if __name__ == "__main__":
    if len(sys.argv) == 5 and sys.argv[1] == "random":
        sys.exit(compare_random(*sys.argv[2:]))
    if len(sys.argv) == 5 and sys.argv[1] == "corpus":
        sys.exit(compare_corpus(*sys.argv[2:]))
    if len(sys.argv) == 4 and sys.argv[1] == "table":
        sys.exit(write_table(*sys.argv[2:]))
    sys.exit(__doc__)
