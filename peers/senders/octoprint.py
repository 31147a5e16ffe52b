"""OctoPrint: its server, through its REST interface; it numbers and checksums the lines of a job."""

import http.client
import json
import os
import signal
import subprocess
import time
import urllib.error
import urllib.request
import uuid

from board import Board, Failed, ROOT, Steps, between, main, zigzag

CONFIG = os.path.join(ROOT, "config/samples/cartesian.ini")
PORT, KEY = 8897, "0123456789ABCDEF0123456789ABCDEF"
SETTINGS = """accessControl: {{enabled: false}}
api: {{key: {key}}}
server:
  firstRun: false
  seenWizards: {{corewizard: 4, backup: null}}
  onlineCheck: {{enabled: false}}
  pluginBlacklist: {{enabled: false}}
serial:
  additionalPorts: [{port}]
  autoconnect: false
scripts:
  gcode: {{afterPrintPaused: "G91\nG1 Z4 F600\nG90\nM400", beforePrintResumed: "G91\nG1 Z-4 F600\nG90\nM400"}}
plugins:
  _disabled: [softwareupdate, tracking, discovery, announcements, pluginmanager, firmware_check]
"""


class OctoPrint:
    def __init__(self, wire, out, program):
        self.wire, self.out, self.program, self.process = wire, out, program, None

    def start(self):
        folder = os.path.abspath(os.path.join(self.out, "octoprint-home"))
        os.makedirs(folder, exist_ok=True)
        with open(os.path.join(folder, "config.yaml"), "w") as out:
            out.write(SETTINGS.format(key=KEY, port=self.wire.path))
        log = open(os.path.join(self.out, "octoprint.log"), "w")
        command = [self.program, "serve", "--iknowwhatimdoing", "--basedir", folder, "--host", "127.0.0.1", "--port", str(PORT)]
        self.process = subprocess.Popen(command, stdin=subprocess.DEVNULL, stdout=log, stderr=log, start_new_session=True)
        for _ in range(240):
            try:
                return self.ask("GET", "/api/version")["server"]
            except (OSError, ValueError, KeyError, http.client.HTTPException, Failed):  # it begins with a server that knows nothing
                time.sleep(0.5)
        raise Failed("its server does not answer: see octoprint.log")

    def ask(self, method, path, words=None, data=None, kind="application/json"):
        data = json.dumps(words).encode() if words is not None else data
        request = urllib.request.Request(f"http://127.0.0.1:{PORT}{path}", data=data, method=method)
        request.add_header("X-Api-Key", KEY)
        if data is not None:
            request.add_header("Content-Type", kind)
        try:
            with urllib.request.urlopen(request, timeout=60) as answer:
                text = answer.read().decode()
        except urllib.error.HTTPError as error:
            if error.code in (403, 503):
                raise OSError(f"{path}: {error}") from error
            raise Failed(f"{path}: {error.code} {error.read().decode()[:200]}") from error
        return json.loads(text) if text else {}

    def state(self):
        return self.ask("GET", "/api/job")["state"]

    def print_job(self, lines):
        name, line = uuid.uuid4().hex, "\r\n"
        form = [f"--{name}", 'Content-Disposition: form-data; name="file"; filename="job.gcode"', "Content-Type: text/plain", "",
                "\n".join(lines) + "\n", f"--{name}", 'Content-Disposition: form-data; name="print"', "", "true", f"--{name}--", ""]
        self.ask("POST", "/api/files/local", data=line.join(form).encode(), kind=f"multipart/form-data; boundary={name}")

    def job(self, words):
        self.ask("POST", "/api/job", words)

    def close(self):
        if self.process:
            os.killpg(self.process.pid, signal.SIGTERM)
            self.process.wait()


def run(name, out, program):
    steps, board = Steps(name), Board(CONFIG, out, name)
    wire = board.terminal()
    octoprint = OctoPrint(wire, out, program)

    def connect():
        version = octoprint.start()
        octoprint.ask("POST", "/api/connection", {"command": "connect", "port": wire.path, "baudrate": 115200})
        board.until("it to be operational", lambda _: octoprint.state() == "Operational", 60)
        board.until("temperatures", lambda _: "tool0" in octoprint.ask("GET", "/api/printer")["temperature"], 20)
        warm = octoprint.ask("GET", "/api/printer")["temperature"]
        return f"{version}; tool {warm['tool0']['actual']}, bed {warm['bed']['actual']} C"

    def home():
        octoprint.ask("POST", "/api/printer/printhead", {"command": "home", "axes": ["x", "y", "z"]})
        board.moving()
        board.at((0, 0, 0), 60)
        return "tool at 0 0 0"

    def jog():
        octoprint.ask("POST", "/api/printer/printhead", {"command": "jog", "x": 12, "y": 7, "z": 3})
        board.at((12, 7, 3), 60)
        return "tool at 12 7 3"

    def job():
        lines, end = zigzag(6, 6000)
        octoprint.print_job(lines)
        board.moving()
        board.until("it to be printing no more", lambda _: octoprint.state() == "Operational", 120)
        board.at(end, 30)
        resent = [line for line in wire.replies() if line.lower().startswith(("resend", "rs"))]
        if resent:
            raise Failed(f"asked for again: {resent[0]}")
        return f"{len(lines)} lines, none again; tool at {end[0]:g} {end[1]:g}"

    def hold():
        lines, _ = zigzag(60, 3000)
        octoprint.print_job(lines)
        board.moving()
        board.until("some of the job", lambda state: state["tool"][0] > 25, 60)
        octoprint.job({"command": "pause", "action": "pause"})
        board.until("it to be paused", lambda _: octoprint.state() == "Paused", 60)
        state = board.rest(60)
        again = board.until("time", lambda s: s["s"] > state["s"] + 3, 10)
        if again["edges"] != state["edges"]:
            raise Failed("it moves while paused")
        if state["tool"][2] < 6.9:
            raise Failed(f"its script for a pause has not lifted the tool: Z{state['tool'][2]}")
        return f"stands for 3 s at {state['tool'][0]:.1f} {state['tool'][1]:.1f}, lifted by its script; its state: Paused"

    def resume():
        octoprint.job({"command": "pause", "action": "resume"})
        board.moving()
        board.until("it to be printing", lambda _: octoprint.state() == "Printing", 30)
        board.until("its script to lower the tool", lambda state: state["tool"][2] < 3.1, 30)
        return "lowered by its script, moves again; its state: Printing"

    def override():
        full = max(board.speed(1.0) for _ in range(3))
        octoprint.ask("POST", "/api/printer/printhead", {"command": "feedrate", "factor": 50})
        board.until("the moves ahead of it", lambda s, start=board.state()["s"]: s["s"] > start + 8, 15)
        slow = max(board.speed(1.0) for _ in range(3))
        octoprint.ask("POST", "/api/printer/printhead", {"command": "feedrate", "factor": 100})
        between(slow / full, 0.4, 0.6, "speed at 50 %")
        return f"feedrate 50 %: {slow / full:.2f} of the speed"

    def cancel():
        octoprint.job({"command": "cancel"})
        state = board.rest(60, still=1.0)
        if state["tool"][1] > 49.0:
            raise Failed("the job had ended before")
        board.until("it to be operational", lambda _: octoprint.state() == "Operational", 60)
        return f"stands at {state['tool'][0]:.1f} {state['tool'][1]:.1f}; its state: Operational"

    def extrude():
        begun = board.state()["carriages"]["delta"]
        fed = []
        for amount in (5, 5, -5):
            octoprint.ask("POST", "/api/printer/tool", {"command": "extrude", "amount": amount})
            board.moving()
            board.rest(30)
            fed.append(round(board.state()["carriages"]["delta"] - begun, 1))
        if fed != [5.0, 10.0, 5.0]:
            raise Failed(f"5, 5 and -5 mm came to {fed}")
        return "its buttons: 5 mm out, 5 mm more, 5 mm back"

    def graph():
        history = octoprint.ask("GET", "/api/printer?history=true&limit=100")["temperature"]["history"]
        seen = [(at["tool0"]["actual"], at["tool0"]["target"]) for at in history]
        if len(seen) < 5 or not any(target == 60 for _, target in seen) or max(actual for actual, _ in seen) < 40:
            raise Failed(f"the temperature graph has {seen[-5:]}")
        return f"{len(seen)} points, up to {max(actual for actual, _ in seen):.0f} C"

    def heat():
        octoprint.ask("POST", "/api/printer/tool", {"command": "target", "targets": {"tool0": 60}})
        board.until("warmth", lambda state: state["heaters"]["hotend"][0] > 45.0, 60)
        told = lambda: octoprint.ask("GET", "/api/printer")["temperature"]["tool0"]
        board.until("it to hear of it", lambda _: told()["target"] == 60 and told()["actual"] > 40, 30)
        octoprint.ask("POST", "/api/printer/tool", {"command": "target", "targets": {"tool0": 0}})
        return f"the hot end is at {board.state()['heaters']['hotend'][0]:.0f} C, and it knows"

    def after():
        octoprint.ask("POST", "/api/printer/command", {"commands": ["G90", "G0 X5 Y5 Z5"]})
        board.at((5, 5, 5), 30)
        errors = [line for line in wire.replies() if line.startswith(("error", "!!", "Error"))]
        if errors:
            raise Failed(f"it was told {errors[0]}")
        return "obeys; no error was heard"

    try:
        if steps.step("connect", connect):
            for step in (home, jog, extrude, job, hold, resume, override, cancel, heat, graph, after):
                steps.step(step.__name__, step)
    finally:
        octoprint.close()
        board.close()
    return steps.rows


if __name__ == "__main__":
    main(run)
