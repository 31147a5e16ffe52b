"""Holds the steps a board has made against the commands that a Klipper host has sent it.

    steps.py WIRE STEPS        a log of the line (board.py) and `steps.csv` of the same run

Every step that the host has asked for is worked out in ticks of the board's clock. The board's clock and the time in
`steps.csv` differ by a constant from reset to reset: it is taken as the least difference of all steps of that time, so what is left
of each is how late it was beyond the most punctual one. A stretch of steps that a trigger or a shutdown has cut is told by what was
made of it: its beginning, and nothing behind.
"""

import bisect
import struct
import sys
from array import array

from board import BOARD_TIME, FROM_BOARD, TO_BOARD, read_log
from wire import Dictionary, Splitter

MOTORS = {"PD3": "alpha", "PK2": "beta", "PG3": "gamma", "PC6": "delta"}
# What a host sends as it opens a serial port.
OPENING = bytes.fromhex("1b0100010e1104")
ALLOWED_NS = 250
# A step this far from where it is expected is another one.
OTHER_STEP_NS = 100_000
HALF = 1 << 31
MASK = 0xFFFFFFFF


class Stretch:
    """Steps of a motor between two settings of its clock."""

    def __init__(self):
        self.ticks, self.directions = array("q"), array("b")
        # Whether a trigger may have cut it.
        self.may_stop = False


class Motor:
    def __init__(self, name):
        self.name = name
        self.last, self.direction = 0, 0
        self.stretches = [Stretch()]
        # Positions that the board has told: how many stretches there were, the steps asked for in the last one, the position.
        self.told = []


class Session:
    """What a board was told from one reset to the next."""

    def __init__(self):
        self.motors = {}
        self.is_cut = False
        # The board's clock as it was last told: steps behind it may not have been made when the record ends.
        self.told = 0
        # Of each command to step: when it was sent, by this computer's clock, and the board's clock at its first step.
        self.sent, self.begins = array("d"), array("q")
        # Board's time at which its clock was at zero, once it is known.
        self.base_ns = None

    def queue(self, at, oid, interval, count, add, near):
        motor = self.motors[oid]
        stretch = motor.stretches[-1]
        first = near + ((motor.last + interval - near + HALF) & MASK) - HALF
        tick = first
        for _ in range(count):
            stretch.ticks.append(tick)
            interval += add
            tick += interval
        stretch.directions.extend([1 if motor.direction == 0 else -1] * count)
        motor.last = stretch.ticks[-1]
        self.sent.append(at)
        self.begins.append(first)


class Reader:
    """Follows a line: which blocks count, what the board's clock says, what its motors are told."""

    def __init__(self):
        self.sides = {TO_BOARD: Splitter(), FROM_BOARD: Splitter()}
        self.words, self.identity = Dictionary(), {}
        self.sessions = [Session()]
        self.expected = None
        self.repeated = self.commands = self.naks = 0
        self.answered = None
        self.now = 0
        # This computer's clock, at each look at the board's time, and now.
        self.looked, self.times_s = array("d"), array("d")
        self.at = 0.0

    @property
    def session(self):
        return self.sessions[-1]

    def take(self, at, kind, data):
        self.at = at
        if kind == BOARD_TIME:
            self.looked.append(at)
            self.times_s.extend(struct.unpack("<d", data))
        elif kind == TO_BOARD:
            if OPENING in data:
                self.expected, self.identity = None, {}
                self.sides = {TO_BOARD: Splitter(), FROM_BOARD: Splitter()}
            for sequence, content in self.sides[kind].feed(data):
                self.from_host(sequence, content)
        elif kind == FROM_BOARD:
            for sequence, content in self.sides[kind].feed(data):
                self.from_board(sequence, content)

    def from_host(self, sequence, content):
        # The board takes a block by its number alone, so a repeated one counts once; a host never leaves any out.
        if self.expected is None or sequence != self.expected:
            self.repeated += self.expected is not None
            return
        self.expected = sequence + 1 & 0xF
        for name, values in self.words.read(content, self.words.commands):
            self.commands += 1
            work = getattr(self, f"host_{name}", None)
            if work:
                work(**values)

    def from_board(self, sequence, content):
        if self.expected is None:
            self.expected = sequence
        if not content:
            self.naks += sequence == self.answered
            self.answered = sequence
        for name, values in self.words.read(content, self.words.responses):
            work = getattr(self, f"board_{name}", None)
            if work:
                work(**values)

    def host_reset(self):
        self.session.is_cut = True
        self.sessions.append(Session())
        self.expected, self.now = None, 0

    def host_config_stepper(self, oid, step_pin, **_):
        pins = {number: name for name, number in self.words.numbers("pin").items()}
        self.session.motors[oid] = Motor(MOTORS.get(pins[step_pin], pins[step_pin]))

    def host_set_next_step_dir(self, oid, dir):
        self.session.motors[oid].direction = dir

    def host_reset_step_clock(self, oid, clock):
        motor = self.session.motors[oid]
        motor.last = clock
        if motor.stretches[-1].ticks:
            motor.stretches.append(Stretch())
        motor.stretches[-1].may_stop = False

    def host_stepper_stop_on_trigger(self, oid, trsync_oid):
        self.session.motors[oid].stretches[-1].may_stop = True

    def host_queue_step(self, oid, interval, count, add):
        motor = self.session.motors.get(oid)
        if motor is None:
            return
        self.session.queue(self.at, oid, interval, count, add, self.now)

    def host_emergency_stop(self):
        self.session.is_cut = True

    def board_identify_response(self, offset, data):
        self.identity[offset] = data
        if not data and offset:
            self.words = Dictionary(b"".join(self.identity[at] for at in sorted(self.identity)))
            self.identity = {}

    def board_uptime(self, high, clock):
        self.now = high << 32 | clock

    def board_clock(self, clock):
        self.now += (clock - self.now + HALF & MASK) - HALF
        self.session.told = self.now

    def board_stepper_position(self, oid, pos):
        motor = self.session.motors.get(oid)
        if motor:
            motor.told.append((len(motor.stretches) - 1, len(motor.stretches[-1].ticks), pos))

    def board_shutdown(self, **_):
        self.session.is_cut = True

    def board_starting(self):
        # A reset that nobody asked for: the watchdog's, say.
        if self.session.motors:
            self.host_reset()


def read_wire(path):
    reader = Reader()
    for at, kind, data in read_log(path):
        reader.take(at, kind, data)
    return reader


def read_steps(path):
    """Time and direction of each motor's steps."""
    made = {}
    with open(path) as file:
        next(file, None)
        for line in file:
            at, name, direction = line.split(",")
            times, directions = made.setdefault(name, (array("q"), array("b")))
            times.append(int(at))
            directions.append(int(direction))
    return made


class Comparison:
    """Walks through the made steps of each motor as the host's commands ask for them."""

    def __init__(self, made, tick_ns):
        self.made, self.tick_ns = made, tick_ns
        self.at = dict.fromkeys(made, 0)
        self.count = self.cut = 0
        self.sum_ns = self.worst_ns = 0
        self.worst = ""
        self.wrong = []

    def complain(self, text):
        self.wrong.append(text)

    def follow(self, session, number):
        if number:
            self.pass_over_reset()
        motors = [motor for motor in session.motors.values() if any(stretch.ticks for stretch in motor.stretches)]
        begins = [(stretch.ticks[0], motor.name) for motor in motors for stretch in motor.stretches[:1] if stretch.ticks]
        if not begins:
            return
        tick, name = min(begins)
        times = self.made.get(name, (array("q"),))[0]
        if self.at.get(name, 0) >= len(times):
            self.complain(f"session {number}: {name} was told to step and never did")
            return
        session.base_ns = base = times[self.at[name]] - int(tick * self.tick_ns)
        late = [self.walk(motor, session, base) for motor in motors]
        least = min((min(part) for part in late if part), default=0)
        for motor, part in zip(motors, late):
            self.count += len(part)
            if not part:
                continue
            self.sum_ns += sum(part) - least * len(part)
            worst = max(part)
            if worst - least > self.worst_ns:
                self.worst_ns = worst - least
                self.worst = f"{motor.name}, step {part.index(worst)} of session {number}"

    def pass_over_reset(self):
        """A reset makes inputs of the step pins: one that was high falls, which is an edge, while the drivers are off."""
        for name, at in self.at.items():
            if at % 2 and at < len(self.made[name][0]):
                self.at[name] = at + 1

    def walk(self, motor, session, base):
        """How late each step of a motor was, beyond `base`."""
        late = array("q")
        times, directions = self.made.get(motor.name, (array("q"), array("b")))
        at, tick_ns = self.at.get(motor.name, 0), self.tick_ns
        begun = at
        for index, stretch in enumerate(motor.stretches):
            before = at
            for tick, direction in zip(stretch.ticks, stretch.directions):
                if at >= len(times):
                    break
                off = times[at] - int(tick * tick_ns) - base
                if not -OTHER_STEP_NS < off < OTHER_STEP_NS:
                    break
                if directions[at] != direction:
                    self.complain(f"{motor.name}: step at {times[at]} ns goes the wrong way")
                late.append(off)
                at += 1
            left = len(stretch.ticks) - (at - before)
            is_last = index == len(motor.stretches) - 1
            is_behind = at >= len(times) and left and stretch.ticks[at - before] > session.told
            if left and not (stretch.may_stop or is_last and session.is_cut or is_behind):
                found = f"the next one made is at {times[at]} ns" if at < len(times) else "none was made any more"
                due = int(stretch.ticks[at - before] * tick_ns) + base
                self.complain(f"{motor.name}: {left} steps asked for from {due} ns on are not there; {found}")
            self.cut += left
            self.hold_positions(motor, index, directions[begun:before], directions[before:at])
        self.at[motor.name] = at
        return late

    def hold_positions(self, motor, index, earlier, those):
        """Holds what the board has said of a motor's position against the steps made: those of the stretch, where it had them all."""
        for place, count, position in motor.told:
            if place == index and count in (0, len(motor.stretches[index].ticks)):
                # Direction 0 counts down, and is up on this board.
                made = -sum(earlier) - (sum(those) if count else 0)
                if made != position:
                    self.complain(f"{motor.name}: the board says it stands at {position}, its steps say {made}")

    def finish(self):
        for name, (times, _) in self.made.items():
            if self.at[name] < len(times):
                first = times[self.at[name]]
                self.complain(f"{name}: {len(times) - self.at[name]} steps that nobody asked for, the first at {first} ns")
        if self.worst_ns > self.tick_ns + ALLOWED_NS:
            self.complain(f"a step is {self.worst_ns} ns late: {self.worst}")

    def report(self):
        mean = self.sum_ns / self.count if self.count else 0
        return f"{self.count} steps, latest {self.worst_ns} ns ({self.worst}), mean {mean:.1f} ns, {self.cut} cut by triggers"


def board_ns(reader, at):
    """The board's time as this computer's clock was at `at`, between two looks at it."""
    index = min(max(bisect.bisect(reader.looked, at), 1), len(reader.looked) - 1)
    (before, after), (one, other) = reader.looked[index - 1 : index + 1], reader.times_s[index - 1 : index + 1]
    return 1e9 * (one + (other - one) * (at - before) / (after - before))


def margins_s(reader, tick_ns):
    """How long before its first step each command to step was sent, in the board's seconds."""
    for session in reader.sessions:
        if session.base_ns is not None and len(reader.looked) > 1:
            for at, tick in zip(session.sent, session.begins):
                yield (tick * tick_ns + session.base_ns - board_ns(reader, at)) * 1e-9


def compare(wire, steps):
    """The comparison, and the reader of the line with its counts."""
    reader = read_wire(wire)
    comparison = Comparison(read_steps(steps), 1e9 / reader.words.config.get("CLOCK_FREQ", 200_000_000))
    for number, session in enumerate(reader.sessions):
        comparison.follow(session, number)
    comparison.finish()
    return comparison, reader


def main():
    comparison, reader = compare(*sys.argv[1:3])
    print(f"{reader.commands} commands, {reader.repeated} repeated blocks, {reader.naks} naks")
    print(comparison.report())
    print("\n".join(comparison.wrong[:20]))
    return 1 if comparison.wrong else 0


if __name__ == "__main__":
    sys.exit(main())
