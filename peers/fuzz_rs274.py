#!/usr/bin/env python3
"""Random NGC programs through LinuxCNC's interpreter and ours: where do they differ?

    fuzz_rs274.py VELVET OUT [SECONDS] [SEED]

Each program is made from a number, the same every time. A program on which both differ is cut down to the fewest lines
and words that still differ in the same way, and kept in OUT, one for each kind of difference. What is known, and why,
stands in fuzz_rs274.known. Not compared, since rs274 prints nothing of them: coolant, path modes' effect, the shape of
splines.
"""

import json
import os
import re
import shutil
import subprocess
import sys
import tempfile

from fuzz_programs import program_of
from rs274 import linuxcnc, same, tidy, velvet

HERE = os.path.dirname(os.path.abspath(__file__))
# Attempts at cutting one program down.
CUTS = 400


class Difference:
    """Where two interpreters part: a kind that stays the same while a program is cut down, and the words."""

    def __init__(self, kind, text):
        self.kind, self.text = kind, text


def shape_of(error):
    """An error's words without its numbers and names, nor the path before them."""
    error = error.rsplit(".ngc, line ", 1)[-1]
    error = re.sub(r"column \d+", "column", error)
    error = re.sub(r"<[^>]*>|'[^']*'|\"[^\"]*\"", "_", error)
    return re.sub(r"-?\d+(\.\d+)?", "0", error).lower()


def difference(program, path):
    """None when both agree."""
    try:
        theirs, they_did, their_error = linuxcnc(path)
        ours, we_did, our_error = velvet(program, path)
    except subprocess.TimeoutExpired:
        return Difference("takes too long", "")
    # What rs274 does not print: splines, and what a line of ours notes.
    ours = [action for action in ours if not re.match(r"(Cubic|Quadratic|Nurbs|Spline|note)", str(action[0]))]
    if they_did and not we_did:
        return Difference(f"only Velvet refuses: {shape_of(our_error)}", our_error)
    if we_did and not they_did:
        return Difference(f"only LinuxCNC refuses: {shape_of(their_error)}", their_error)
    # Of a program that both refuse, what came before counts as well, but LinuxCNC draws a line further ahead.
    if not they_did:
        return None
    ours, theirs = tidy(ours), tidy(theirs)
    for mine, other in zip(ours, theirs):
        if not same(mine, other):
            return Difference(f"action {other[0]} here {mine[0]}{parts(mine, other)}", f"LinuxCNC {other}; Velvet {mine}")
    if len(ours) != len(theirs):
        kind = "more" if len(ours) > len(theirs) else "fewer"
        first = (ours + theirs)[min(len(ours), len(theirs))] if kind == "more" else theirs[len(ours)]
        return Difference(f"{kind} actions here", f"LinuxCNC has {len(theirs)}, Velvet {len(ours)}; the first: {first}")
    return None


def parts(mine, other):
    """Which fields differ, by number, when both are of one kind."""
    if mine[0] != other[0] or len(mine) != len(other):
        return ""
    return " in " + ",".join(str(index) for index, (a, b) in enumerate(zip(mine, other)) if not same([a], [b]))


class Bench:
    """Runs programs from a folder of its own."""

    def __init__(self, velvet_path):
        self.velvet, self.folder = velvet_path, tempfile.mkdtemp(prefix="fuzz-rs274-")

    def look(self, lines):
        path = os.path.join(self.folder, "fuzz.ngc")
        with open(path, "w") as out:
            out.write("\n".join(lines) + "\nM2\n")
        return difference(self.velvet, path)

    def cut_down(self, lines, kind):
        """The fewest lines, then words, that differ in the same way."""
        left = CUTS

        def still(candidate):
            nonlocal left
            left -= 1
            found = self.look(candidate)
            return found is not None and found.kind == kind

        size = max(len(lines) // 2, 1)
        while left > 0:
            at, cut = 0, False
            while at < len(lines) and left > 0:
                shorter = lines[:at] + lines[at + size:]
                if still(shorter):
                    lines, cut = shorter, True
                else:
                    at += size
            if size == 1 and not cut:
                break
            size = max(size // 2, 1)
        for index, line in enumerate(lines):
            words = re.findall(r"[A-Za-z]\[[^A-Z]*\]|\([^)]*\)|[^\s]+", line)
            at = 0
            while at < len(words) and left > 0:
                shorter = lines[:index] + [" ".join(words[:at] + words[at + 1:])] + lines[index + 1:]
                if still(shorter):
                    words, lines = words[:at] + words[at + 1:], shorter
                else:
                    at += 1
        return lines


def known_kinds():
    """(a pattern for the kind, a pattern for the program that was cut down, the reason)"""
    known = []
    with open(os.path.join(HERE, "fuzz_rs274.known")) as lines:
        for line in lines:
            if line.strip() and not line.startswith("#"):
                kind, program, reason = line.strip().split(" | ", 2)
                known.append((re.compile(kind), re.compile(program), reason))
    return known


def reason_for(known, kind, lines):
    text = "\n".join(lines)
    return next((reason for k, p, reason in known if k.search(kind) and p.search(text)), None)


def spent():
    """Processor time of this process and its children, seconds."""
    return sum(os.times()[:4])


def main():
    velvet_path, out, *rest = sys.argv[1:]
    seconds, seed = float(rest[0]) if rest else 60.0, int(rest[1]) if len(rest) > 1 else 1
    if not shutil.which("rs274"):
        print("rs274 is not installed: apt-get install --no-install-recommends linuxcnc-uspace")
        return 2
    os.makedirs(out, exist_ok=True)
    bench, known, cases, counts = Bench(velvet_path), known_kinds(), {}, {"programs": 0, "lines": 0, "agree": 0}
    began = spent()
    while spent() - began < seconds:
        lines = program_of(seed)
        found = bench.look(lines)
        counts["programs"] += 1
        counts["lines"] += len(lines)
        counts["agree"] += found is None
        if found:
            case = cases.setdefault(found.kind, {"count": 0, "seeds": [], "forms": {}})
            case["count"] += 1
            # The same kind may have several causes: the first ones of each are cut down, then a few.
            if case["count"] <= 12 or case["count"] % 20 == 0:
                case["seeds"].append(seed)
                small = bench.cut_down(lines, found.kind)
                reason = reason_for(known, found.kind, small)
                form = reason or re.sub(r"\d+(\.\d+)?", "0", " / ".join(small))[:200]
                if form not in case["forms"]:
                    text = (bench.look(small) or found).text
                    case["forms"][form] = {"count": 0, "seed": seed, "known": reason, "program": small, "text": text}
                    print(f"{'known' if reason else 'NEW'} seed {seed}: {found.kind}: {reason or ' / '.join(small)}", flush=True)
                case["forms"][form]["count"] += 1
        seed += 1
        if counts["programs"] % 200 == 0:
            write(out, counts, cases, seed)
    write(out, counts, cases, seed)
    unknown = sum(form["known"] is None for case in cases.values() for form in case["forms"].values())
    print(f"{counts['programs']} programs of {counts['lines']} lines: {counts['agree']} agree, "
          f"{counts['programs'] - counts['agree']} differ; {unknown} forms of difference without a known reason")
    return 1 if unknown else 0


def write(out, counts, cases, seed):
    with open(os.path.join(out, "fuzz.json"), "w") as file:
        json.dump({**counts, "next_seed": seed, "differences": cases}, file, indent=1)


if __name__ == "__main__":
    sys.exit(main())
