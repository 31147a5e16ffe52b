"""Prints while a computer is plugged in, stalls, and is pulled out."""

import csv
import itertools
import json
import os
import random
import shutil
import socket
import subprocess
import threading
import time

from bench import ROOT, Failed, Skipped, case, expect, plug
from jobs import compare, duration, job, reference

CYCLES = 100
# The computer's stalls, seconds, and the most between two of them.
STALL, BETWEEN = 0.040, 0.5
# A print may take as long as this, seconds of the board's clock.
PRINT_SECONDS = 36_000
# Lines of a shell that opens the port for each: more than the machine has room for, each slower than the shell, mm/min.
ECHOES, ECHO_FEED = 500, 20
# Layers of the job from the card, which lasts longer than the cycles, and of the one that is streamed.
CABLE_LAYERS, STREAM_LAYERS = 60, 20
# Heating takes a while, seconds of the board's clock.
PATIENCE = 200.0


class Debug:
    """The debug console, as a line."""

    def __init__(self, board):
        self.socket = socket.create_connection(("127.0.0.1", board.port))

    def say(self, line):
        self.socket.sendall((line + "\n").encode())


def end(bench, name, board, guest):
    """The board's files, when nothing moves any more: every step. The virtual board has nothing to complain of."""
    board.rest(PRINT_SECONDS, still=3.0)
    guest.unplug()
    board.end()
    with open(os.path.join(bench.out, name, "summary.json")) as file:
        summary = json.load(file)
    amiss = summary["errors"] + summary["board"]
    expect(not amiss, f"the virtual board complains: {amiss[:3]}")
    return os.path.join(bench.out, name, "steps.csv")


@case("print: the cable out and in 100 times")
def cable(bench):
    """A job from the card, and a computer that comes, talks and goes at any moment."""
    part = job(bench, CABLE_LAYERS)
    wanted, draw = reference(bench, part), random.Random(7)
    guest, card = bench.guest(), os.path.join(bench.out, "card")
    shutil.rmtree(card, ignore_errors=True)
    os.makedirs(card)
    shutil.copy(part, os.path.join(card, "job.gcode"))
    board = bench.board("cable", sd=card, files=True)
    try:
        Debug(board).say("play /sd/job.gcode")
        board.moving(60)
        moved, opened = 0, 0
        # Somebody who asks as much as he can on both ports, whenever they are there. By nodes of his own: writing to one that
        # the kernel has just taken away would make a file in its place.
        guest.do("rm -f /tmp/stop /tmp/acm*; mknod /tmp/acm0 c 166 0; mknod /tmp/acm1 c 166 1; yes M105 | head -20 > /tmp/questions; "
                 "for p in 0 1; do while [ ! -e /tmp/stop ]; do stty -F /tmp/acm$p raw -echo && { timeout 0.3 cat /tmp/acm$p & cat /tmp/questions > /tmp/acm$p; wait; }; "
                 "sleep 0.02; done > /dev/null 2>&1 & done")
        edges = board.state()["edges"]
        for cycle in range(CYCLES):
            guest.plug(board.usb_ports[0])
            if cycle % 2:
                guest.wait("[ -c /dev/ttyACM0 ]", 60)
            time.sleep(draw.uniform(0.0, 0.8))
            opened += guest.run("[ -c /dev/ttyACM0 ]")[0] == 0
            board.unplug()
            guest.unplug()
            time.sleep(draw.uniform(0.0, 0.2))
            now = board.state()["edges"]
            moved += now > edges
            edges = now
        guest.do("touch /tmp/stop")
        sent = sum(board.state()["usb_sent"][1:3])
        guest.messages()
        plug(guest, board, "/dev/ttyACM1")
        steps = compare(end(bench, "cable", board, guest), wanted)
        expect(moved == CYCLES, f"the machine moved in {moved} of {CYCLES} cycles")
        expect(opened > CYCLES // 2, f"the ports were there in {opened} of {CYCLES} cycles")
        return f"{CYCLES} times, all of them while it moved, {opened} with the ports there, where {sent} bytes were said; {steps} as without a computer"
    finally:
        board.close()


def rested(board):
    """The board's state when the computer says nothing more: it may still have had something of the greeting to echo."""
    last = board.state()
    while True:
        time.sleep(0.02)
        state = board.state()
        if state["usb_sent"] == last["usb_sent"]:
            return state
        last = state


@case("print: what was acknowledged is done")
def acknowledged(bench):
    """Lines that each make one step, sent over and over, and the cable out in the middle of it."""
    draw, guest, board = random.Random(11), bench.guest(), bench.board("acknowledged", files=True)
    try:
        # One step each, there and back by turns, so that no end of the axis is near.
        texts = [("G91\n" + f"G1 Y{way}0.0125 F1200\n" * 4000).encode() for way in ("", "-")]
        for name, text in zip("01", texts):
            with open(os.path.join(guest.share, f"lines{name}"), "wb") as file:
                file.write(text)
        wanted, cycles, bytes_sent, empty = [], [], 0, 0
        for cycle in range(CYCLES):
            plug(guest, board)
            # The greeting may come before the terminal is told not to echo it. Whatever is echoed is ahead of a question, and
            # so acknowledged before the count begins.
            guest.do("[ -c /tmp/acm0 ] || mknod /tmp/acm0 c 166 0; exec 5<>/tmp/acm0; stty raw -echo <&5; printf '\\necho ready\\n' >&5; "
                     "while read -r -t 60 l <&5; do case $l in ready*) exit 0;; esac; done; exit 1")
            begun = rested(board)
            before = begun["usb_sent"][1]
            guest.do(f"(cat /share/lines{cycle % 2} > /tmp/acm0) > /dev/null 2>&1 &")
            time.sleep(draw.uniform(0.0, 0.25))
            # At the board's end: QEMU that removes the device takes back one transfer after another, and what is behind one
            # that is gone may still go out, as it cannot over a cable that is.
            gone = board.unplug()
            sent = gone["usb_sent"][1] - before
            guest.unplug()
            guest.wait("[ ! -c /dev/ttyACM0 ]")
            # The first line only says that the others are relative.
            lines = max(texts[cycle % 2][:sent].count(b"\n") - 1, 0)
            wanted += [("1", "-1")[cycle % 2]] * lines
            cycles.append({"lines": lines, "bytes": sent, "begun_s": begun["s"], "gone_s": gone["s"]})
            bytes_sent += sent
            empty += sent == 0
        board.rest(PRINT_SECONDS, still=3.0)
        Debug(board).say("M114.1")
        time.sleep(1.0)
        end(bench, "acknowledged", board, guest)
        # For whoever looks for a line.
        with open(os.path.join(bench.out, "acknowledged", "cycles.json"), "w") as file:
            json.dump(cycles, file, indent=0)
        with open(os.path.join(bench.out, "acknowledged", "steps.csv")) as file:
            steps = [row["direction"] for row in csv.DictReader(file)]
        # Strokes this way and that, so that a step too few tells when it was.
        strokes = [[(way, len(list(stroke))) for way, stroke in itertools.groupby(one)] for one in (wanted, steps)]
        differ = [pair for pair in itertools.zip_longest(*strokes) if pair[0] != pair[1]]
        expect(not differ, f"{len(wanted)} lines were acknowledged, and {len(steps)} steps made; the first stroke that differs: {differ[:1]}")
        return f"{CYCLES} times in the middle of {bytes_sent} bytes ({empty} before the first): {len(wanted)} whole lines acknowledged, {len(steps)} steps made"
    finally:
        board.close()


@case("print: a line at a time with echo, each opens and closes the port")
def echoed(bench):
    guest, board = bench.guest(), bench.board("echoed", files=True)
    try:
        plug(guest, board)
        began = board.state()["s"]
        guest.do(f"stty -F /dev/ttyACM0 raw -echo; echo G91 > /dev/ttyACM0; n=0; while [ $n -lt {ECHOES} ]; do "
                 f"echo 'G1 Y0.0125 F{ECHO_FEED}' > /dev/ttyACM0; n=$((n+1)); done")
        said = board.state()
        board.rest(PRINT_SECONDS, still=3.0)
        end(bench, "echoed", board, guest)
        with open(os.path.join(bench.out, "echoed", "steps.csv")) as file:
            steps = [row["direction"] for row in csv.DictReader(file)]
        expect(steps == ["1"] * ECHOES, f"{ECHOES} lines of one step, and {len(steps)} steps made")
        return f"{ECHOES} lines in {said['s'] - began:.1f} s, of which the machine had done {said['edges']} then; {len(steps)} steps made"
    finally:
        board.close()


def stream(bench, name, part, stall):
    """printrun's printcore on a terminal that ends at the guest's /dev/ttyACM0. `stall`: the computer stands still now and then."""
    from run_printcore import PROGRAM, python

    wanted, draw = reference(bench, part), random.Random(3)
    try:
        interpreter = python(bench.tools)
    except (subprocess.CalledProcessError, OSError) as error:
        raise Skipped(f"printrun cannot be installed: {error}") from None
    guest, board = bench.guest(), bench.board(name, files=True)
    try:
        plug(guest, board)
        # A port of the guest is opened once, for both ways; it reads as ended while nobody is at the terminal.
        guest.do("stty -F /dev/ttyACM0 raw -echo; (exec 4<>$serial 5<>/dev/ttyACM0; cat <&5 >&4 & while [ -c /dev/ttyACM0 ]; do cat <&4 >&5; sleep 0.02; done) > /dev/null 2>&1 &")
        core = subprocess.Popen([interpreter, PROGRAM, guest.terminal, part], stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
        said = []
        reader = threading.Thread(target=lambda: said.extend(core.stdout), daemon=True)
        reader.start()
        stalls, last = 0, board.state()
        while core.poll() is None:
            time.sleep(draw.uniform(0, BETWEEN))
            if stall:
                guest.stall(STALL)
                stalls += 1
            state = board.state()
            if state["edges"] != last["edges"]:
                last = state
            if state["s"] - last["s"] > PATIENCE:
                core.kill()
                raise Failed(f"nothing moves for {PATIENCE:.0f} s of the board's clock, after {state['edges']} steps")
        reader.join()
        expect(core.returncode == 0, f"printcore: {' '.join(said).strip()[-300:]}")
        found = end(bench, name, board, guest)
        steps = compare(found, wanted)
        with open(part) as file:
            lines = sum(1 for line in file if line.split(";")[0].strip())
        stood = f"; {stalls} stalls of {STALL * 1000:.0f} ms" if stall else ""
        return (f"{os.path.basename(part)}, all {lines} lines: {said[-1].strip()}{stood}; {steps} as from the card, "
                f"in {duration(found):.0f} s from the first to the last (from the card {duration(wanted):.0f} s)")
    finally:
        board.close()
        # What holds the port open would keep its name from the next board's.
        guest.run("killall cat")


@case("print: printcore over /dev/ttyACM0")
def printcore(bench):
    return stream(bench, "printcore", os.path.join(ROOT, "demo/part.gcode"), stall=False)


@case("print: printcore, and a computer with stalls of 40 ms")
def stalls(bench):
    return stream(bench, "stalls", job(bench, STREAM_LAYERS), stall=True)
