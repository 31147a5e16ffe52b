"""The machine's own functions at a real Linux."""

import re

from bench import case, clean, expect, plug
from cases_echo import verbose

DEVICE = "1d50:6015"


def ask(guest, port, line, end="ok", seconds=60):
    """Opens a port, is greeted, says a line, and gives what is heard up to a line that begins with `end`: some commands of
    Smoothieware's give what was asked for and no ok."""
    heard = guest.do(f"exec 5<>{port}; s=; while read -r -t {seconds} l <&5; do echo \"$l\"; case $s$l in ok*) s=said; echo '{line}' >&5;; \"said{end}\"*) break;; esac; done",
                     seconds + 60)
    greeting, _, answer = heard.partition("ok\n")
    expect("Welcome" in greeting and answer.rstrip().rpartition("\n")[2].startswith(end), f"{line} is answered by {heard!r}")
    return answer


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


# Class, subclass and protocol of each interface with its endpoints: what docs/usb.md promises.
INTERFACES = [
    ((2, 2, 0), (0x82,)), ((10, 0, 0), (0x81, 0x01)),  # the console
    ((2, 2, 0), (0x84,)), ((10, 0, 0), (0x83, 0x02)),  # the second console
    ((8, 6, 80), (0x85, 0x03)),  # the card, SCSI by bulk only
    ((254, 1, 1), ()),  # the way to the firmware download
]
TEXTS = {"iManufacturer": "Velvet", "iProduct": "Smoothieboard v2 Prime"}


def interfaces(said):
    """The interfaces in what lsusb said, as in the table."""
    found = []
    for part in re.split(r"^    Interface Descriptor:", said, flags=re.M)[1:]:
        number = lambda name: int(re.search(rf"{name} +(\d+)", part).group(1))
        kind = number("bInterfaceClass"), number("bInterfaceSubClass"), number("bInterfaceProtocol")
        found.append((kind, tuple(int(one, 16) for one in re.findall(r"bEndpointAddress +0x(\w\w)", part))))
    return found


@case("board: lsusb -v")
def listed(bench):
    guest, board = bench.guest(), bench.board("lsusb")
    try:
        plug(guest, board)
        said = verbose(guest, DEVICE)
        found = interfaces(said)
        expect(found == INTERFACES, f"the interfaces are {found}")
        for name, text in TEXTS.items():
            expect(re.search(rf"{name} +\d+ {text}$", said, re.M), f"{name} is not {text}")
        expect(re.search(r"iSerial +\d+ [0-9A-F]{24}$", said, re.M), "the serial number is not the chip's")
        drivers = guest.do("for i in /sys/bus/usb/devices/?-[1-9]*:*; do basename $(readlink $i/driver || echo none); done").split()
        expect(drivers == ["cdc_acm"] * 4 + ["usb-storage", "none"], f"the drivers are {drivers}")
        clean(guest)
        return f"{len(said.splitlines())} lines of {len(found)} interfaces without a warning; drivers {', '.join(dict.fromkeys(drivers[:-1]))}"
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
