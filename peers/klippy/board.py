"""A board on the desk: the virtual one with its machine, and the line between its serial port and the host's."""

import errno
import json
import os
import pty
import select
import selectors
import socket
import struct
import subprocess
import threading
import time
import tty

# A record of the log of the line: the computer's time, what it is, how many bytes follow.
RECORD = struct.Struct("<dBI")
TO_BOARD, FROM_BOARD, BOARD_TIME = range(3)
ASKED_EVERY_S = 0.05
PIECE = 4096
# Longest that a board may need to end once nobody listens, in seconds of this computer.
END_S = 90


def read_log(path):
    """The records of a line: time, kind and bytes. Of `BOARD_TIME` the bytes are the seconds since power-on."""
    with open(path, "rb") as file:
        while len(head := file.read(RECORD.size)) == RECORD.size:
            at, kind, count = RECORD.unpack(head)
            yield at, kind, file.read(count)


class Log:
    """What has passed on a line, and the board's time now and then."""

    def __init__(self, path):
        self.file = open(path, "wb")
        self.lock = threading.Lock()

    def write(self, kind, data):
        with self.lock:
            if not self.file.closed:
                self.file.write(RECORD.pack(time.monotonic(), kind, len(data)) + data)

    def close(self):
        with self.lock:
            self.file.close()


class Line:
    """A terminal that a host opens as a serial port, and the TCP port of the board's UART at its other end."""

    def __init__(self, address, link, log):
        self.log = log
        self.tcp = socket.create_connection(address)
        self.tcp.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        # The far side stays open, so that the line outlives a host that closes it.
        self.near, self.far = pty.openpty()
        tty.setraw(self.far)
        os.set_blocking(self.near, False)
        self.link = link
        if os.path.islink(link):
            os.unlink(link)
        os.symlink(os.ttyname(self.far), link)
        self.is_open = True
        self.thread = threading.Thread(target=self.serve, daemon=True)
        self.thread.start()

    def serve(self):
        selector = selectors.DefaultSelector()
        selector.register(self.near, selectors.EVENT_READ)
        selector.register(self.tcp, selectors.EVENT_READ)
        while self.is_open:
            for key, _ in selector.select(0.2):
                try:
                    (self.to_board if key.fileobj == self.near else self.from_board)()
                except (BrokenPipeError, ConnectionError):
                    return

    def to_board(self):
        try:
            data = os.read(self.near, PIECE)
        except BlockingIOError:
            return
        self.log.write(TO_BOARD, data)
        self.tcp.sendall(data)

    def from_board(self):
        data = self.tcp.recv(PIECE)
        if not data:
            raise ConnectionError
        self.log.write(FROM_BOARD, data)
        try:
            os.write(self.near, data)
        except OSError as error:
            # A host that does not read loses bytes, as on a wire.
            if error.errno not in (errno.EAGAIN, errno.EIO):
                raise

    def close(self):
        self.is_open = False
        self.thread.join()
        for end in (self.near, self.far):
            os.close(end)
        self.tcp.close()
        if os.path.islink(self.link):
            os.unlink(self.link)


class Watch:
    """Asks the machine's true state."""

    def __init__(self, address, log):
        self.asking = socket.create_connection(address)
        self.answers = self.asking.makefile("r")
        self.lock = threading.Lock()
        self.log = log
        self.is_open = True
        self.thread = threading.Thread(target=self.follow, daemon=True)
        self.thread.start()

    def state(self):
        with self.lock:
            self.asking.sendall(b"\n")
            line = self.answers.readline()
        if not line:
            raise ConnectionError("the board has ended")
        return json.loads(line)

    def follow(self):
        while self.is_open:
            try:
                self.log.write(BOARD_TIME, struct.pack("<d", self.state()["s"]))
            except (OSError, ValueError):
                return
            time.sleep(ASKED_EVERY_S)

    def close(self):
        self.is_open = False
        self.thread.join()
        self.asking.close()


class Board:
    """A board that runs, with everything it leaves in `folder`."""

    def __init__(self, command, folder, name="prime"):
        os.makedirs(folder, exist_ok=True)
        self.folder, self.name = folder, name
        self.said = open(os.path.join(folder, "board.log"), "w")
        self.process = subprocess.Popen(
            [*command, "--out", folder], stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=False
        )
        self.addresses = {}
        self.are_known = threading.Event()
        self.threads = [threading.Thread(target=work, daemon=True) for work in (self.hear, self.drain)]
        self.listening = True
        for thread in self.threads:
            thread.start()
        if not self.are_known.wait(120) or self.process.poll() is not None:
            raise RuntimeError(f"the board has not started: see {folder}/board.log")
        self.log = Log(os.path.join(folder, "wire.bin"))
        self.watch = Watch(self.addresses["the machine's state"], self.log)
        self.line = Line(self.addresses["debug (USART2)"], os.path.join(folder, "serial"), self.log)

    @property
    def serial(self):
        return self.line.link

    def hear(self):
        for raw in self.process.stderr:
            text = raw.decode(errors="replace")
            self.said.write(text)
            self.said.flush()
            name, found, address = text.strip().partition(" on tcp ")
            if found:
                host, port = address.rsplit(":", 1)
                self.addresses[name] = (host, int(port))
            if "debug (USART2)" in self.addresses and "the machine's state" in self.addresses:
                self.are_known.set()
        self.are_known.set()

    def drain(self):
        """The debug port's bytes come here as well; that nobody takes them any more ends the board."""
        out = self.process.stdout.fileno()
        while self.listening:
            if select.select([out], [], [], 0.2)[0] and not os.read(out, PIECE):
                break
        self.process.stdout.close()

    def wait_for_pace(self, pace, limit_s=300):
        """Waits until the board keeps its pace: at first its code has to be translated."""
        deadline = time.monotonic() + limit_s
        while time.monotonic() < deadline:
            began, at = time.monotonic(), self.watch.state()["s"]
            time.sleep(1.0)
            rate = (self.watch.state()["s"] - at) / (time.monotonic() - began)
            if abs(rate / pace - 1) < 0.05:
                return
        raise RuntimeError(f"the board does not keep a pace of {pace}")

    def close(self):
        self.line.close()
        self.watch.close()
        self.log.close()
        # A board ends when nobody takes its words any more; one that says nothing, when its input ends.
        self.listening = False
        try:
            self.process.stdin.close()
        except BrokenPipeError:
            # It has died before.
            pass
        try:
            self.process.wait(END_S)
        except subprocess.TimeoutExpired:
            self.process.kill()
            self.process.wait()
        self.said.close()
