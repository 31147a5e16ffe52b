"""Klipper's host program, unmodified, and its API socket."""

import itertools
import json
import os
import queue
import shutil
import signal
import socket
import subprocess
import sys
import tempfile
import threading
import time

END = b"\x03"


class Refused(Exception):
    """The host has answered with an error."""


class Api:
    """A connection to the host's socket."""

    def __init__(self, path, limit_s=30):
        deadline = time.monotonic() + limit_s
        while True:
            self.socket = socket.socket(socket.AF_UNIX)
            try:
                self.socket.connect(path)
                break
            except OSError:
                self.socket.close()
                if time.monotonic() > deadline:
                    raise
                time.sleep(0.1)
        self.numbers = itertools.count(1)
        self.waiting = {}
        self.lock = threading.Lock()
        self.thread = threading.Thread(target=self.hear, daemon=True)
        self.thread.start()

    def hear(self):
        held = b""
        try:
            while data := self.socket.recv(65536):
                *whole, held = (held + data).split(END)
                for text in whole:
                    answer = json.loads(text)
                    with self.lock:
                        box = self.waiting.pop(answer.get("id"), None)
                    if box:
                        box.put(answer)
        except OSError:
            pass
        with self.lock:
            for box in self.waiting.values():
                box.put({"error": {"message": "the host has closed the connection"}})
            self.waiting.clear()

    def ask(self, method, limit_s, **params):
        number, box = next(self.numbers), queue.Queue()
        with self.lock:
            self.waiting[number] = box
        self.socket.sendall(json.dumps({"id": number, "method": method, "params": params}).encode() + END)
        try:
            answer = box.get(timeout=limit_s)
        except queue.Empty:
            raise Refused(f"{method} is not answered within {limit_s:.0f} s") from None
        if "error" in answer:
            raise Refused(str(answer["error"].get("message", answer["error"])))
        return answer["result"]

    def close(self):
        self.socket.close()
        self.thread.join(5)


class Host:
    """The host program at work. `slowness`: how many of its seconds one of the board's takes."""

    def __init__(self, klipper, folder, config, slowness, environment=None):
        self.folder, self.slowness = folder, slowness
        self.log = os.path.join(folder, "klippy.log")
        # A socket's path must be short.
        self.away = tempfile.mkdtemp(prefix="klippy-")
        self.socket = os.path.join(self.away, "api.sock")
        if os.path.exists(self.log):
            os.unlink(self.log)
        command = [sys.executable, os.path.join(klipper, "klippy", "klippy.py"), config]
        command += ["-I", os.path.join(self.away, "terminal"), "-a", self.socket, "-l", self.log]
        self.said = open(os.path.join(folder, "klippy.out"), "w")
        self.process = subprocess.Popen(command, stdout=self.said, stderr=self.said, env=environment)
        self.api = Api(self.socket)

    def info(self):
        try:
            return self.api.ask("info", 20)
        except (Refused, OSError) as error:
            # A restart closes the connection.
            try:
                self.api.close()
                self.api = Api(self.socket)
            except OSError:
                pass
            return {"state": "away", "state_message": str(error)}

    def wait(self, state, limit_s):
        """Waits for a state of the host; an error or a shutdown that is not asked for ends the wait."""
        deadline = time.monotonic() + limit_s
        info = self.info()
        while info["state"] != state:
            if info["state"] in ("error", "shutdown") or time.monotonic() > deadline or self.process.poll() is not None:
                raise Refused(f"not {state} but {info['state']}: {info['state_message'].strip()}")
            time.sleep(0.2)
            info = self.info()

    def run(self, gcode, board_s):
        """Runs G-code to its end, which takes at most so many seconds of the board's time."""
        return self.api.ask("gcode/script", board_s * self.slowness, script=gcode)

    def query(self, **objects):
        return self.api.ask("objects/query", 20 * self.slowness, objects=objects)["status"]

    def stand(self, seconds):
        """Stops the host's processes for a while, as a computer does that is busy elsewhere."""
        self.process.send_signal(signal.SIGSTOP)
        time.sleep(seconds)
        self.process.send_signal(signal.SIGCONT)

    def close(self):
        self.api.close()
        self.process.terminate()
        try:
            self.process.wait(10)
        except subprocess.TimeoutExpired:
            self.process.kill()
            self.process.wait()
        self.said.close()
        shutil.rmtree(self.away, ignore_errors=True)
