"""Migrates every printer.cfg of a folder, and counts by another reader whether each option is accounted for.

    klipper_files.py VELVET FOLDER OUT     every .cfg file in FOLDER, on its own

Nothing of the files is kept: OUT has a folder with config.ini and the report for each, and summary.txt.
"""

import collections
import configparser
import glob
import json
import math
import os
import subprocess
import sys
from pathlib import Path

BLOCK_HEAD = "#*# <---"
# Lines that head the block of SAVE_CONFIG.
HEAD_LINES = 3


class Unreadable(Exception):
    """Klipper would not take the file."""


def new_parser():
    return configparser.RawConfigParser(strict=False, inline_comment_prefixes=(";", "#"))


def without_comments(line):
    return line.split("#", 1)[0]


def read_text(path):
    raw = Path(path).read_bytes()
    if b"\0" in raw:
        raise Unreadable("no text")
    return raw.decode("utf-8", "replace").replace("\r\n", "\n").replace("\r", "\n").lstrip("\ufeff")


def take(parser, lines):
    try:
        parser.read_string("\n".join(lines))
    except configparser.Error as error:
        raise Unreadable(str(error).split("\n")[0]) from error


def read_lines(parser, path, lines, trail):
    """Klipper's way: what stands between two includes is read as a piece."""
    here = os.path.abspath(path)
    if here in trail:
        raise Unreadable("includes itself")
    piece = []
    for line in map(without_comments, lines):
        head = configparser.RawConfigParser.SECTCRE.match(line)
        name = head.group("header") if head else ""
        if not name.startswith("include "):
            piece.append(line)
            continue
        take(parser, piece)
        piece = []
        pattern = os.path.join(os.path.dirname(path), name[8:].strip())
        found = sorted(glob.glob(pattern))
        if not found and not glob.has_magic(pattern):
            raise Unreadable("a missing include")
        for other in found:
            read_lines(parser, other, read_text(other).split("\n"), trail + [here])
    take(parser, piece)


def read(path):
    """All options of a file, its includes and what SAVE_CONFIG wrote."""
    parser = new_parser()
    written, saved = [], []
    for line in read_text(path).split("\n"):
        (saved if saved or (line.startswith(BLOCK_HEAD) and "SAVE_CONFIG" in line) else written).append(line)
    read_lines(parser, path, written, [])
    if saved and all(line in ("", "#*#") or line.startswith("#*# ") for line in saved):
        block = new_parser()
        take(block, [without_comments(line[4:]) for line in saved[HEAD_LINES:]])
        for section in block.sections():
            if not parser.has_section(section):
                parser.add_section(section)
            for option, value in block.items(section):
                if not parser.has_option(section, option):
                    parser.set(section, option, value)
    return parser


def number(parser, section, option, default=None):
    try:
        return float(parser.get(section, option).replace("_", ""))
    except (configparser.Error, ValueError):
        return default


def steps_per_mm(parser, section):
    """Steps of a motor for a millimetre, or a degree, by Klipper's formula."""
    full = number(parser, section, "full_steps_per_rotation", 200.0)
    micro = number(parser, section, "microsteps")
    way = number(parser, section, "rotation_distance", 360.0)
    if not micro or not way:
        return None
    gears = 1.0
    for pair in parser.get(section, "gear_ratio", fallback="").split(","):
        if ":" in pair:
            over, under = map(float, pair.split(":"))
            gears *= over / under
    return abs(full * micro * gears / way)


def settings(path):
    """Settings of a config.ini by section and key."""
    found, section = {}, ""
    for line in Path(path).read_text().split("\n"):
        line = line.split("#", 1)[0].strip()
        if line.startswith("["):
            section = line[1:-1]
        elif "=" in line:
            key, value = line.split("=", 1)
            found[section, key.strip()] = value.strip()
    return found


NUMBERS = [
    ("printer", "max_velocity", "motion control", "max_speed", 60.0),
    ("printer", "max_accel", "motion control", "default_acceleration", 1.0),
    ("printer", "max_z_velocity", "motion control", "z_axis_max_speed", 60.0),
    ("printer", "square_corner_velocity", "planner", "square_corner_velocity", 1.0),
    ("stepper_x", "position_max", "soft endstop", "x_max", 1.0),
    ("stepper_y", "position_max", "soft endstop", "y_max", 1.0),
    ("stepper_z", "position_max", "soft endstop", "z_max", 1.0),
    ("stepper_x", "position_min", "soft endstop", "x_min", 1.0),
    ("stepper_y", "position_min", "soft endstop", "y_min", 1.0),
    ("stepper_z", "position_min", "soft endstop", "z_min", 1.0),
    ("extruder", "max_temp", "temperature control", "hotend.max_temp", 1.0),
    ("extruder", "min_temp", "temperature control", "hotend.min_temp", 1.0),
    ("extruder", "pid_kp", "temperature control", "hotend.p_factor", 1.0),
    ("extruder", "pid_ki", "temperature control", "hotend.i_factor", 1.0),
    ("extruder", "pid_kd", "temperature control", "hotend.d_factor", 1.0),
    ("heater_bed", "max_temp", "temperature control", "bed.max_temp", 1.0),
    ("extruder", "pressure_advance", "extruder", "hotend.pressure_advance", 1.0),
    ("extruder", "min_extrude_temp", "extruder", "hotend.min_extrude_temp", 1.0),
    ("extruder", "max_extrude_only_accel", "actuator", "delta.acceleration", 1.0),
    ("heater_bed", "min_temp", "temperature control", "bed.min_temp", 1.0),
    ("heater_bed", "pid_kp", "temperature control", "bed.p_factor", 1.0),
    ("heater_bed", "pid_ki", "temperature control", "bed.i_factor", 1.0),
    ("heater_bed", "pid_kd", "temperature control", "bed.d_factor", 1.0),
    ("printer", "max_z_accel", "actuator", "gamma.acceleration", 1.0),
    ("printer", "delta_radius", "linear delta", "arm_radius", 1.0),
    ("stepper_a", "arm_length", "linear delta", "arm_length", 1.0),
    ("fan", "off_below", "fan", "fan.off_below", 100.0),
    ("fan", "max_power", "fan", "fan.max_power", 100.0),
    ("input_shaper", "shaper_freq_x", "input shaper", "shaper_freq_x", 1.0),
    ("input_shaper", "shaper_freq_y", "input shaper", "shaper_freq_y", 1.0),
]


HOMING = ("position_endstop", "homing_speed", "second_homing_speed", "homing_retract_dist")


def compare(parser, report, new):
    """Numbers of both files that should be the same: how many are, and which are not."""
    same, other = 0, []

    def judge(name, expected, found):
        nonlocal same
        if found is not None and math.isclose(expected, float(found), rel_tol=1e-9, abs_tol=1e-9):
            same += 1
        else:
            other.append(f"{name}: {expected} became {found}")

    fates = {(row["section"], option["option"]): option for row in report["account"] for option in row["options"]}
    for section, option, new_section, key, factor in NUMBERS:
        value = number(parser, section, option)
        fate = fates.get((section, option))
        if value is not None and fate and fate["class"] == "converted":
            judge(f"[{section}] {option}", value * factor, new.get((new_section, key)))
    for row in report["account"]:
        for option in row["options"]:
            for line in option["becomes"]:
                if option["option"] != "rotation_distance" or ".steps_per_mm = " not in line:
                    continue
                key = line.split("] ")[1].split(" = ")[0]
                judge(f"[{row['section']}] steps", steps_per_mm(parser, row["section"]), new.get(("actuator", key)))
            if option["option"] in HOMING:
                for line in option["becomes"]:
                    place, value = line.split(" = ")
                    if place.startswith("[endstops] ") and not place.endswith("_trim_mm"):
                        expected = number(parser, row["section"], option["option"])
                        # The way back from a stall is never shorter than what the driver needs.
                        if option["option"] != "homing_retract_dist" or float(value) <= expected:
                            judge(f"[{row['section']}] {option['option']}", expected, value)
            if option["option"] == "run_current" and any("[current control]" in line for line in option["becomes"]):
                key = option["becomes"][0].split("] ")[1].split(" = ")[0]
                amps = min(round(float(option["value"]) * math.sqrt(2), 3), 5.5)
                found = float(new["current control", key])
                # One step of the driver's current scale.
                if abs(found - amps) <= 5.5 / 32:
                    same += 1
                else:
                    other.append(f"[{row['section']}] current: {amps} became {found}")
    return same, other


def migrate(velvet, path, out):
    run = subprocess.run([velvet, "migrate", str(path), "--out", str(out)], capture_output=True, text=True, timeout=120)
    return run.returncode, run.stderr


class Tally:
    """What was counted over all files."""

    def __init__(self):
        self.counts = collections.Counter()
        self.faults = []
        self.refused = collections.Counter()
        self.unconverted = collections.Counter()
        self.findings = collections.Counter()

    def account(self, name, parser, report):
        pairs = collections.Counter((s, o) for s in parser.sections() for o in parser.options(s))
        told = collections.Counter((row["section"], option["option"]) for row in report["account"] for option in row["options"])
        for pair in (pairs - told) + (told - pairs):
            self.faults.append(f"{name}: {pair} is {told[pair]} times in the report, {pairs[pair]} times in the file")
        self.counts["pairs"] += sum(pairs.values())
        self.counts["sections"] += len(parser.sections())
        self.counts["told"] += sum(told.values())
        for row in report["account"]:
            for option in row["options"]:
                kind = "kept" if option["kept"] else option["class"]
                self.counts[kind] += 1
                value = parser.get(row["section"], option["option"]).strip()
                if value.split() != option["value"].split():
                    self.faults.append(f"{name}: [{row['section']}] {option['option']} was read as {option['value']!r}")
                if kind == "refused":
                    self.refused[row["section"].split(" ")[0], option["option"], option["reason"]] += 1
                if not option["reason"] and not option["becomes"]:
                    self.faults.append(f"{name}: [{row['section']}] {option['option']} has no reason")


def main(velvet, folder, out):
    tally = Tally()
    files = sorted(Path(folder).rglob("*.cfg"))
    for path in files:
        name = str(path.relative_to(folder))
        target = Path(out) / name.replace("/", "_").removesuffix(".cfg")
        code, said = migrate(velvet, path, target)
        tally.counts[f"exit {code}"] += 1
        try:
            parser = read(path)
        except Unreadable as error:
            tally.counts["Klipper would refuse"] += 1
            if code != 2:
                tally.faults.append(f"{name}: unreadable ({error}), and the exit code is {code}")
            continue
        if code not in (0, 1) or not parser.sections():
            if parser.sections():
                tally.faults.append(f"{name}: exit code {code}: {said.strip().splitlines()[-1:]}")
            continue
        report = json.loads((target / "report.json").read_text())
        tally.account(name, parser, report)
        tally.counts["starts" if report["usable"] else "does not start"] += 1
        check = subprocess.run([velvet, "check", "--json", str(target / "config.ini")], capture_output=True, text=True)
        if check.returncode not in (0, 1):
            tally.faults.append(f"{name}: velvet check ends with {check.returncode}")
        for finding in json.loads(check.stdout)["findings"]:
            tally.findings[finding["severity"], finding["key"], finding["reason"]] += 1
            tally.counts[finding["severity"]] += 1
            if finding["severity"] != "warning" and not finding["key"]:
                tally.faults.append(f"{name}: a finding without a name: {finding['reason']}")
        same, other = compare(parser, report, settings(target / "config.ini"))
        tally.counts["numbers the same"] += same
        tally.counts["numbers not the same"] += len(other)
        tally.faults += [f"{name}: {text}" for text in other]
    summary = Path(out) / "summary.txt"
    with summary.open("w") as text:
        text.write("\n".join(tally.faults) + "\n\nrefused:\n")
        for (section, option, why), count in tally.refused.most_common():
            text.write(f"{count:6} [{section}] {option}: {why}\n")
        text.write("\nfindings of velvet check:\n")
        for (severity, key, reason), count in tally.findings.most_common():
            text.write(f"{count:6} {severity} {key}: {reason}\n")
    print(f"{len(files)} files:", ", ".join(f"{name} {count}" for name, count in sorted(tally.counts.items())))
    difference = tally.counts["pairs"] - tally.counts["told"]
    print(f"difference {difference}, {len(tally.faults)} faults; {summary}")
    for fault in tally.faults[:20]:
        print(" ", fault[:300])
    return 1 if tally.faults or difference else 0


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:4]))
