#!/usr/bin/env python3
"""Runs Klipper's host program, unmodified, against the image `controller` on the virtual board.

    run.py KLIPPER OUT --console PROGRAM --elf IMAGE [--pace RATE | --lock] [--only NAME ...] [--print FILE]
    run.py KLIPPER OUT --model                     a model of a few lines in place of the image

KLIPPER is a folder with Klipper's public tree, which is read from there and never copied; the host compiles its helper in that
folder as it always does. It wants Python's cffi, greenlet, jinja2 and pyserial. What each scenario left is in OUT/NAME; the table is
printed, and written to OUT/report.txt and OUT/summary.json.
"""

import argparse
import json
import os
import subprocess
import sys
import time
import traceback

from clock import Clock
from desk import Desk
from host import Refused
from scenarios import SCENARIOS
from table import figures, table

HERE = os.path.dirname(os.path.abspath(__file__))
MODULES = {"cffi": "cffi", "greenlet": "greenlet", "jinja2": "jinja2", "serial": "pyserial"}


def lacking(klipper):
    """What the host cannot do without and is not there."""
    if not os.path.exists(os.path.join(klipper, "klippy", "klippy.py")):
        return f"{klipper}: no klippy/klippy.py in there"
    for module, package in MODULES.items():
        try:
            __import__(module)
        except ImportError:
            return f"the host wants Python's {package}: pip install {package}"
    # The host's own build of its helper. Left to the host, it comes after a look at the tree that fails where nothing was built.
    program = "import chelper; chelper.get_ffi()"
    built = subprocess.run([sys.executable, "-c", program], cwd=os.path.join(klipper, "klippy"), check=False)
    return "the host's helper cannot be built" if built.returncode else None


def run(name, options):
    """A scenario with boards and a host of its own: its row of the table."""
    folder = os.path.join(options.out, name)
    print(f"== {name}", flush=True)
    began, note = time.monotonic(), ""
    desk = Desk(options, folder)
    try:
        note = SCENARIOS[name](desk) or ""
        failure = None
    except (Refused, RuntimeError, OSError) as error:
        failure = str(error).strip()
        traceback.print_exc(file=open(os.path.join(folder, "failure.txt"), "w"))
    finally:
        desk.close()
    row = figures(name, desk, failure, note)
    row["seconds"] = time.monotonic() - began
    for line in table([row])[1:] + [f"   {reason}" for reason in row["reasons"]]:
        print(line, flush=True)
    return row


def arguments():
    parser = argparse.ArgumentParser()
    parser.add_argument("klipper")
    parser.add_argument("out")
    parser.add_argument("--console", help="the program virtual-prime")
    parser.add_argument("--elf", help="the image")
    parser.add_argument("--model", action="store_true", help="a model of the board in place of the image")
    parser.add_argument("--pace", type=float, default=0.25, help="share of real time at which boards run")
    parser.add_argument("--lock", action="store_true", help="host and boards on one clock, as fast as both can")
    parser.add_argument("--only", nargs="*", default=[], help="scenarios")
    parser.add_argument("--print", dest="gcode", help="file to print in place of a small one")
    options = parser.parse_args()
    if not options.model and not (options.console and options.elf):
        parser.error("say which image with --console and --elf, or --model")
    unknown = set(options.only) - set(SCENARIOS)
    if unknown:
        parser.error(f"no such scenario: {' '.join(unknown)}; there are {' '.join(SCENARIOS)}")
    options.klipper, options.out = os.path.abspath(options.klipper), os.path.abspath(options.out)
    options.clock = Clock() if options.lock else None
    return options


def main():
    options = arguments()
    reason = lacking(options.klipper)
    if reason:
        print(reason, file=sys.stderr)
        return 2
    os.makedirs(options.out, exist_ok=True)
    rows = [run(name, options) for name in options.only or SCENARIOS]
    if options.clock:
        options.clock.close()
    text = table(rows)
    print("\n".join(["", *text]))
    with open(os.path.join(options.out, "report.txt"), "w") as file:
        file.writelines(f"{line}\n" for line in text)
    with open(os.path.join(options.out, "summary.json"), "w") as file:
        json.dump(rows, file, indent=1)
    return 1 if any(row["reasons"] for row in rows) else 0


if __name__ == "__main__":
    sys.exit(main())
