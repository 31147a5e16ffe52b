"""Klipper's step rate benchmark (docs/Benchmarks.md there), spoken by a host of a few lines."""

import os
import select
import time
import tty

from wire import Dictionary, Splitter, block

# A board that has all it can do is emulated slowly.
ANSWER_S = 60.0
# Steps of each motor, as in the benchmark; and the step that ends it.
STEPS, LAST_TICKS = 60_000, 3_000
# Moves of so many steps, one behind the other. A board may play late what it cannot play in time, and say nothing; then the last step
# shows it, by this share of their duration and the time that an answer takes.
MOVES, MOST_LATE, ALLOWED_S = 20, 0.02, 0.01
# Time ahead at which the steps begin.
LEAD_S = 2.0
HALF = 1 << 31
PINS = [("PD3", "PD4"), ("PK2", "PG2"), ("PG3", "PG4")]
MOST_TICKS = 1_000


class Client:
    """A host without flow control: one block at a time, each of which is answered before the next one goes."""

    def __init__(self, terminal):
        self.file = os.open(terminal, os.O_RDWR | os.O_NOCTTY)
        tty.setraw(self.file)
        self.splitter, self.words, self.sequence = Splitter(), Dictionary(), 0
        self.heard = []
        self.is_shut_down = False

    def receive(self, seconds):
        """Takes in what has come, or comes within this time. Returns whether there was any."""
        if not select.select([self.file], [], [], seconds)[0]:
            return False
        for sequence, content in self.splitter.feed(os.read(self.file, 4096)):
            self.acknowledged = sequence
            for name, values in self.words.read(content, self.words.responses):
                self.is_shut_down |= name in ("shutdown", "is_shutdown")
                self.heard.append((name, values))
        return True

    def send(self, name, **values):
        """Sends a command, until the board counts it."""
        content = self.words.by_name[name].write(values)
        for _ in range(5):
            self.acknowledged = None
            os.write(self.file, block(self.sequence, content))
            deadline = time.monotonic() + ANSWER_S
            while time.monotonic() < deadline:
                self.receive(0.1)
                if self.acknowledged == (self.sequence + 1) & 0xF:
                    self.sequence = self.acknowledged
                    return
                if self.acknowledged not in (None, self.sequence):
                    break
            if self.acknowledged is not None:
                self.sequence = self.acknowledged
        raise RuntimeError(f"the board does not take {name}")

    def ask(self, name, answer, **values):
        self.heard.clear()
        self.send(name, **values)
        deadline = time.monotonic() + ANSWER_S
        while time.monotonic() < deadline:
            for found, answered in self.heard:
                if found == answer:
                    return answered
                if found == "is_shutdown":
                    raise RuntimeError(f"{name} is refused in a shutdown")
            self.receive(0.1)
        raise RuntimeError(f"no {answer} to {name}")

    def identify(self):
        text = b""
        while piece := self.ask("identify", "identify_response", offset=len(text), count=40)["data"]:
            text += piece
        self.words = Dictionary(text)


def queue(client, oid, start, ticks):
    client.send("reset_step_clock", oid=oid, clock=start & 0xFFFFFFFF)
    client.send("set_next_step_dir", oid=oid, dir=0)
    for _ in range(MOVES):
        client.send("queue_step", oid=oid, interval=ticks, count=STEPS, add=0)
    client.send("set_next_step_dir", oid=oid, dir=1)
    client.send("queue_step", oid=oid, interval=LAST_TICKS, count=1, add=0)


def position(client, oid):
    return client.ask("stepper_get_position", "stepper_position", oid=oid)["pos"]


def attempt(client, motors, ticks):
    """Whether so many motors step with so many ticks between two steps: without a shutdown, and to the end in time."""
    client.is_shut_down = False
    frequency, length = client.words.config["CLOCK_FREQ"], STEPS * MOVES * ticks
    ends = [position(client, oid) - STEPS * MOVES + 1 for oid in range(motors)]
    start = client.ask("get_clock", "clock")["clock"] + int(LEAD_S * frequency)
    for oid in range(motors):
        queue(client, oid, start, ticks)
    late = None
    while not client.is_shut_down and late is None:
        try:
            at_end = all(position(client, oid) == end for oid, end in enumerate(ends))
        except RuntimeError:
            if client.is_shut_down:
                break
            raise
        behind = (client.ask("get_clock", "clock")["clock"] - start - length - LAST_TICKS + HALF & 0xFFFFFFFF) - HALF
        if at_end:
            late = behind
        if behind > frequency:
            raise RuntimeError(f"steps {ticks} ticks apart do not come to an end")
    if client.is_shut_down:
        client.send("clear_shutdown")
        return False
    return late < MOST_LATE * length + ALLOWED_S * frequency


def least_ticks(client, motors):
    failing, working = 0, MOST_TICKS
    if not attempt(client, motors, working):
        return None
    while working - failing > 1:
        middle = (working + failing) // 2
        if attempt(client, motors, middle):
            working = middle
        else:
            failing = middle
    return working


def run(terminal):
    client = Client(terminal)
    client.identify()
    pins = client.words.numbers("pin")
    client.send("allocate_oids", count=3)
    for oid, (step, turn) in enumerate(PINS):
        client.send("config_stepper", oid=oid, step_pin=pins[step], dir_pin=pins[turn], invert_step=-1, step_pulse_ticks=0)
    client.send("finalize_config", crc=0)
    frequency, notes = client.words.config["CLOCK_FREQ"], []
    for motors in (1, 3):
        ticks = least_ticks(client, motors)
        rate = f"{motors * frequency / ticks / 1000:.0f}K steps/s" if ticks else f"more than {MOST_TICKS}"
        notes.append(f"{motors} motor{'s'[: motors - 1]}: {ticks} ticks, {rate}")
    os.close(client.file)
    return "; ".join(notes)
