"""printrun's printcore, which pronsole and pronterface are made of, through its Python interface.

On a pseudo-terminal it numbers and checksums the lines of a job; on TCP it sends them as they are, to the debug
console or to the board's own Telnet port in its network.
"""

import os
import threading

from board import NETWORK_ARGUMENTS, TELNET, Board, Failed, ROOT, Steps, between, main, with_network, zigzag

CONFIG = os.path.join(ROOT, "config/samples/cartesian.ini")


def run(name, out, where):
    from printrun.gcoder import LightGCode
    from printrun.printcore import printcore

    steps = Steps(name)
    if where == "net":
        board = Board(with_network(CONFIG, out, name), out, name, arguments=NETWORK_ARGUMENTS)
        wire = board.network(TELNET)
    else:
        board = Board(CONFIG, out, name)
        wire = board.terminal() if where == "terminal" else board.talk()
    core, heard, ended = printcore(), [], threading.Event()
    core.recvcb = lambda line: heard.append(line.rstrip())
    core.endcb = ended.set

    def connect():
        core.connect(wire.path, 115200)
        board.until("online", lambda _: core.online, 30)
        board.until("an answer", lambda _: any("T:" in line for line in heard), 10)
        return next(line for line in heard if "T:" in line)

    def home():
        core.send_now("G28")
        board.moving()
        board.at((0, 0, 0), 60)
        return "tool at 0 0 0"

    def jog():
        for line in ("G91", "G1 X12 Y7 Z3 F3000", "G90"):
            core.send_now(line)
        board.at((12, 7, 3), 30)
        return "tool at 12 7 3"

    def extrude():
        # As Pronterface's buttons do it.
        begun, fed = board.state()["carriages"]["delta"], []
        for amount in (5, 5, -5):
            for line in ("G91", f"G1 E{amount} F300", "G90"):
                core.send_now(line)
            board.moving()
            board.rest(30)
            fed.append(round(board.state()["carriages"]["delta"] - begun, 1))
        if fed != [5.0, 10.0, 5.0]:
            raise Failed(f"5, 5 and -5 mm came to {fed}")
        return "5 mm out, 5 mm more, 5 mm back"

    def heat():
        core.send_now("M104 S60")
        board.until("warmth", lambda state: state["heaters"]["hotend"][0] > 45.0, 60)
        core.send_now("M105")
        board.until("it to hear of it", lambda _: any("/60.0" in line for line in heard), 10)
        core.send_now("M104 S0")
        return f"the hot end is at {board.state()['heaters']['hotend'][0]:.0f} C, and it was told"

    def job():
        lines, end = zigzag(6, 6000)
        ended.clear()
        before = len(heard)
        core.startprint(LightGCode(lines))
        board.moving()
        board.until("the end of the job", lambda _: ended.is_set(), 120)
        board.at(end, 30)
        resent = sum("resend" in line.lower() or line.startswith("rs") for line in heard[before:])
        if resent:
            raise Failed(f"{resent} lines were asked for again")
        return f"{len(lines)} lines, none again; tool at {end[0]:g} {end[1]:g}"

    def hold():
        lines, _ = zigzag(40, 3000)
        ended.clear()
        core.startprint(LightGCode(lines))
        board.moving()
        core.pause()
        # It stops sending: what the machine has is finished.
        state = board.rest(60)
        again = board.until("time", lambda s: s["s"] > state["s"] + 3, 10)
        if again["edges"] != state["edges"] or not core.paused:
            raise Failed("it moves while paused")
        return f"stands for 3 s at {state['tool'][0]:.1f} {state['tool'][1]:.1f}"

    def resume():
        core.resume()
        board.moving()
        return "moves again"

    def override():
        full = max(board.speed(1.0) for _ in range(3))
        core.send_now("M220 S40")
        board.until("the moves ahead of it", lambda s, start=board.state()["s"]: s["s"] > start + 8, 15)
        slow = max(board.speed(1.0) for _ in range(3))
        core.send_now("M220 S100")
        between(slow / full, 0.3, 0.5, "speed at M220 S40")
        return f"M220 S40: {slow / full:.2f} of the speed"

    def cancel():
        core.cancelprint()
        state = board.rest(60)
        if state["tool"][1] > 39.0:
            raise Failed("the job had ended before")
        answers = len([line for line in heard if line.startswith("ok")])
        return f"stands at {state['tool'][0]:.1f} {state['tool'][1]:.1f}; {answers} ok in all"

    def after():
        core.send_now("G0 X5 Y5 Z5")
        board.at((5, 5, 5), 30)
        errors = [line for line in heard if "error" in line.lower() or "halt" in line.lower()]
        if errors:
            raise Failed(f"it was told {errors[0]}")
        return "obeys; no error was heard"

    try:
        if steps.step("connect", connect):
            for step in (home, jog, extrude, heat, job, hold, resume, override, cancel, after):
                steps.step(step.__name__, step)
    finally:
        core.disconnect()
        board.close()
    return steps.rows


if __name__ == "__main__":
    main(run)
