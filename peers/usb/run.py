#!/usr/bin/env python3
"""Plugs the image on the virtual board into a real Linux, and sees what its drivers and people's programs make of it.

    run.py TOOLS OUT FIRMWARE [CASE ...]      cases by any part of their names; what came of others with this image stays

The Linux is made of Debian's packages and runs in QEMU (parts.py, guest.py); nothing of it is installed. What came of
each case is printed, and written to OUT/summary.json and OUT/report.html.
"""

import hashlib
import os
import sys
import time

from bench import CASES, Bench, Failed, GuestError, Skipped
from page import earlier, write

# In this order.
import cases_echo
import cases_board
import cases_card
import cases_download
import cases_print


def attempt(bench, function):
    """A case: whether it went well (None: it was skipped), the figure, and the reason."""
    try:
        return True, function(bench) or "", ""
    except Skipped as why:
        return None, "", str(why)
    except (Failed, GuestError) as why:
        return False, "", str(why)
    except Exception as error:  # this script's own
        return False, "", f"{type(error).__name__}: {error}"


def image(path):
    """What the image is known by."""
    if not os.path.exists(path):
        return "none"
    with open(path, "rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()[:16]


def main():
    tools, out, firmware, *wanted = sys.argv[1:]
    tools, out, firmware = (os.path.abspath(path) for path in (tools, out, firmware))
    os.makedirs(out, exist_ok=True)
    chosen = [(name, function) for name, function in CASES if not wanted or any(part in name for part in wanted)]
    if not chosen:
        print("no case of this name; there are:", *(name for name, _ in CASES), sep="\n  ")
        return 2
    bench, rows, known = Bench(tools, out, firmware), [], image(firmware)
    try:
        for name, function in chosen:
            began = time.monotonic()
            ok, figure, why = attempt(bench, function)
            seconds = time.monotonic() - began
            if ok is False:
                bench.drop_guest()
            rows.append({"name": name, "ok": ok, "figure": figure, "why": why, "seconds": round(seconds, 1), "at": time.strftime("%Y-%m-%d %H:%M", time.gmtime())})
            word = {True: "ok", False: "FAILED", None: "skipped"}[ok]
            print(f"{word:8} {name}: {figure or why} ({seconds:.0f} s)", flush=True)
            # Behind each case, so that one that is broken off leaves the others'.
            write(out, known, earlier(out, known, rows, [name for name, _ in CASES]), bench.versions)
    finally:
        bench.close()
    failed = sum(row["ok"] is False for row in rows)
    print(f"{len(rows)} cases, {failed} failed: {os.path.join(out, 'report.html')}")
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
