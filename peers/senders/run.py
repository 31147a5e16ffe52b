#!/usr/bin/env python3
"""Runs other people's senders, unmodified, against the image on the virtual board.

    run.py TOOLS OUT [printcore|printcore-tcp|printcore-net|octoprint|bcnc|bcnc-net|cncjs ...]

They are installed into TOOLS from PyPI and npm, in the versions below. What they were asked to do and what the machine
then did is printed, and written to OUT/report.txt and OUT/report.html. bCNC wants a display: Debian's xvfb.
"""

import html
import json
import os
import shutil
import subprocess
import sys

HERE = os.path.dirname(os.path.abspath(__file__))
PYTHON_PACKAGES = {"printcore": ["--no-deps", "Printrun==2.2.0", "pyserial==3.5"], "octoprint": ["OctoPrint==1.11.8"], "bcnc": ["bCNC==0.9.16"]}
NODE_PACKAGES = ["cncjs@1.11.5"]
SENDERS = ["printcore-tcp", "printcore", "printcore-net", "octoprint", "bcnc", "bcnc-net", "cncjs"]
# Where printcore finds the board, by the end of its name.
WHERE = {"printcore-tcp": "tcp", "printcore-net": "net", "printcore": "terminal"}


def environment(tools, name):
    """A Python of its own with what a sender needs: where its programs are."""
    folder = os.path.join(tools, name)
    stamp = os.path.join(folder, "installed")
    wanted = " ".join(PYTHON_PACKAGES[name])
    if not os.path.exists(stamp) or open(stamp).read() != wanted:
        print(f"installing {wanted}", flush=True)
        subprocess.run([sys.executable, "-m", "venv", folder], check=True)
        subprocess.run([os.path.join(folder, "bin/pip"), "-q", "install", *PYTHON_PACKAGES[name]], check=True)
        with open(stamp, "w") as out:
            out.write(wanted)
    return os.path.join(folder, "bin")


def node_folder(tools):
    folder = os.path.join(tools, "cncjs")
    if not os.path.exists(os.path.join(folder, "node_modules/.bin/cncjs")):
        print(f"installing {' '.join(NODE_PACKAGES)}", flush=True)
        os.makedirs(folder, exist_ok=True)
        subprocess.run(["npm", "install", "--no-audit", "--no-fund", "--silent", *NODE_PACKAGES], check=True, cwd=folder)
    return folder


def missing(name):
    """A program of the system that this sender cannot do without."""
    needed = {"bcnc": ["xvfb-run"], "cncjs": ["node", "npm"]}.get(name.split("-")[0], [])
    return next((program for program in needed if not shutil.which(program)), None)


def run(name, tools, out):
    """Each sender in a process of its own, so that none finds another's leavings."""
    lacking = missing(name)
    if lacking:
        print(f"{name}: skipped, {lacking} is not installed")
        return [{"sender": name, "step": "all", "passed": None, "note": f"skipped: {lacking} is not installed"}]
    if name in WHERE:
        python, where = os.path.join(environment(tools, "printcore"), "python"), WHERE[name]
    elif name == "octoprint":
        python, where = sys.executable, os.path.join(environment(tools, name), "octoprint")
    elif name.startswith("bcnc"):
        python, where = sys.executable, os.path.join(environment(tools, "bcnc"), "python")
    else:
        python, where = sys.executable, node_folder(tools)
    script = os.path.join(HERE, f"{name.split('-')[0]}.py")
    rows_file = os.path.join(out, f"{name}.json")
    if os.path.exists(rows_file):
        os.remove(rows_file)
    subprocess.run([python, script, out, name, where], check=False)
    if not os.path.exists(rows_file):
        return [{"sender": name, "step": "all", "passed": False, "note": "ended before its first step"}]
    with open(rows_file) as file:
        return json.load(file)


def report(rows, out):
    words = {True: "ok", False: "FAILED", None: "skipped"}
    with open(os.path.join(out, "report.txt"), "w") as text:
        for row in rows:
            text.write(f"{row['sender']:14} {row['step']:10} {words[row['passed']]:8} {row['note']}\n")
    with open(os.path.join(out, "report.html"), "w") as page:
        page.write("<!doctype html><meta charset=utf-8><title>Senders</title><style>td,th{text-align:left;padding:.2em 1em}</style>"
                   "<h1>Senders against the virtual board</h1><table><tr><th>sender<th>step<th>result<th>the machine\n")
        for row in rows:
            cells = (row["sender"], row["step"], words[row["passed"]], row["note"])
            page.write("<tr>" + "".join(f"<td>{html.escape(cell)}" for cell in cells) + "\n")
        page.write("</table>\n")
    with open(os.path.join(out, "summary.json"), "w") as file:
        count = lambda passed: sum(row["passed"] is passed for row in rows)
        json.dump({"cases": rows, "passed": count(True), "failed": count(False), "skipped": count(None)}, file, indent=1)


def main():
    tools, out, *names = sys.argv[1:]
    tools, out = os.path.abspath(tools), os.path.abspath(out)
    os.makedirs(tools, exist_ok=True)
    os.makedirs(out, exist_ok=True)
    rows = [row for name in names or SENDERS for row in run(name, tools, out)]
    report(rows, out)
    failed = [row for row in rows if row["passed"] is False]
    print(f"{len(rows)} steps, {len(failed)} failed: {os.path.join(out, 'report.html')}")
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
