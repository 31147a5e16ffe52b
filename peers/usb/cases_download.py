"""Firmware over USB: dfu-util, as a user would."""

import os
import re
import shutil

from bench import Skipped, case, clean, expect, plug
from cases_board import DEVICE, ask

PORT = "/dev/ttyACM0"
# What `make firmware` makes for cards and for downloads, beside the image.
FILE = "flashme.bin"


def detach(guest, board):
    """Asks for the download; what dfu-util lists before."""
    listed = guest.do(f"dfu-util -l -d {DEVICE}")
    expect("Found Runtime" in listed, f"dfu-util -l: {listed[-300:]}")
    code, said = guest.run(f"dfu-util -e -d {DEVICE}")
    expect(code == 0, f"dfu-util -e: exit code {code}: {said[-300:]}")
    guest.wait(f"[ ! -c {PORT} ]", 30)
    return next(line for line in listed.splitlines() if "Found Runtime" in line).strip()


@case("download: dfu-util -l and -e")
def leaves(bench):
    guest, board = bench.guest(), bench.board("detach")
    try:
        plug(guest, board)
        guest.do(f"stty -F {PORT} raw -echo; cat {PORT} > /tmp/heard & sleep 1")
        found = detach(guest, board)
        heard = guest.do("cat /tmp/heard")
        expect(re.search("firmware (download|over USB)", heard), f"who listens is told: {heard!r}")
        clean(guest)
        return f"{found}; the ports are gone, and who listened was told"
    finally:
        board.close()


@case("download: dfu-util -D, and the new firmware starts")
def downloads(bench):
    guest, board = bench.guest(), bench.board("download")
    try:
        shutil.copy(os.path.join(os.path.dirname(bench.firmware), FILE), guest.share)
        plug(guest, board)
        detach(guest, board)
        edges = board.state()["edges"]
        # In the download, or, where the boot stage has none, back in the same firmware.
        guest.wait(f"{{ [ -c {PORT} ] || dfu-util -l -d {DEVICE} | grep -q 'Found DFU'; }}", 120)
        if "Found DFU" not in guest.do(f"dfu-util -l -d {DEVICE}"):
            raise Skipped("this boot stage has no download yet: the board came back with the same firmware")
        began = board.state()["s"]
        code, said = guest.run(f"dfu-util -d {DEVICE} -D /share/{FILE}", 1800)
        # 74: its reset at the end has found another device there, which dfu-util 0.11 takes for a failure behind its "Done!".
        expect(code in (0, 74) and said.rstrip().endswith("Done!"), f"dfu-util -D: exit code {code}: {said[-400:]}")
        seconds = board.state()["s"] - began
        guest.wait(f"[ -c {PORT} ]", 120)
        guest.do(f"stty -F {PORT} raw -echo")
        heard = ask(guest, PORT, "M115")
        expect("Velvet" in heard, f"M115 is answered by {heard!r}")
        expect(board.state()["edges"] == edges, "motors moved")
        size = os.path.getsize(os.path.join(guest.share, FILE))
        return f"{size} bytes in {seconds:.0f} s of the board's time (dfu-util's exit code {code}); M115 is answered again, and no motor has moved"
    finally:
        board.close()
