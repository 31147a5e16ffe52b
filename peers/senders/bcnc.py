"""bCNC, with its window on a display that nobody sees, through its pendant's web interface."""

import json
import os
import signal
import subprocess
import time
import urllib.parse
import urllib.request

import mill
from board import GRBL, Failed, main

INI = """[bCNC]
lastcheck = {today}
checkinterval = 10000
[Connection]
port = socket://{port}
baud = 115200
openserial = 1
controller = GRBL1
pendant = 1
pendantport = {pendant}
[CNC]
doublesizeicon = 0
"""


class Bcnc:
    def __init__(self, wire, out, program):
        self.wire, self.out, self.pendant, self.program = wire, out, 8899, program
        self.home_folder = os.path.join(out, "bcnc-home")
        self.process = None

    def connect(self):
        os.makedirs(self.home_folder, exist_ok=True)
        with open(os.path.join(self.home_folder, ".bCNC"), "w") as ini:
            ini.write(INI.format(today=int(time.time()), port=self.wire.path, pendant=self.pendant))
        log = open(os.path.join(self.out, "bcnc.log"), "w")
        environment = {**os.environ, "HOME": self.home_folder, "PYTHONUNBUFFERED": "1"}
        self.process = subprocess.Popen(["xvfb-run", "-a", self.program, "-m", "bCNC"], env=environment, stdout=log,
                                        stderr=log, stdin=subprocess.DEVNULL, start_new_session=True)
        for _ in range(600):
            try:
                self._get("/state")
                return
            except OSError:
                time.sleep(0.2)
        raise Failed("its pendant does not answer: see bcnc.log")

    def _get(self, path):
        with urllib.request.urlopen(f"http://127.0.0.1:{self.pendant}{path}", timeout=60) as answer:
            return answer.read().decode()

    def _send(self, key, text):
        self._get(f"/send?{key}={urllib.parse.quote(text)}")

    def state(self):
        return json.loads(self._get("/state"))["state"]

    def home(self):
        self._send("cmd", "HOME")

    def jog(self, distances):
        self._send("gcode", f"$J=G91 {distances} F2000")

    def line(self, text):
        self._send("gcode", text)

    def load_and_run(self, lines):
        path = os.path.join(self.home_folder, "job.ngc")
        with open(path, "w") as out:
            out.write("\n".join(lines) + "\n")
        self._send("cmd", f"LOAD {path}")
        time.sleep(2)
        self._send("cmd", "RUN")

    def has_ended(self):
        return self.state() == "Idle"

    def hold(self):
        self._send("cmd", "FEEDHOLD")

    def resume(self):
        self._send("cmd", "RESUME")

    def feed(self, percent):
        for _ in range(percent // 10):
            self._send("cmd", "SENDHEX 91")
            time.sleep(0.5)

    def cancel(self):
        self._send("cmd", "STOP")

    def settle(self):
        """It clears the machine once more, some seconds after a job has ended."""
        time.sleep(8)

    def unlock(self):
        self._send("cmd", "UNLOCK")

    def errors(self):
        return [line for line in self.wire.replies() if line.startswith(("error:", "ALARM:"))]

    def close(self):
        if self.process:
            os.killpg(self.process.pid, signal.SIGTERM)
            self.process.wait()


def run(name, out, program):
    """By its name at the debug console, or at the port for GRBL's senders in the board's network."""
    network = name.endswith("net")
    return mill.run(name, out, lambda board: Bcnc(board.network(GRBL) if network else board.talk(), out, program), network)


if __name__ == "__main__":
    main(run)
