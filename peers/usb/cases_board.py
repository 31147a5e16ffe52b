"""The machine's own functions at a real Linux."""

import re

from bench import case, clean, expect, plug
from cases_echo import verbose

DEVICE = "1d50:6015"


def ask(guest, port, line, seconds=2):
    """Says a line on a port that is open, and what is heard until then."""
    return guest.do(f"(sleep 0.3; echo '{line}' > {port}) & timeout {seconds} cat {port}; true", 60)


@case("board: both serial ports")
def ports(bench):
    guest, board = bench.guest(), bench.board("ports")
    try:
        seconds = plug(guest, board, "/dev/ttyACM1")
        guest.do("stty -F /dev/ttyACM0 raw -echo; stty -F /dev/ttyACM1 raw -echo")
        for port in ("/dev/ttyACM0", "/dev/ttyACM1"):
            heard = ask(guest, port, "M115")
            expect("Velvet" in heard, f"{port}: M115 is answered by {heard!r}")
        # A move on one, and where it went on the other.
        begin = board.state()["tool"]
        ask(guest, "/dev/ttyACM0", "G1 X7 F3000")
        board.at((begin[0] + 7, begin[1], begin[2]), 30)
        heard = ask(guest, "/dev/ttyACM1", "M114")
        expect("X:7.0000" in heard, f"M114 on the second port: {heard!r}")
        clean(guest)
        return f"both answer, {seconds:.1f} s after the cable went in; a move of the one is seen on the other"
    finally:
        board.close()


@case("board: lsusb -v")
def listed(bench):
    guest, board = bench.guest(), bench.board("lsusb")
    try:
        plug(guest, board)
        said = verbose(guest, DEVICE)
        interfaces = len(re.findall(r"bInterfaceNumber", said))
        serial = re.search(r"iSerial +\d+ (\S+)", said)
        expect(serial, "it has no serial number")
        clean(guest)
        return f"{len(said.splitlines())} lines of {interfaces} interfaces without a warning"
    finally:
        board.close()


@case("board: the kernel's usbip")
def kernel_usbip(bench):
    guest, board = bench.guest(), bench.board("usbip")
    try:
        port = board.usb_ports[1]
        guest.do("for m in $(cat /modules/later); do [ -d /sys/module/$m ] || insmod /modules/$m; done")
        guest.do(f"usbip --tcp-port {port} attach -r 10.0.2.2 -b 1-1")
        guest.wait("[ -c /dev/ttyACM1 ]", 60)
        guest.do("stty -F /dev/ttyACM0 raw -echo")
        heard = ask(guest, "/dev/ttyACM0", "M115")
        expect("Velvet" in heard, f"M115 is answered by {heard!r}")
        guest.do("usbip detach -p 00")
        guest.wait("[ ! -c /dev/ttyACM0 ]")
        return "attached, asked, detached"
    finally:
        board.close()
