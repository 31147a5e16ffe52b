"""The plug itself, tried on a serial port made of other people's crates: the virtual board's image `usb_echo`."""

import os
import random
import subprocess
import sys
import time

from bench import Failed, Skipped, case, clean, expect, plug

# The crate `usb-device` announces USB 2.1 with an extension of 2.0 and without what comes with that.
OTHERS = ("(Missing must-be-set LPM bit!)",)
BYTES = 65536
TEXT = bytes(97 + index % 26 for index in range(BYTES))


def verbose(guest, device, known=()):
    """`lsusb -v`, without a warning but for what is known and not ours."""
    said = guest.do(f"lsusb -v -d {device} 2> /tmp/warnings")
    warnings = guest.do("cat /tmp/warnings")
    expect(not warnings, f"lsusb -v warns: {warnings}")
    # What lsusb finds wrong with a descriptor it says in brackets.
    amiss = [line.strip() for line in said.splitlines() if "missing" in line.lower() or "warning" in line.lower() or "unrecognized" in line.lower() or "invalid" in line.lower()]
    amiss = [line for line in amiss if line not in known]
    expect(not amiss, f"lsusb -v says: {' | '.join(amiss)}")
    return said


@case("plug: another image enumerates")
def enumerates(bench):
    guest, board = bench.guest(), bench.board("echo", echo=True)
    try:
        seconds = plug(guest, board)
        clean(guest)
        said = verbose(guest, "16c0:27dd", OTHERS)
        expect("Echo" in said and "CDC ACM" in said, "it is not the image's device")
        return f"/dev/ttyACM0 after {seconds:.1f} s; lsusb -v of {len(said.splitlines())} lines without a warning"
    finally:
        board.close()


def echo(guest, count):
    """So many bytes there and back at once; the seconds of the board's clock are the caller's to measure."""
    guest.do(f"head -c {count} /share/text > /tmp/text; stty -F /dev/ttyACM0 raw -echo")
    guest.do(f"(head -c {count} < /dev/ttyACM0 > /tmp/back) & cat /tmp/text > /dev/ttyACM0; wait", 600)
    sums = guest.do("tr a-z A-Z < /tmp/text | md5sum; md5sum < /tmp/back").splitlines()
    expect(sums[0] == sums[1], "other bytes came back")


@case("plug: 64 KiB there and back")
def echoes(bench):
    guest, board = bench.guest(), bench.board("echo", echo=True)
    try:
        with open(os.path.join(guest.share, "text"), "wb") as file:
            file.write(TEXT)
        plug(guest, board)
        began = board.state()["s"]
        echo(guest, BYTES)
        seconds = board.state()["s"] - began
        clean(guest)
        return f"{BYTES / seconds / 1000:.0f} kB/s of the board's time, both ways at once"
    finally:
        board.close()


@case("plug: opened and closed 40 times")
def opens(bench):
    """Each close cancels the sixteen reads that cdc_acm has under way."""
    guest, board = bench.guest(), bench.board("echo", echo=True)
    try:
        plug(guest, board)
        guest.do("stty -F /dev/ttyACM0 raw -echo; n=0; while [ $n -lt 40 ]; do : < /dev/ttyACM0; n=$((n+1)); done", 300)
        echo(guest, 30 * 64)
        clean(guest)
        return "and 30 packets there and back after that"
    finally:
        board.close()


@case("plug: out and in 30 times")
def replugs(bench):
    draw = random.Random(1)
    guest, board = bench.guest(), bench.board("echo", echo=True)
    try:
        for _ in range(30):
            plug(guest, board)
            guest.do("stty -F /dev/ttyACM0 raw -echo; (cat /dev/zero > /dev/ttyACM0 2> /dev/null; cat /dev/ttyACM0 > /dev/null 2>&1) &")
            time.sleep(draw.uniform(0, 0.3))
            guest.unplug()
            guest.wait("[ ! -c /dev/ttyACM0 ]")
        guest.messages()
        seconds = plug(guest, board)
        clean(guest)
        guest.wait("! pidof cat")
        return f"in the middle of traffic; the last time /dev/ttyACM0 after {seconds:.1f} s"
    finally:
        board.close()


@case("plug: the kernel's usbip")
def kernel_usbip(bench):
    guest, board = bench.guest(), bench.board("echo", echo=True)
    try:
        port = board.usb_ports[1]
        guest.do("for m in $(cat /modules/later); do [ -d /sys/module/$m ] || insmod /modules/$m; done")
        listed = guest.do(f"usbip --tcp-port {port} list -r 10.0.2.2")
        expect("1-1" in listed and "16c0:27dd" in listed, f"usbip list: {listed}")
        guest.do(f"usbip --tcp-port {port} attach -r 10.0.2.2 -b 1-1")
        guest.wait("[ -c /dev/ttyACM0 ]", 60)
        echo(guest, 30 * 64)
        verbose(guest, "16c0:27dd", OTHERS)
        guest.do("usbip detach -p 00")
        guest.wait("[ ! -c /dev/ttyACM0 ]")
        return "listed, attached, 30 packets there and back, detached"
    finally:
        board.close()


@case("plug: PyUSB over usbip, without a guest")
def pyusb(bench):
    from pyusb_peer import environment

    board = bench.board("echo", echo=True)
    try:
        python = environment(bench.tools)
        script = os.path.join(os.path.dirname(os.path.abspath(__file__)), "pyusb_peer.py")
        said = subprocess.run([python, script, str(board.usb_ports[1])], capture_output=True, text=True, timeout=600)
        if said.returncode:
            raise Failed(said.stderr.strip().splitlines()[-1] if said.stderr else f"exit code {said.returncode}")
        return said.stdout.strip()
    except (subprocess.CalledProcessError, OSError) as error:
        raise Skipped(f"PyUSB cannot be installed: {error}") from None
    finally:
        board.close()
