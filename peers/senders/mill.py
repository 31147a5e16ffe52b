"""What senders of GRBL's dialect are asked to do; each sender brings its own ways of doing it."""

import os

from board import NETWORK_ARGUMENTS, Board, Failed, ROOT, Steps, between, with_network, zigzag

CONFIG = os.path.join(ROOT, "peers/senders/mill.ini")


def run(name, out, sender_on, network=False):
    """The sender that `sender_on` starts on a board is asked everything; a row for each step."""
    config, arguments = (with_network(CONFIG, out, name), NETWORK_ARGUMENTS) if network else (CONFIG, ())
    steps, board = Steps(name), Board(config, out, name, arguments=arguments)
    sender = sender_on(board)
    try:
        take_steps(steps, board, sender)
    finally:
        sender.close()
        board.close()
    return steps.rows


def take_steps(steps, board, sender):
    """`sender` has connect, home, jog, load_and_run, hold, resume, feed (percent up), cancel, unlock, line, state and errors."""

    def connect():
        sender.connect()
        board.until("it to be idle", lambda _: sender.state() == "Idle", 40)
        return f"its state: {sender.state()}"

    def home():
        sender.home()
        board.moving()
        board.at((0, 0, 0), 60)
        board.until("it to be idle", lambda _: sender.state() == "Idle", 20)
        return "tool at 0 0 0"

    def jog():
        sender.jog("X12 Y7 Z3")
        board.at((12, 7, 3), 30)
        return "tool at 12 7 3"

    def job():
        lines, end = zigzag(8, 3000)
        sender.load_and_run(lines)
        board.moving()
        board.at(end, 120)
        board.until("the end of the job", lambda _: sender.has_ended(), 60)
        return f"{len(lines)} lines; tool at {end[0]:g} {end[1]:g}"

    def hold():
        lines, _ = zigzag(60, 2000)
        sender.load_and_run(lines)
        board.moving()
        board.until("some of the job", lambda state: state["tool"][0] > 25, 60)
        sender.hold()
        state = board.rest(20, still=0.3)
        again = board.until("time", lambda s: s["s"] > state["s"] + 3, 10)
        if again["edges"] != state["edges"]:
            raise Failed("it moves in a hold")
        if not sender.state().startswith("Hold"):
            raise Failed(f"the sender says {sender.state()}")
        return f"stands for 3 s at {state['tool'][0]:.2f} {state['tool'][1]:.2f}; its state: {sender.state()}"

    def resume():
        sender.resume()
        board.moving()
        board.until("it to run", lambda _: sender.state() == "Run", 20)
        return "moves again; its state: Run"

    def override():
        full = max(board.speed(0.7) for _ in range(4))
        sender.feed(40)
        board.until("the change", lambda s, start=board.state()["s"]: s["s"] > start + 2, 10)
        quick = max(board.speed(0.7) for _ in range(4))
        between(quick / full, 1.25, 1.5, "speed at 140 %")
        return f"feed at 140 %: {quick / full:.2f} of the speed"

    def cancel():
        sender.cancel()
        state = board.rest(60, still=1.0)
        if state["tool"][1] > 49.0:
            raise Failed("the job had ended before")
        board.until("it to be quiet", lambda _: not sender.state().startswith(("Run", "Hold")), 30)
        return f"stands at {state['tool'][0]:.2f} {state['tool'][1]:.2f}; its state: {sender.state()}"

    def after():
        if sender.state().startswith(("Alarm", "ALARM")):
            sender.unlock()
            board.until("it to be idle", lambda _: sender.state() == "Idle", 20)
        sender.settle()
        sender.line("G53 G0 X5 Y5 Z5")
        board.at((5, 5, 5), 30)
        errors = sender.errors()
        if errors:
            raise Failed(f"it was told {errors[0]}")
        return "obeys; no error was heard"

    if steps.step("connect", connect):
        for step in (home, jog, job, hold, resume, override, cancel, after):
            steps.step(step.__name__, step)
