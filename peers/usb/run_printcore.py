"""printrun's printcore, which pronsole and Pronterface are made of: prints a file on a serial port.

    run_printcore.py PORT GCODE
"""

import importlib.util
import os
import sys
import threading
import time

PROGRAM = os.path.abspath(__file__)


def python(tools):
    """A Python of its own with printrun, which the senders use as well: its program."""
    place = os.path.join(os.path.dirname(os.path.dirname(PROGRAM)), "senders", "run.py")
    specification = importlib.util.spec_from_file_location("senders", place)
    senders = importlib.util.module_from_spec(specification)
    specification.loader.exec_module(senders)
    return os.path.join(senders.environment(tools, "printcore"), "python")


def main():
    from printrun.gcoder import LightGCode
    from printrun.printcore import printcore

    port, path = sys.argv[1:]
    with open(path) as file:
        lines = [line.rstrip() for line in file]
    core, ended, heard = printcore(), threading.Event(), []
    core.recvcb = lambda line: heard.append(line.rstrip())
    core.endcb = ended.set
    began = time.monotonic()
    core.connect(port, 115200)
    while not core.online:
        if time.monotonic() - began > 60:
            raise SystemExit("not online after 60 s")
        time.sleep(0.05)
    online = time.monotonic() - began
    core.startprint(LightGCode(lines))
    ended.wait()
    resent = sum("resend" in line.lower() or line.startswith("rs ") for line in heard)
    errors = [line for line in heard if "error" in line.lower() or line.startswith("!!")]
    core.disconnect()
    if resent or errors:
        raise SystemExit(f"{resent} lines were asked for again; {errors[:3]}")
    print(f"online in {online:.1f} s, {sum(line.startswith('ok') for line in heard)} answers, no line sent again")


if __name__ == "__main__":
    main()
