#!/usr/bin/env python3
"""Files as slicers and CAM programs really write them, made here and run end to end on the native runner.

    slicers.py VELVET TOOLS OUT

From Debian: prusa-slicer, slic3r, cura-engine with cura's definitions (fetched by apt-get into TOOLS), freecad. What is
not installed is skipped. Of each file: the dialect it is read in, lines, moves, what was not carried out, how it ended,
and whether the tool went as far as the file says. What ends otherwise for a reason is listed in slicers.known.
"""

import csv
import html
import json
import os
import re
import shutil
import subprocess
import sys

HERE = os.path.dirname(os.path.abspath(__file__))
ROOT = os.path.dirname(HERE)
PRINTER = os.path.join(ROOT, "config/samples/cartesian.ini")
MILL = os.path.join(HERE, "senders/mill.ini")
TABLE = os.path.join(HERE, "tool.tbl")
PRUSA = ["reprap", "reprapfirmware", "repetier", "teacup", "makerware", "marlin", "marlin2", "sailfish", "mach3", "machinekit", "smoothie",
         "no-extrusion"]
SLIC3R = ["reprap", "repetier", "teacup", "makerware", "sailfish", "mach3", "machinekit", "smoothie", "no-extrusion"]
CURA = ["fdmprinter", "creality_ender3", "ultimaker2", "ultimaker3", "prusa_i3", "anycubic_i3_mega", "lulzbot_mini", "makerbotreplicator"]
CURA_FLAVOURS = ["RepRap (Marlin/Sprinter)", "RepRap (RepRap)", "RepRap (Volumetric)", "Griffin", "Repetier", "BFB", "MACH3", "Makerbot"]
# How far the tool may be from what the file says: a step, and a corner that is rounded by G64.
TOLERANCE_MM = 0.06


def cube(path):
    """A plate of 10 x 10 x 1 mm."""
    corners, height = [(0, 0), (10, 0), (10, 10), (0, 10)], 1.0
    facets = [((*corners[0], z), (*corners[a], z), (*corners[b], z)) for z, pairs in ((0, ((2, 1), (3, 2))), (height, ((1, 2), (2, 3)))) for a, b in pairs]
    for index, (a, b) in enumerate(zip(corners, corners[1:] + corners[:1])):
        facets += [((*a, 0), (*b, 0), (*b, height)), ((*a, 0), (*b, height), (*a, height))]
    with open(path, "w") as out:
        out.write("solid plate\n")
        for facet in facets:
            out.write("facet normal 0 0 0\nouter loop\n" + "".join("vertex %g %g %g\n" % place for place in facet) + "endloop\nendfacet\n")
        out.write("endsolid plate\n")


FREECAD = '''
import os
import FreeCAD
from PathScripts import PathJob, PathPostProcessor, PathProfile
document = FreeCAD.newDocument("part")
box = document.addObject("Part::Box", "Box")
box.Length, box.Width, box.Height = 30, 20, 5
box.Placement.Base = FreeCAD.Vector(40, 30, 0)
document.recompute()
job = PathJob.Create("Job", [box], None)
profile = PathProfile.Create("Profile")
document.recompute()
tool = job.Tools.Group[0]
tool.HorizFeed, tool.VertFeed, tool.SpindleSpeed = "600 mm/min", "200 mm/min", 1000
document.recompute()
posts = os.path.join(FreeCAD.getHomePath(), "Mod/Path/PathScripts/post")
for name in sorted(file[:-8] for file in os.listdir(posts) if file.endswith("_post.py")):
    try:
        PathPostProcessor.PostProcessor.load(name).export([tool, profile], os.path.join({out!r}, "freecad-" + name + ".gcode"), "--no-show-editor")
    except BaseException as error:
        print("no file from", name, error)
'''


def quietly(command, **more):
    try:
        return subprocess.run(command, stdin=subprocess.DEVNULL, capture_output=True, text=True, timeout=300, **more)
    except subprocess.TimeoutExpired:
        return None


def cura_resources(tools):
    """Debian's definitions, unpacked but not installed: they want a desktop."""
    folder = os.path.join(tools, "cura")
    definitions = os.path.join(folder, "x/usr/share/cura/resources")
    if not os.path.isdir(definitions):
        os.makedirs(folder, exist_ok=True)
        quietly(["apt-get", "download", "cura"], cwd=folder)
        packages = [name for name in os.listdir(folder) if name.endswith(".deb")]
        if not packages:
            return None
        quietly(["dpkg-deb", "-x", packages[0], "x"], cwd=folder)
    return definitions


# What Cura's window writes for {names} in start and end codes; its engine alone leaves them.
CURA_NAMES = {"machine_depth": "200", "machine_width": "200", "speed_travel": "9000", "speed_print": "3000", "material_print_temperature": "210",
              "material_bed_temperature": "60", "material_print_temperature_layer_0": "210", "material_bed_temperature_layer_0": "60"}


def fill_in(path, values):
    with open(path) as file:
        text = file.read()
    with open(path, "w") as file:
        file.write(re.sub(r"\{(\w+)\}", lambda found: values.get(found.group(1), found.group(0)), text))


def make_files(out, tools):
    """(name, path, configuration) of every file that could be made; what could not is said."""
    part, files = os.path.join(out, "plate.stl"), []
    cube(part)

    def add(name, configuration, command, filled_in=None, **more):
        path = os.path.join(out, name + ".gcode")
        done = quietly([word.replace("OUT", path) if word == "OUT" else word for word in command], **more)
        if done and os.path.exists(path) and os.path.getsize(path):
            fill_in(path, filled_in or {})
            files.append((name, path, configuration))
        else:
            print(f"no file from {name}: {(done.stderr.strip().splitlines() or ['?'])[-1] if done else 'it takes too long'}")

    if shutil.which("prusa-slicer"):
        for flavour in PRUSA:
            add(f"prusa-{flavour}", PRINTER, ["prusa-slicer", "--export-gcode", "--gcode-flavor", flavour, "-o", "OUT", part])
        for flavour in ("marlin2", "reprapfirmware", "smoothie"):
            more = ["--use-firmware-retraction", "--use-relative-e-distances", "--layer-gcode", "G92 E0", "--remaining-times", "--gcode-label-objects",
                    "--default-acceleration", "800", "--perimeter-acceleration", "500", "--support-material", "--skirts", "2", "--bed-temperature", "60"]
            add(f"prusa-{flavour}-more", PRINTER, ["prusa-slicer", "--export-gcode", "--gcode-flavor", flavour, *more, "-o", "OUT", part])
    if shutil.which("slic3r"):
        for flavour in SLIC3R:
            add(f"slic3r-{flavour}", PRINTER, ["slic3r", "--layer-height", "0.2", "--gcode-flavor", flavour, "--print-center", "100,100", "-o", "OUT", part])
    resources = cura_resources(tools) if shutil.which("CuraEngine") else None
    if resources:
        environment = {**os.environ, "CURA_ENGINE_SEARCH_PATH": f"{resources}/definitions:{resources}/extruders"}
        place = ["-s", "machine_width=200", "-s", "machine_depth=200", "-s", "machine_height=170"]
        for printer in CURA:
            add(f"cura-{printer}", PRINTER, ["CuraEngine", "slice", "-j", f"{resources}/definitions/{printer}.def.json", *place, "-o", "OUT", "-l", part],
                CURA_NAMES, env=environment)
        for flavour in CURA_FLAVOURS:
            short = re.sub(r"\W+", "-", flavour).strip("-").lower()
            add(f"cura-as-{short}", PRINTER, ["CuraEngine", "slice", "-j", f"{resources}/definitions/creality_ender3.def.json", *place,
                                             "-s", f"machine_gcode_flavor={flavour}", "-o", "OUT", "-l", part], CURA_NAMES, env=environment)
    if shutil.which("freecadcmd"):
        script = os.path.join(out, "make_paths.py")
        with open(script, "w") as text:
            text.write(FREECAD.replace("{out!r}", repr(out)))
        done = quietly(["freecadcmd", script], env={**os.environ, "QT_QPA_PLATFORM": "offscreen"})
        print("".join(line + "\n" for line in (done.stdout if done else "").splitlines() if line.startswith("no file from")), end="")
        made = sorted(name for name in os.listdir(out) if name.startswith("freecad-") and name.endswith(".gcode"))
        files += [(name[: -len(".gcode")], os.path.join(out, name), MILL) for name in made]
    return files


def extent(path):
    """How far the file's moves go in X and Y, machine coordinates if it homes first: (least, most), and how many there are."""
    here, offset, relative, unit, moves = [0.0, 0.0], [0.0, 0.0], False, 1.0, 0
    least, most, motion = [0.0, 0.0], [0.0, 0.0], None
    with open(path, errors="replace") as lines:
        for line in lines:
            line = re.sub(r"\([^)]*\)|;.*", "", line).upper()
            codes = [f"G{int(code)}" for code in re.findall(r"G0*(\d+)(?!\.)", line)]
            words = {letter: float(value) for letter, value in re.findall(r"([XYZEIJR])\s*([-+]?\d*\.?\d+)", line)}
            unit = 25.4 if "G20" in codes else 1.0 if "G21" in codes else unit
            relative = "G91" in codes or relative and "G90" not in codes
            motion = next((code for code in codes if code in ("G0", "G1", "G2", "G3")), motion)
            if "G28" in codes or "G53" in codes or "G92" in codes:
                if "G28" in codes:
                    here = [0.0, 0.0]
                continue
            if not words or any(code in ("G4", "G10") for code in codes):
                continue
            moves += motion is not None
            for axis, letter in enumerate("XY"):
                if letter in words:
                    here[axis] = words[letter] * unit + (here[axis] if relative else offset[axis])
                    least[axis], most[axis] = min(least[axis], here[axis]), max(most[axis], here[axis])
    return least, most, moves


def travelled(out, configuration):
    """How far the carriages of X and Y went: (least, most), from where they were at the start or, homed, from zero."""
    with open(configuration) as lines:
        steps = dict(re.findall(r"^(alpha|beta)\.steps_per_mm\s*=\s*([\d.]+)", lines.read(), re.M))
    with open(os.path.join(out, "summary.json")) as file:
        summary = json.load(file)
    counts, least, most = {"alpha": 0, "beta": 0}, {"alpha": 0, "beta": 0}, {"alpha": 0, "beta": 0}
    with open(os.path.join(out, "steps.csv")) as rows:
        for row in csv.reader(rows):
            if row[1] in counts:
                counts[row[1]] += int(row[2])
                least[row[1]], most[row[1]] = min(least[row[1]], counts[row[1]]), max(most[row[1]], counts[row[1]])
    result = []
    for motor in ("alpha", "beta"):
        per_mm = float(steps[motor])
        start = summary["actuators"][motor]["position_mm"] - counts[motor] / per_mm
        result.append((least[motor] / per_mm, most[motor] / per_mm, start))
    return result


def run(velvet, name, path, configuration, out):
    """One row of the table."""
    folder = os.path.join(out, name)
    shutil.rmtree(folder, ignore_errors=True)
    # What the machine has on its card before the job comes.
    os.makedirs(os.path.join(folder, "card"))
    if configuration == MILL:
        shutil.copy(TABLE, os.path.join(folder, "card", "tool.tbl"))
    done = quietly([velvet, "run", "--config", configuration, "--gcode", path, "--out", folder, "--until", "3000"])
    row = {"file": name, "dialect": "console's", "lines": sum(1 for _ in open(path, errors="replace")), "moves": extent(path)[2], "left_out": "", "end": ""}
    try:
        said = open(os.path.join(folder, "console.log"), errors="replace").read().splitlines()
    except OSError:
        said = []
    for line in said:
        found = re.search(r"the file is read as (\w+)'s", line)
        row["dialect"] = found.group(1) if found else row["dialect"]
        found = re.search(r"not carried out: (.*?)\]?$", line)
        row["left_out"] = found.group(1) if found else row["left_out"]
    row["left_out"] = "" if "M24 goes on" in row["left_out"] else row["left_out"]
    errors = [line for line in said if re.match(r"(error|!!|ALARM|\[MSG:.*(paused|error))", line)]
    if not done or done.returncode or errors:
        # The reason stands before the pause.
        first = said.index(errors[0]) if errors else 0
        if errors and "paused" in errors[0] and first and not said[first - 1].startswith("ok"):
            errors[0] = said[first - 1]
        told = errors[0] if errors else ((done.stderr + done.stdout).strip().splitlines() or ["?"])[-1] if done else "it does not end"
        row["end"] = told
        return row
    row["end"] = "done"
    least, most, _ = extent(path)
    for axis, (low, high, start) in enumerate(travelled(folder, configuration)):
        homed = configuration == PRINTER
        far = abs(start + high - most[axis]) if homed else max(abs(high - most[axis]), abs(low - least[axis]))
        if far > TOLERANCE_MM and not (homed and start > most[axis]):
            row["end"] = f"{'XY'[axis]} went to {start + high if homed else high:.2f}, the file says {most[axis]:.2f}"
    return row


def known_ends():
    known = []
    with open(os.path.join(HERE, "slicers.known")) as lines:
        for line in lines:
            if line.strip() and not line.startswith("#"):
                name, end, reason = line.strip().split(" | ", 2)
                known.append((re.compile(name + "$"), re.compile(end), reason))
    return known


def main():
    velvet, tools, out = (os.path.abspath(path) for path in sys.argv[1:4])
    os.makedirs(out, exist_ok=True)
    os.makedirs(tools, exist_ok=True)
    known, rows = known_ends(), []
    for name, path, configuration in make_files(out, tools):
        row = run(velvet, name, path, configuration, out)
        row["known"] = next((reason for n, e, reason in known if n.match(name) and e.search(row["end"])), "") if row["end"] != "done" else ""
        row["ok"] = row["end"] == "done" or bool(row["known"])
        rows.append(row)
        print(f"{'ok' if row['ok'] else 'FAILED':7}{name:28} {row['dialect']:15} {row['lines']:5} lines {row['moves']:5} moves  {row['end']}"
              + (f" ({row['known']})" if row["known"] else "") + (f"; left out: {row['left_out']}" if row["left_out"] else ""), flush=True)
    with open(os.path.join(out, "summary.json"), "w") as file:
        json.dump(rows, file, indent=1)
    with open(os.path.join(out, "report.html"), "w") as page:
        page.write("<!doctype html><meta charset=utf-8><title>Slicers</title><style>td,th{text-align:left;padding:.2em 1em}</style><table>"
                   "<tr><th>file<th>read as<th>lines<th>moves<th>left out<th>end<th>known\n")
        for row in rows:
            cells = (row["file"], row["dialect"], row["lines"], row["moves"], row["left_out"], row["end"], row["known"])
            page.write("<tr>" + "".join(f"<td>{html.escape(str(cell))}" for cell in cells) + "\n")
        page.write("</table>\n")
    done, failed = sum(row["end"] == "done" for row in rows), [row for row in rows if not row["ok"]]
    print(f"{len(rows)} files: {done} done, {len(rows) - done - len(failed)} refused for a known reason, {len(failed)} failed")
    if not rows:
        print("none of the slicers is installed: apt-get install --no-install-recommends prusa-slicer slic3r cura-engine freecad-python3")
        return 2
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
