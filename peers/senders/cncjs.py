"""CNCjs: its server, and a client that speaks what its page in a browser speaks."""

import json
import os
import signal
import subprocess
import threading
import time

import mill
from board import Failed, ROOT, main

PORT = 8898


class Cncjs:
    def __init__(self, wire, out, folder):
        self.wire, self.out, self.folder = wire, out, folder
        self.server = self.client = None
        self.status, self.workflow, self.sender, self.told, self.settings = {}, "idle", {}, [], 0

    def connect(self):
        log = open(os.path.join(self.out, "cncjs.log"), "w")
        modules = os.path.join(self.folder, "node_modules")
        command = [os.path.join(modules, ".bin/cncjs"), "-p", str(PORT), "-H", "127.0.0.1", "-c", os.path.abspath(os.path.join(self.out, "cncrc"))]
        self.server = subprocess.Popen(command, stdin=subprocess.DEVNULL, stdout=log, stderr=log, start_new_session=True)
        client = ["node", os.path.join(ROOT, "peers/senders/cncjs_client.js"), modules, f"http://127.0.0.1:{PORT}", self.wire.path]
        for _ in range(60):
            time.sleep(1)
            self.client = subprocess.Popen(client, stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=log, text=True)
            first = json.loads(self.client.stdout.readline() or '["unreachable"]')
            if first[0] != "unreachable":
                self._hear(first)
                threading.Thread(target=self._listen, daemon=True).start()
                return
        raise Failed("its server does not answer: see cncjs.log")

    def _listen(self):
        for line in self.client.stdout:
            self._hear(json.loads(line))

    def _hear(self, words):
        if words[0] == "state":
            self.status = words[1].get("status", {})
        elif words[0] == "workflow":
            self.workflow = words[1]
        elif words[0] == "sender":
            self.sender = words[1]
        elif words[0] == "read":
            self.told.append(words[1])
        elif words[0] == "settings":
            self.settings = words[1]

    def _say(self, *words):
        self.client.stdin.write(json.dumps(words) + "\n")
        self.client.stdin.flush()

    def state(self):
        state, sub = self.status.get("activeState", ""), self.status.get("subState")
        return f"{state}:{sub}" if state == "Hold" and sub is not None else state

    def home(self):
        self._say("command", "homing")

    def jog(self, distances):
        self._say("command", "gcode", f"$J=G91 {distances} F2000")

    def line(self, text):
        self._say("command", "gcode", text)

    def load_and_run(self, lines):
        self._say("command", "gcode:load", "job.nc", "\n".join(lines))
        time.sleep(1)
        self._say("command", "gcode:start")

    def has_ended(self):
        return self.workflow == "idle" and self.sender.get("received") == self.sender.get("total") and self.state() == "Idle"

    def hold(self):
        self._say("command", "gcode:pause")

    def resume(self):
        self._say("command", "gcode:resume")

    def feed(self, percent):
        for _ in range(percent // 10):
            self._say("command", "feedOverride", 10)
            time.sleep(0.3)

    def cancel(self):
        self._say("command", "gcode:stop", {"force": True})

    def settle(self):
        """It has nothing more to say by itself."""

    def unlock(self):
        self._say("command", "unlock")

    def errors(self):
        return [line for line in self.wire.replies() if line.startswith(("error:", "ALARM:"))]

    def close(self):
        if self.client:
            self.client.kill()
        if self.server:
            os.killpg(self.server.pid, signal.SIGTERM)
            self.server.wait()


def run(name, out, folder):
    return mill.run(name, out, lambda board: Cncjs(board.terminal(), out, folder))


if __name__ == "__main__":
    main(run)
