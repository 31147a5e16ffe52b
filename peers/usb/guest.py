"""A Linux in QEMU that can plug the board in, and does what it is told."""

import json
import os
import re
import socket
import subprocess
import tempfile
import threading
import time

# No answer takes longer, seconds.
PATIENCE = 120.0


class GuestError(Exception):
    """The guest did not do what it was told, or the command failed."""


class Lines:
    """A socket that is read line by line, with a time limit."""

    def __init__(self, path):
        self.socket = socket.socket(socket.AF_UNIX)
        deadline = time.monotonic() + 20
        while True:
            try:
                self.socket.connect(path)
                break
            except OSError:
                if time.monotonic() > deadline:
                    raise
                time.sleep(0.05)
        self.rest = b""

    def send(self, text):
        self.socket.sendall(text.encode())

    def line(self, seconds):
        deadline = time.monotonic() + seconds
        while b"\n" not in self.rest:
            self.socket.settimeout(max(deadline - time.monotonic(), 0.001))
            try:
                more = self.socket.recv(65536)
            except TimeoutError:
                raise GuestError(f"no answer within {seconds:.0f} s") from None
            if not more:
                raise GuestError("QEMU has ended: see vm.console")
            self.rest += more
        line, self.rest = self.rest.split(b"\n", 1)
        return line.decode("utf-8", "replace").rstrip("\r")


class Guest:
    """Boots at once; `with Guest(...) as guest:` ends it."""

    def __init__(self, kernel, initrd, out, name="vm"):
        self.share = os.path.join(out, "share")
        os.makedirs(self.share, exist_ok=True)
        self.folder = tempfile.mkdtemp(prefix="velvet-usb-")
        self.console = os.path.join(out, f"{name}.console")
        self.plugged, self.number, self.chardevs = None, 0, 0
        at = lambda end: os.path.join(self.folder, end)
        command = [
            "qemu-system-x86_64", "-M", "q35,accel=tcg", "-cpu", "qemu64", "-smp", "1", "-m", "256", "-nodefaults", "-no-user-config", "-display", "none", "-no-reboot",
            "-kernel", kernel, "-initrd", initrd, "-append", "console=ttyS0 quiet panic=-1 random.trust_cpu=on", "-serial", f"file:{self.console}",
            "-device", "virtio-serial-pci", "-chardev", f"socket,id=ag,path={at('agent')},server=on,wait=off", "-device", "virtserialport,chardev=ag,name=agent",
            "-chardev", "pty,id=tty", "-device", "virtserialport,chardev=tty,name=serial", "-qmp", f"unix:{at('qmp')},server=on,wait=off",
            "-fsdev", f"local,id=f0,path={self.share},security_model=none", "-device", "virtio-9p-pci,fsdev=f0,mount_tag=host",
            "-netdev", "user,id=n0,restrict=off", "-device", "virtio-net-pci,netdev=n0,romfile=", "-device", "qemu-xhci,id=xhci",
        ]
        self.log = open(os.path.join(out, f"{name}.qemu"), "w")
        self.process = subprocess.Popen(command, stdin=subprocess.DEVNULL, stdout=self.log, stderr=self.log)
        self.lock = threading.Lock()
        self.monitor, self.agent = Lines(at("qmp")), Lines(at("agent"))
        self.monitor.line(20)
        self.qmp("qmp_capabilities")
        began = time.monotonic()
        while self.agent.line(PATIENCE) != "@ready":
            pass
        self.boot_seconds = time.monotonic() - began
        [self.terminal] = [one["filename"].removeprefix("pty:") for one in self.qmp("query-chardev") if one["label"] == "tty"]

    @staticmethod
    def version():
        """QEMU's."""
        said = subprocess.run(["qemu-system-x86_64", "--version"], capture_output=True, text=True, check=True).stdout
        return re.search(r"version (\S+)", said).group(1)

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.process.kill()
        self.process.wait()
        self.log.close()

    def qmp(self, command, **arguments):
        """One command of QEMU's monitor; what it gives back."""
        with self.lock:
            self.monitor.send(json.dumps({"execute": command, "arguments": arguments}) + "\n")
            while True:
                answer = json.loads(self.monitor.line(PATIENCE))
                if "return" in answer:
                    return answer["return"]
                if "error" in answer:
                    raise GuestError(f"{command}: {answer['error']['desc']}")

    def run(self, line, seconds=PATIENCE):
        """A line for the guest's shell: its exit code and what it said."""
        self.number += 1
        self.agent.send(f"{self.number} {line}\n")
        said = []
        while True:
            answer = self.agent.line(seconds)
            if match := re.fullmatch(rf"@{self.number} (\d+)", answer):
                return int(match.group(1)), "\n".join(said).rstrip("\n")
            if not re.fullmatch(r"@\d+ \d+", answer):
                said.append(answer)

    def do(self, line, seconds=PATIENCE):
        """The same; it has to succeed."""
        code, said = self.run(line, seconds)
        if code:
            raise GuestError(f"{line}: exit code {code}: {said[-500:]}")
        return said

    def wait(self, condition, seconds=30.0):
        """Waits until a condition of the guest's shell holds; how long that took."""
        began = time.monotonic()
        tenths = int(seconds * 10)
        self.do(f"n=0; until {condition}; do n=$((n+1)); [ $n -lt {tenths} ] || exit 1; sleep 0.1; done", seconds * 3 + 30)
        return time.monotonic() - began

    def plug(self, port):
        """Plugs in the board that is offered on this port of the host."""
        self.chardevs += 1
        name = f"usb{self.chardevs}"
        address = {"type": "inet", "data": {"host": "127.0.0.1", "port": str(port)}}
        self.qmp("chardev-add", id=name, backend={"type": "socket", "data": {"addr": address, "server": False, "nodelay": True}})
        self.qmp("device_add", driver="usb-redir", id=f"board-{name}", chardev=name, bus="xhci.0", debug=2)
        self.plugged = f"board-{name}"

    def unplug(self):
        """Pulls the cable out."""
        if self.plugged:
            self.qmp("device_del", id=self.plugged)
            self.plugged = None

    def stall(self, seconds):
        """The computer stands still for so long."""
        self.qmp("stop")
        time.sleep(seconds)
        self.qmp("cont")

    def messages(self):
        """What the kernel has said since the last call."""
        return self.do("dmesg -c")
