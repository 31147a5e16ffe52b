"""A virtual board for a sender to talk to, and an onlooker who sees what its machine really does.

Waiting is measured by the board's clock wherever it can be: on a busy computer it runs slower than ours.
"""

import json
import os
import pty
import re
import select
import socket
import subprocess
import sys
import threading
import time
import tty

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
# No wait is longer, seconds of this computer's clock.
PATIENCE = 600.0


class Failed(Exception):
    """A step that did not do what it should."""


# Consoles over the network as senders want them, and what leads to them without any rights.
NETWORK = "\n[network]\nenable = true\nshell_enable = true\ngrbl_enable = true\npassword_required = false\n"
TELNET, GRBL = 23, 2323
NETWORK_ARGUMENTS = ["--net", "--telnet-port", str(TELNET), "--telnet-port", str(GRBL)]


def with_network(config, out, name, section=NETWORK):
    """A copy of this configuration with a network, as a file."""
    path = os.path.join(out, f"{name}.ini")
    with open(config) as plain, open(path, "w") as copy:
        copy.write(plain.read() + section)
    return path


class Board:
    """An image on the virtual board, from power-on: ours, unless another one is named."""

    def __init__(self, config, out, name, elf=None, arguments=()):
        self.log = open(os.path.join(out, f"{name}.board.log"), "w")
        elf = elf or os.path.join(ROOT, "target/thumbv7em-none-eabihf/release/firmware")
        program = os.path.join(ROOT, "virtual-prime/target/release/virtual-prime")
        command = [program, "console", "--elf", elf, *(["--config", config] if config else ["--foreign"]), "--state-port", "0", *arguments]
        self.process = subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
        self.wires = []
        self.port = self._port(r"debug \(USART2\) on tcp .*:(\d+)")
        state_port = self._port(r"the machine's state on tcp .*:(\d+)")
        self.usb_ports = tuple(self._port(rf"USB by {name} on tcp .*?:(\d+)") for name in ("usbredir", "usbip")) if "--usb" in arguments else None
        # Ports of this computer by those of the board that they lead to, in the order of the arguments.
        self.net_ports = {int(to): self._port(rf"the board's port {to}: telnet \S+ (\d+)") for option, to in zip(arguments, arguments[1:]) if option == "--telnet-port"}
        threading.Thread(target=self._keep_log, daemon=True).start()
        self.state_socket = socket.create_connection(("127.0.0.1", state_port))
        self.state_lines = self.state_socket.makefile("r")
        # What comes before its consoles are up is lost, as on a real board.
        self.until("boot", lambda state: state["s"] > 3.0, board_seconds=4.0)

    def _port(self, pattern):
        for line in self.process.stderr:
            self.log.write(line)
            found = re.search(pattern, line)
            if found:
                return int(found.group(1))
        raise Failed("the virtual board does not start: see its log")

    def _keep_log(self):
        for line in self.process.stderr:
            self.log.write(line)
            self.log.flush()

    def state(self, first=""):
        """What the machine does: s, tool, carriages, edges, heaters."""
        self.state_socket.sendall(f"{first}\n".encode())
        line = self.state_lines.readline()
        if not line:
            raise Failed("the virtual board has ended: see its log")
        return json.loads(line)

    def unplug(self):
        """Pulls the USB cable out, which the computer only learns by it. The state then."""
        return self.state("unplug")

    def until(self, what, condition, board_seconds=60.0):
        """Waits for a state of the machine, so many seconds of the board's clock."""
        began, start = time.monotonic(), None
        while True:
            state = self.state()
            start = state["s"] if start is None else start
            if condition(state):
                return state
            if state["s"] - start > board_seconds or time.monotonic() - began > PATIENCE:
                raise Failed(f"{what}: not after {state['s'] - start:.1f} s of the board's clock; the tool is at {state['tool']}")
            time.sleep(0.02)

    def at(self, place, board_seconds=60.0):
        """Waits until the tool rests at this place."""
        near = lambda state: all(p is None or abs(p - t) < 0.05 for p, t in zip(place, state["tool"]))
        self.until(f"tool at {place}", near, board_seconds)
        state = self.rest(board_seconds)
        if not near(state):
            raise Failed(f"the tool went on to {state['tool']}, away from {place}")
        return state

    def rest(self, board_seconds=60.0, still=0.5):
        """Waits until no step has been made for this long."""
        last = [self.state()]

        def rests(state):
            if state["edges"] != last[0]["edges"]:
                last[0] = state
            return state["s"] - last[0]["s"] >= still

        return self.until("rest", rests, board_seconds)

    def moving(self, board_seconds=20.0):
        """Waits until steps are made."""
        edges = self.state()["edges"]
        return self.until("motion", lambda state: state["edges"] > edges + 50, board_seconds)

    def speed(self, board_seconds=0.5):
        """Steps a second over some time: what an override must change."""
        first = self.state()
        last = self.until("time", lambda state: state["s"] >= first["s"] + board_seconds, board_seconds + 5)
        return (last["edges"] - first["edges"]) / (last["s"] - first["s"])

    def talk(self):
        """A wire that keeps what passes in the log, for senders on TCP."""
        wire = Wire(self, self.port, pseudo_terminal=False)
        self.wires.append(wire)
        return wire

    def terminal(self):
        """A pseudo-terminal, for senders that want a serial port."""
        wire = Wire(self, self.port, pseudo_terminal=True)
        self.wires.append(wire)
        return wire

    def network(self, port):
        """The same as `talk`, to a port of the board in its own network."""
        wire = Wire(self, self.net_ports[port], pseudo_terminal=False)
        self.wires.append(wire)
        return wire

    def end(self):
        """Lets the board come to its end, so that it leaves its files."""
        self.process.stdin.close()
        self.process.wait(PATIENCE)

    def close(self):
        for wire in self.wires:
            wire.close()
        self.process.kill()
        self.process.wait()
        self.log.close()


class Wire:
    """Between a sender and a console's port on this computer, with a log of every line both ways."""

    def __init__(self, board, board_port, pseudo_terminal):
        self.board, self.board_port, self.open = board, board_port, True
        self.listener = None
        if pseudo_terminal:
            self.end, self.slave = pty.openpty()
            tty.setraw(self.slave)
            self.path = os.ttyname(self.slave)
        else:
            self.listener = socket.create_server(("127.0.0.1", 0))
            self.port = self.listener.getsockname()[1]
            self.path = f"127.0.0.1:{self.port}"
        self.said = {">": b"", "<": b""}
        self.heard = []
        threading.Thread(target=self._run, daemon=True).start()

    def _run(self):
        while self.open:
            try:
                if self.listener:
                    client, _ = self.listener.accept()
                    client.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
                    read, write, number = (lambda: client.recv(4096)), client.sendall, client.fileno()
                else:
                    read, write, number = (lambda: os.read(self.end, 4096)), (lambda data: os.write(self.end, data)), self.end
                board = socket.create_connection(("127.0.0.1", self.board_port))
                board.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
                self._pass(read, write, number, board)
                board.close()
            except OSError:
                continue

    def _pass(self, read, write, number, board):
        while self.open:
            ready, _, _ = select.select([number, board], [], [], 0.5)
            if number in ready:
                data = read()
                if not data:
                    return
                self._note(">", data)
                board.sendall(data)
            if board in ready:
                data = board.recv(4096)
                if not data:
                    return
                self._note("<", data)
                write(data)

    def _note(self, way, data):
        self.said[way] += data
        *whole, self.said[way] = self.said[way].split(b"\n")
        for line in whole:
            if way == "<":
                self.heard.append(line.decode("latin-1").rstrip())
            self.board.log.write(f"{way} {line.decode('latin-1').rstrip()}\n")
        # Bytes that act at once end no line.
        for byte in data:
            if byte >= 0x80 or byte in b"\x18!~":
                self.board.log.write(f"{way} byte {byte:#x}\n")
        self.board.log.flush()

    def replies(self):
        """Every line that the board has said on this wire."""
        return self.heard

    def close(self):
        self.open = False
        if self.listener:
            self.listener.close()


class Steps:
    """What a sender was asked to do, and what came of it."""

    def __init__(self, sender):
        self.sender, self.rows = sender, []

    def step(self, name, action):
        """One step: its result is a note for the table, or it raises [`Failed`]."""
        try:
            note, passed = action() or "", True
        except Failed as reason:
            note, passed = str(reason), False
        except Exception as error:  # a sender's own, or this script's
            note, passed = f"{type(error).__name__}: {error}", False
        self.rows.append({"sender": self.sender, "step": name, "passed": passed, "note": note})
        print(f"{self.sender:22} {name:10} {'ok' if passed else 'FAILED':7} {note}", flush=True)
        return passed


def zigzag(turns, feed, low=20.0, high=60.0, down=None):
    """A job of many short moves: it ends at (low, low + turns * 0.5)."""
    lines = ["G21", "G90", f"G0 X{low} Y{low}" + (f" Z{down}" if down is not None else "")]
    for turn in range(turns):
        y = low + turn * 0.5
        for part in range(1, 5):
            lines.append(f"G1 X{low + (high - low) * part / 4:.3f} Y{y:.3f} F{feed}")
        for part in range(3, -1, -1):
            lines.append(f"G1 X{low + (high - low) * part / 4:.3f} Y{y + 0.5:.3f}")
    return lines, (low, low + turns * 0.5, None)


def between(value, low, high, what):
    if not low <= value <= high:
        raise Failed(f"{what} is {value:.3g}, not from {low} to {high}")


def main(run):
    """OUT NAME WHERE: runs one sender, and leaves its rows in OUT/NAME.json."""
    out, name, where = sys.argv[1:]
    rows = run(name, out, where)
    with open(os.path.join(out, f"{name}.json"), "w") as file:
        json.dump(rows, file)
