#!/usr/bin/env python3
"""Compares what LinuxCNC's interpreter and ours make of the same programs.

    rs274.py VELVET OUT [FILE...]

`rs274` is in Debian's linuxcnc-uspace. Both sides are brought to one form: machine coordinates in mm, feeds in mm/min,
centres of arcs in machine coordinates. Where they differ for a reason, the reason stands in rs274.known.
"""

import html
import json
import math
import os
import re
import shutil
import signal
import subprocess
import sys
import tempfile

HERE = os.path.dirname(os.path.abspath(__file__))
TOLERANCE = 2e-3  # rs274 prints four decimals, of inches too
TIMEOUT = 20
ATTEMPTS = 3  # several rs274 at a time: now and then one ends without a word
RELATIVE = 1e-5  # and ours of times, from which rates are worked out


SPINDLE = {"START_SPINDLE_CLOCKWISE": "cw", "START_SPINDLE_COUNTERCLOCKWISE": "ccw", "STOP_SPINDLE_TURNING": "stop"}
TABLE = os.path.join(HERE, "tool.tbl")


def in_inches(tool):
    """A line of our tool table as `rs274` wants it, whose machine counts in inches."""
    words, *comment = tool.split(";", 1)
    scaled = re.sub(r"([XYZD])([-+.\d]+)", lambda word: f"{word[1]}{float(word[2]) / 25.4:.9f}", words)
    return ";".join([scaled, *comment])


def number(text):
    return float(text) + 0.0


def linuxcnc(path):
    """The program's actions as LinuxCNC has them, and whether it was carried out."""
    with tempfile.TemporaryDirectory() as folder:
        table, variables = os.path.join(folder, "tool.tbl"), os.path.join(folder, "sim.var")
        with open(TABLE) as tools, open(table, "w") as out:
            out.write("".join(in_inches(tool) for tool in tools))
        open(variables, "w").close()
        command = ["rs274", "-t", table, "-v", variables, "-n", "2", "-g", path]
        # It shares its tools through a file in the home directory: another one beside it would read them.
        home = {**os.environ, "HOME": folder}
        for _ in range(ATTEMPTS):
            done = run_to_end(command, home)
            if done.returncode == 0 or refusal(done):
                break
    unit, g5x, g92, tool = 1.0, [0.0] * 3, [0.0] * 3, [0.0] * 3
    feed, plane, per_turn, pitch, actions, turned = 0.0, "XY", False, None, [], 0.0
    count = {"FEED": True, "SPEED": True}

    def place(x, y, z):
        x, y, z = (value + offset for value, offset in zip((x, y, z), g92))
        x, y = x * math.cos(turned) - y * math.sin(turned), x * math.sin(turned) + y * math.cos(turned)
        return [(value + g5x[axis] + tool[axis]) * unit for axis, value in enumerate((x, y, z))]

    for line in done.stdout.splitlines():
        found = re.match(r"\s*\d+ \S+\s+(\w+)\((.*)\)\s*$", line)
        if not found:
            continue
        name, rest = found.groups()
        switch = re.match(r"(DISABLE|ENABLE)_(FEED|SPEED)_OVERRIDE$", name)
        bits = re.match(r"(SET|CLEAR)_(MOTION|AUX)_OUTPUT_(BIT|VALUE)$", name)
        values = [number(word) for word in re.findall(r"(?<![\w.])-?\d+(?:\.\d*)?(?![\w.])", rest)]
        if name == "USE_LENGTH_UNITS":
            new = 25.4 if "INCH" in rest else 1.0
            g5x, g92, tool = ([value * unit / new for value in offset] for offset in (g5x, g92, tool))
            unit = new
        elif name == "SET_G5X_OFFSET":
            g5x = values[1:4]
        elif name == "SET_XY_ROTATION":
            turned = math.radians(values[0])
        elif name == "SET_G92_OFFSET":
            g92 = values[:3]
        elif name == "USE_TOOL_LENGTH_OFFSET":
            tool = values[:3]
        elif name == "SELECT_PLANE":
            plane = rest.rsplit("_", 1)[-1]
        elif name == "SET_FEED_RATE":
            feed = values[0] * unit
        elif name == "SET_FEED_MODE":
            per_turn = values[1] == 1
        elif name == "STRAIGHT_TRAVERSE":
            actions.append(["rapid", *place(*values[:3])])
        elif name == "STRAIGHT_FEED":
            rate = ["turn", pitch] if pitch else ["turn", feed] if per_turn else [feed]
            actions.append(["feed", *place(*values[:3]), *rate])
        elif name == "START_SPEED_FEED_SYNC":
            pitch = values[0] * unit
        elif name == "STOP_SPEED_FEED_SYNCH":
            pitch = None
        elif name == "RIGID_TAP":
            actions.append(["tap", *place(*values[:3]), pitch])
        elif bits:
            when = "path" if bits[2] == "MOTION" else "now"
            state = [values[1]] if bits[3] == "VALUE" else ["on" if bits[1] == "SET" else "off"]
            actions.append([bits[3].lower(), values[0], *state, when])
        elif switch:
            count[switch[2]] = switch[1] == "ENABLE"
            actions.append(["overrides", count["FEED"], count["SPEED"]])
        elif name in SPINDLE:
            actions.append(["spindle", SPINDLE[name]])
        elif name == "ORIENT_SPINDLE":
            actions.append(["orient", *values[1:3]])
        elif name == "SET_SPINDLE_MODE":
            if values[-1] > 0:
                actions.append(["surface", values[-1]])
        elif name == "ARC_FEED":
            first, second, centre1, centre2, turns, along = values[:6]
            order = {"XY": (0, 1, 2), "XZ": (2, 0, 1), "YZ": (1, 2, 0)}[plane]
            end, centre = [0.0] * 3, [0.0] * 3
            for axis, value, middle in zip(order, (first, second, along), (centre1, centre2, 0.0)):
                end[axis], centre[axis] = value, middle
            end, centre = place(*end), place(*centre)
            sense = "ccw" if turns > 0 else "cw"
            actions.append(["arc", plane, sense, abs(int(turns)), *end, *(centre[axis] for axis in sorted(order[:2])), feed])
        elif name == "DWELL":
            actions.append(["dwell", values[0]])
        elif name == "MESSAGE":
            actions.append(["message", said(rest[1:-1])])
        elif name in ("PROGRAM_STOP", "OPTIONAL_PROGRAM_STOP"):
            actions.append(["pause"])
        elif name == "CHANGE_TOOL":
            actions.append(["tool"])
    return actions, done.returncode == 0, " at: ".join(refusal(done)[-2:])


def said(text):
    """A message; what is nothing but rounding has no sign."""
    return re.sub(r"-(0\.0+)(?!\d)", r"\1", text.strip())


def run_to_end(command, environment):
    """Runs a program; one that takes too long is killed with what it has started."""
    pipes = {"stdin": subprocess.DEVNULL, "stdout": subprocess.PIPE, "stderr": subprocess.PIPE}
    with subprocess.Popen(command, text=True, env=environment, start_new_session=True, **pipes) as process:
        try:
            out, error = process.communicate(timeout=TIMEOUT)
        except BaseException:
            os.killpg(process.pid, signal.SIGKILL)
            raise
    return subprocess.CompletedProcess(command, process.returncode, out, error)


def refusal(done):
    """What a run said is wrong."""
    return [line for line in done.stderr.splitlines() if line.strip() and line.strip() != "executing"]


def velvet(program, path):
    done = subprocess.run([program, "actions", "--tools", TABLE, path], capture_output=True, text=True, timeout=TIMEOUT)
    actions, here = [], [0.0] * 3
    for line in done.stdout.splitlines():
        words = line.split()
        if words[0] in ("rapid", "feed"):
            start, here = here, [number(word) for word in words[1:4]]
            feed = [number(word[1:]) for word in words if word.startswith("F")]
            for word in words:
                feed += ["turn", number(word[1:])] if word.startswith("P") else []
            # After G93 the time is said.
            feed += [math.dist(start, here) * 60.0 / number(word[1:]) for word in words if word.startswith("T")]
            actions.append([words[0], *here, *feed])
        elif words[0] == "arc":
            _, plane, sense, turns, *rest = words
            start, feed = here, number(rest[-1][1:])
            if rest[0].startswith("R"):
                radius, places = number(rest[0][1:]), rest[1:]
            else:
                radius, places = None, rest[2:]
            here = [number(word) for word in places[:3]]
            axes = {"XY": (0, 1), "XZ": (0, 2), "YZ": (1, 2)}[plane]
            turns_left = sense == "ccw"
            if plane == "XZ":
                # Ours is seen with X first, LinuxCNC's with Z first.
                sense = "cw" if turns_left else "ccw"
            if radius is None:
                centre = [number(word) for word in rest[:2]]
            else:
                centre = centre_of(start, here, axes, radius, turns_left)
            if rest[-1].startswith("T"):
                feed = length_of(start, here, axes, centre, turns_left, int(turns)) * 60.0 / feed if feed else math.inf
            actions.append(["arc", plane, sense, int(turns), *here, *centre, feed])
        elif words[0] == "dwell":
            actions.append(["dwell", number(words[1])])
        elif words[0] == "message":
            actions.append(["message", said(line[len("message "):])])
        elif words[0] == "tap":
            actions.append(["tap", *(number(word) for word in words[1:4]), number(words[4][1:])])
        elif words[0] in ("output", "value"):
            kind, when = {"output": "bit", "value": "value"}[words[0]], "path" if len(words) > 3 else "now"
            state = words[2] if kind == "bit" else number(words[2])
            actions.append([kind, number(words[1]), state, when])
        elif words[0] == "orient":
            actions.append(["orient", number(words[1]), number(words[2])])
        elif words[0] == "surface_speed" and number(words[1]) == 0.0:
            pass
        elif words[0] == "surface_speed":
            actions.append(["surface", number(words[1])])
        elif words[0] == "overrides":
            actions.append(["overrides", *(word == "true" for word in words[1:3])])
        elif words[0] == "input":
            pass
        elif words[0] in ("pause", "tool"):
            actions.append([words[0]])
        elif words[0] == "spindle":
            actions.append(words)
        elif words[0] not in ("end", "print", "note", "note:") and not line.startswith("position is A"):
            # LinuxCNC prints beside its actions, and has no axis A here.
            actions.append([line])
    return actions, done.returncode == 0, done.stderr.strip().splitlines()[-1] if done.stderr.strip() else ""


def centre_of(start, end, axes, radius, turns_left):
    """The centre of an arc that is given by its radius."""
    (ax, ay), (bx, by) = ([place[axis] for axis in axes] for place in (start, end))
    dx, dy = bx - ax, by - ay
    chord = math.hypot(dx, dy)
    if chord == 0.0:
        return [ax, ay]
    height = math.sqrt(max(radius * radius - chord * chord / 4.0, 0.0))
    side = (1.0 if turns_left else -1.0) * (1.0 if radius > 0 else -1.0)
    return [(ax + bx) / 2.0 - side * dy / chord * height, (ay + by) / 2.0 + side * dx / chord * height]


def length_of(start, end, axes, centre, turns_left, turns):
    """How long an arc is, along its axis too."""
    first, last = (math.atan2(place[axes[1]] - centre[1], place[axes[0]] - centre[0]) for place in (start, end))
    radius = math.hypot(start[axes[0]] - centre[0], start[axes[1]] - centre[1])
    angle = (last - first if turns_left else first - last) % math.tau
    if angle < 1e-9:
        angle = math.tau
    along = sum(end[axis] - start[axis] for axis in range(3) if axis not in axes)
    return math.hypot(radius * (angle + (turns - 1) * math.tau), along)


def same(ours, theirs):
    if len(ours) != len(theirs):
        return False
    pairs = zip(ours, theirs)
    near = lambda a, b: abs(a - b) <= max(TOLERANCE, RELATIVE * abs(b))
    return all(near(a, b) if isinstance(a, float) and isinstance(b, float) else a == b for a, b in pairs)


def tidy(actions):
    """Without what changes nothing: moves to where the tool is already, a spindle that turns so already."""
    kept, here, spindle = [], [0.0] * 3, "stop"
    for action, behind in zip(actions, [*actions[1:], [None]]):
        if action == ["dwell", 0.0]:
            continue
        if action[0] == "spindle":
            # M6 and M2 stop it, whether it turns or not; Velvet says a new S as it says M3, and stops from one way to
            # the other.
            if behind[0] == "spindle" or action[1] == spindle:
                continue
            spindle = action[1]
        if action[0] in ("rapid", "feed"):
            if all(abs(a - b) <= TOLERANCE for a, b in zip(action[1:4], here)):
                continue
            here = action[1:4]
        elif action[0] == "arc":
            here = action[4:7]
        kept.append(action)
    return with_overrides_once(kept)


def with_overrides_once(actions):
    """LinuxCNC switches feed and spindle one behind the other, and once more where nothing changes."""
    kept, overrides = [], ["overrides", True, True]
    # The end of a program stops the spindle and lets them count again.
    end = len(actions)
    while end and (actions[end - 1][0] == "overrides" or actions[end - 1] == ["spindle", "stop"]):
        end -= 1
    for place, (action, behind) in enumerate(zip(actions, [*actions[1:], [None]])):
        if action[0] == "overrides":
            if place >= end or behind[0] == "overrides" or action == overrides:
                continue
            overrides = action
        kept.append(action)
    return kept


def compare(program, path):
    """None when both agree, else where they do not."""
    (theirs, they_did, their_error), (ours, we_did, our_error) = linuxcnc(path), velvet(program, path)
    if they_did != we_did:
        return f"LinuxCNC: {their_error or 'carried out'}; Velvet: {our_error or 'carried out'}"
    if not they_did:
        return None
    ours, theirs = tidy(ours), tidy(theirs)
    for place, (mine, other) in enumerate(zip(ours, theirs)):
        if not same(mine, other):
            return f"action {place + 1}: LinuxCNC {other}; Velvet {mine}"
    if len(ours) != len(theirs):
        return f"LinuxCNC has {len(theirs)} actions, Velvet {len(ours)}"
    return None


def known_differences():
    known = {}
    with open(os.path.join(HERE, "rs274.known")) as lines:
        for line in lines:
            if line.strip() and not line.startswith("#"):
                name, reason = line.strip().split(": ", 1)
                known[name] = reason
    return known


PAGE = """<!doctype html><meta charset="utf-8"><title>Programs beside LinuxCNC's rs274</title>
<style>body {{ font: 15px sans-serif; margin: 2em; max-width: 70em }} td, th {{ padding: .2em .8em; text-align: left;
border-bottom: 1px solid #ccc; vertical-align: top }} .differs {{ color: #b00 }} .known {{ color: #770 }}</style>
<h1>Programs beside LinuxCNC's rs274</h1><p>{summary}</p>
<table><tr><th>program<th>result<th>difference</tr>
{rows}
</table>
"""


def write_page(out, cases, summary):
    """A page for a person: every program, those that differ first."""

    def kind(case):
        return "agrees" if case["figure"] == "agree" else "known" if case["ok"] else "differs"

    order = {"differs": 0, "known": 1, "agrees": 2}
    rows = []
    for case in sorted(cases, key=lambda case: (order[kind(case)], case["name"])):
        cells = (f"<td>{html.escape(text)}" for text in (case["name"], kind(case), case["why"]))
        rows.append(f'<tr class="{kind(case)}">' + "".join(cells) + "</tr>")
    with open(os.path.join(out, "report.html"), "w") as file:
        file.write(PAGE.format(summary=html.escape(summary), rows="\n".join(rows)))


def main():
    program, out, *files = sys.argv[1:]
    if not shutil.which("rs274"):
        print("rs274 is not installed: apt-get install --no-install-recommends linuxcnc-uspace")
        return 2
    corpus = os.path.join(HERE, "ngc")
    files = files or sorted(os.path.join(corpus, name) for name in os.listdir(corpus) if name.endswith(".ngc"))
    known, cases = known_differences(), []
    for path in files:
        name = os.path.basename(path)[: -len(".ngc")]
        difference = compare(program, path)
        reason = known.get(name) if difference else None
        case = {"name": name, "ok": difference is None or reason is not None, "figure": "agree" if difference is None else "differ"}
        case["why"] = reason or difference or ""
        cases.append(case)
        if difference:
            print(f"{'known' if reason else 'DIFFERS'} {name}: {reason or difference}")
    passed = sum(case["ok"] for case in cases)
    agree = sum(case["figure"] == "agree" for case in cases)
    summary = {"cases": cases, "passed": passed, "failed": len(cases) - passed, "skipped": 0}
    os.makedirs(out, exist_ok=True)
    with open(os.path.join(out, "summary.json"), "w") as file:
        json.dump(summary, file, indent=1)
    said = f"{agree} of {len(cases)} programs agree, {passed - agree} differ for a known reason"
    write_page(out, cases, said)
    print(said)
    return 0 if passed == len(cases) else 1


if __name__ == "__main__":
    sys.exit(main())
