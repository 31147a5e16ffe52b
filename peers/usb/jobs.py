"""Jobs to print, and whether all their steps were made."""

import itertools
import math
import os
import subprocess

from bench import ROOT, Failed, expect

# A round trip of the outline, pieces, and what a millimetre of it wants of filament, mm.
PIECES, FILAMENT = 120, 0.033


def layers(count):
    """A cold print of so many layers, some four seconds each: an outline with lobes, in pieces of a millimetre at speeds that
    vary, with travel and retraction between two layers, as slicers write it. Nothing is heated, so that no time is lost."""
    lines = ["M302 S0", "G21", "G90", "M83", "G28", "G92 E0"]
    for layer in range(count):
        lines += ["G1 E-1 F2400", f"G1 Z{0.2 + 0.2 * layer:.2f} F600"]
        last = None
        for piece in range(PIECES * 2 + 1):
            angle = 2 * math.pi * piece / PIECES
            radius = 22 - 3 * (piece // PIECES) + 2.5 * math.sin(5 * angle + 0.1 * layer)
            place = 100 + radius * math.cos(angle), 100 + radius * math.sin(angle)
            if last is None:
                lines += [f"G1 X{place[0]:.3f} Y{place[1]:.3f} F9000", "G1 E1 F2400", f"G1 F{3600 + 1200 * (layer % 3)}"]
            else:
                lines.append(f"G1 X{place[0]:.3f} Y{place[1]:.3f} E{math.dist(place, last) * FILAMENT:.5f}")
            last = place
    return lines


def job(bench, count):
    """The file to print, as a path: the one that the caller of `make usb` names, or layers."""
    named = os.environ.get("GCODE")
    if named:
        return os.path.abspath(named)
    path = os.path.join(bench.out, f"layers{count}.gcode")
    with open(path, "w") as file:
        file.write("\n".join(layers(count)) + "\n")
    return path


def motion(path):
    """Which motor stepped, and which way, in order."""
    with open(path) as file:
        next(file)
        for line in file:
            yield line.split(",", 1)[1]


def compare(found, wanted):
    """Whether two runs made the same steps in the same order: how many, in words.

    Two steps of different motors that fall together may change places where one of the runs was slower: a computer that
    keeps the machine waiting is no fault of the machine's. They are counted. No motor's own steps ever change places."""
    ours, theirs = motion(found), motion(wanted)
    count, swapped, pairs = 0, 0, itertools.zip_longest(ours, theirs)
    for one, other in pairs:
        count += 1
        if one == other:
            continue
        next_one, next_other = next(pairs, (None, None))
        if None in (one, other) or (one, other) != (next_other, next_one) or one.split(",")[0] == other.split(",")[0]:
            raise Failed(f"step {count} is {one and one.strip()}, and without a computer it is {other and other.strip()}")
        count, swapped = count + 1, swapped + 1
    return f"all {count} steps" + (f" ({swapped} times two that fall together the other way round)" if swapped else "")


def duration(path):
    """Seconds of the board's clock from the first step to the last."""
    with open(path, "rb") as file:
        next(file)
        first = next(file)
        file.seek(-200, os.SEEK_END)
        last = file.read().splitlines()[-1]
    return (int(last.split(b",")[0]) - int(first.split(b",")[0])) / 1e9


def reference(bench, path):
    """The same job from the card with nobody plugged in: the file of its steps. Made once."""
    out = os.path.join(bench.out, "reference", os.path.basename(path))
    steps, stamp = os.path.join(out, "steps.csv"), os.path.join(out, "made")
    inputs = f"{path} {os.path.getsize(path)} {os.path.getmtime(bench.firmware)}"
    if not (os.path.exists(stamp) and open(stamp).read() == inputs):
        program = os.path.join(ROOT, "virtual-prime/target/release/virtual-prime")
        command = [program, "run", "--elf", bench.firmware, "--config", bench.config(), "--gcode", path, "--out", out]
        said = subprocess.run(command, capture_output=True, text=True)
        expect(said.returncode == 0, f"the job fails without a computer: {said.stderr.strip().splitlines()[-1:]}")
        with open(stamp, "w") as file:
            file.write(inputs)
    return steps
