"""Prints what has passed on a line, a message a line: the computer's seconds, the block's number, the message.

    dump.py WIRE [WORD ...]        only messages with one of these words in their names
"""

import sys

from board import TO_BOARD, read_log
from steps import Reader


class Printer(Reader):
    """A reader that shows every block, those that the board passes over among them."""

    def __init__(self, words):
        super().__init__()
        self.wanted = words

    def show(self, mark, sequence, content, messages):
        for name, values in self.words.read(content, messages) or [("-", {})]:
            if not self.wanted or any(word in name for word in self.wanted):
                fields = " ".join(f"{key}={value.hex() if isinstance(value, bytes) else value}" for key, value in values.items())
                print(f"{self.at:.6f} {mark} {sequence:2} {name} {fields}")

    def from_host(self, sequence, content):
        self.show(">" if sequence == self.expected else "x", sequence, content, self.words.commands)
        super().from_host(sequence, content)

    def from_board(self, sequence, content):
        self.show("<", sequence, content, self.words.responses)
        super().from_board(sequence, content)


def main():
    path, *words = sys.argv[1:]
    printer = Printer(words)
    for at, kind, data in read_log(path):
        noise = printer.sides[TO_BOARD].noise
        printer.take(at, kind, data)
        if printer.sides[TO_BOARD].noise > noise and kind == TO_BOARD and not words:
            print(f"{at:.6f} > noise {data[:16].hex()}")


if __name__ == "__main__":
    main()
