"""What the cases share: a guest, boards, and a list of the cases with what came of each."""

import os
import sys
import time

HERE = os.path.dirname(os.path.abspath(__file__))
sys.path.insert(0, os.path.join(os.path.dirname(HERE), "senders"))

import parts
from board import ROOT, Board, Failed
from guest import Guest, GuestError

# What another firmware's serial port is called, as in the virtual board's own tests.
ECHO = os.path.join(ROOT, "virtual-prime/target/images/thumbv7em-none-eabihf/release/usb_echo")
FIRMWARE = os.path.join(ROOT, "target/thumbv7em-none-eabihf/release/firmware")
MACHINE = os.path.join(ROOT, "config/samples/cartesian.ini")

# All that the socket can be.
SETTINGS = {("consoles", "second_usb_serial_enable"): "true", ("system", "msc_enable"): "true", ("system", "dfu_enable"): "true"}

CASES = []


class Skipped(Exception):
    """A case that cannot be tried here, and why."""


def case(name):
    """Enters a case: a function of the bench that gives a figure, or raises."""
    def enter(function):
        CASES.append((name, function))
        return function
    return enter


class Bench:
    """Lends out what is made once."""

    def __init__(self, tools, out, firmware):
        self.tools, self.out, self.firmware = tools, out, firmware
        self.versions, self._guest, self.boards = {}, None, 0

    def guest(self):
        """The guest, booted at the first call; its messages so far are gone."""
        if self._guest is None:
            try:
                kernel, initrd, self.versions = parts.prepare(os.path.join(self.tools, "usb"))
            except parts.Missing as missing:
                raise Skipped(f"wants {missing}") from None
            self.versions = {"QEMU": Guest.version(), **self.versions}
            self._guest = Guest(kernel, initrd, self.out)
        self._guest.unplug()
        self._guest.messages()
        return self._guest

    def drop_guest(self):
        """The next case has a guest of its own."""
        if self._guest is not None:
            self._guest.__exit__()
            self._guest = None

    def config(self, settings=None):
        """The sample machine with other settings, as a file."""
        path = os.path.join(self.out, "machine.ini")
        with open(MACHINE) as sample:
            lines = sample.read().splitlines()
        for (section, key), value in (settings or {}).items():
            head = f"[{section}]"
            begin = lines.index(head) + 1 if head in lines else len(lines) + 1
            lines += [] if head in lines else [head]
            end = next((at for at in range(begin, len(lines)) if lines[at].startswith("[")), len(lines))
            lines[begin:end] = [f"{key} = {value}"] + [line for line in lines[begin:end] if line.split("=")[0].strip() != key]
        with open(path, "w") as file:
            file.write("\n".join(lines) + "\n")
        return path

    def board(self, name, settings=SETTINGS, echo=False, sd=None, files=False):
        """A board from power-on, with its socket offered. `files`: it leaves every step in the folder of this name."""
        arguments = ["--usb", "--usbredir-port", "0", "--usbip-port", "0"]
        if sd:
            arguments += ["--sd", sd]
        if files:
            arguments += ["--out", os.path.join(self.out, name)]
        if echo:
            return Board(None, self.out, name, ECHO, arguments)
        if not os.path.exists(self.firmware):
            raise Skipped(f"there is no image {self.firmware}: make firmware")
        return Board(self.config(settings), self.out, name, self.firmware, arguments)

    def close(self):
        if self._guest is not None:
            self._guest.__exit__()


def expect(is_so, words):
    if not is_so:
        raise Failed(words)


def plug(guest, board, device="/dev/ttyACM0"):
    """Plugs in and waits for a device file; how long that took, seconds of this computer's clock."""
    began = time.monotonic()
    guest.plug(board.usb_ports[0])
    try:
        guest.wait(f"[ -c {device} ] || [ -b {device} ]", 60)
    except GuestError:
        said = guest.run("ls /dev/ttyACM* /dev/sd*; ps | grep -v '\\]$'; dmesg | tail -20")[1]
        raise Failed(f"{device} does not appear: {said}") from None
    return time.monotonic() - began


def clean(guest):
    """The kernel's messages since the last look, with nothing amiss among them."""
    said = guest.messages()
    amiss = [line for line in said.splitlines() if any(word in line.lower() for word in ("error", "fail", "reset ", "timeout", "timed out", "not accept", "unable", "stall"))]
    expect(not amiss, f"the kernel says: {' | '.join(amiss[:3])}")
    return said
