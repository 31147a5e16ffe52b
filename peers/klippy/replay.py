#!/usr/bin/env python3
"""Makes a record that the tests of the crate `klipper` replay out of what has passed on a line.

    replay.py WIRE > klipper/src/tests/home.wire

Lines: `host TICK CONTENT`, a block of the host in hexadecimal; `switch PIN TICK LEVEL`, an end stop as it was seen; `position OID STEPS`,
what the board has said of a motor. Ticks are those of the board's clock since power-on;
a block has that of the last clock that the board had told before, so it comes no later than it did.
"""

import sys

from board import read_log
from steps import HALF, MASK, Reader


class Recorder(Reader):
    """A reader that keeps what a replay needs."""

    def __init__(self):
        super().__init__()
        self.blocks, self.positions, self.switches = [], [], []
        self.pins, self.searches = {}, {}

    def from_host(self, sequence, content):
        if self.expected is None or sequence == self.expected:
            names = [name for name, _ in self.words.read(content, self.words.commands)]
            if "identify" not in names:
                self.blocks.append((self.now, content))
        super().from_host(sequence, content)

    def host_config_endstop(self, oid, pin, **_):
        self.pins[oid] = pin

    def host_endstop_home(self, oid, sample_count, rest_ticks, pin_value, **_):
        if sample_count:
            self.searches[oid] = (rest_ticks, pin_value)
            self.switches.append((self.pins[oid], self.now, 1 - pin_value))

    def board_endstop_state(self, oid, next_clock, **_):
        rest, level = self.searches[oid]
        seen = (next_clock - rest - self.now + HALF & MASK) - HALF + self.now
        self.switches.append((self.pins[oid], seen, level))

    def board_trsync_state(self, clock, **_):
        if clock:
            self.board_clock(clock)

    def board_stepper_position(self, oid, pos):
        super().board_stepper_position(oid, pos)
        self.positions.append((oid, pos))


def main():
    recorder = Recorder()
    for at, kind, data in read_log(sys.argv[1]):
        recorder.take(at, kind, data)
    for tick, content in recorder.blocks:
        print("host", tick, content.hex())
    for pin, tick, level in recorder.switches:
        print("switch", pin, tick, level)
    for oid, position in recorder.positions:
        print("position", oid, position)


if __name__ == "__main__":
    main()
