"""The page on which boards write their time and a host reads it, and the library that has a host do so."""

import mmap
import os
import shutil
import struct
import subprocess
import tempfile
import time

HERE = os.path.dirname(os.path.abspath(__file__))
# As in clock.c: words of a board, the count of turns, bytes in the host's pipes, a word for each thread of the host.
BOARDS, BOARD_WORDS, THREADS = 4, 4, 64
TURNS = BOARDS * BOARD_WORDS
WORDS = TURNS + 2 + THREADS
BASE_NS = 100_000_000_000
LOST_S, NAP_S = 0.5, 0.00003


class Clock:
    """What a run with one clock needs; each host has a page of its own."""

    def __init__(self):
        self.folder = tempfile.mkdtemp(prefix="klippy-clock-")
        self.library = os.path.join(self.folder, "clock.so")
        self.pages = 0
        source = os.path.join(HERE, "clock.c")
        subprocess.run(["cc", "-O2", "-Wall", "-shared", "-fPIC", "-o", self.library, source, "-ldl", "-lpthread"], check=True)

    def new_page(self):
        self.pages += 1
        path = os.path.join(self.folder, f"page-{self.pages}")
        with open(path, "wb") as file:
            file.truncate(WORDS * 8)
        return path

    def environment(self, page, terminals):
        """Of a host that reads this page, with the boards' terminals in their order."""
        ttys = ",".join(os.path.realpath(terminal) for terminal in terminals)
        return {**os.environ, "LD_PRELOAD": self.library, "VELVET_CLOCK": page, "VELVET_CLOCK_TTYS": ttys}

    @staticmethod
    def forget_host(page):
        """Boards do not wait any more for a host that has been ended."""
        with open(page, "r+b") as file:
            file.seek((TURNS + 1) * 8)
            file.write(bytes((1 + THREADS) * 8))

    @staticmethod
    def forget_board(page, slot):
        """Nobody waits any more for a board that has died."""
        with open(page, "r+b") as file:
            file.seek(slot * BOARD_WORDS * 8)
            file.write(bytes(BOARD_WORDS * 8))

    def close(self):
        shutil.rmtree(self.folder, ignore_errors=True)


class Page:
    """The page as a board has it: virtual-prime/src/commands/clock_file.rs, for the model."""

    def __init__(self, path, slot):
        with open(path, "r+b") as file:
            self.words = mmap.mmap(file.fileno(), WORDS * 8)
        self.slot = slot
        self.lost, self.seen = None, (None, 0.0)
        self.turns = None

    def tell(self, now_ns):
        struct.pack_into("<2Q", self.words, self.slot * BOARD_WORDS * 8, now_ns, now_ns)

    def may_go(self, now_ns, heard, said):
        words = struct.unpack_from(f"<{WORDS}Q", self.words)
        waits = [until for until in words[TURNS + 2 :] if until]
        if not waits:
            time.sleep(0.0005)
            return True
        others = [words[board * BOARD_WORDS] for board in range(BOARDS)]
        settled = self.has_arrived(words, heard, said) and min(waits) > now_ns + BASE_NS
        settled &= all(not other or other >= now_ns for other in others)
        may_go = settled and self.turns == words[TURNS]
        self.turns = words[TURNS] if settled else None
        if not may_go:
            time.sleep(NAP_S)
        return may_go

    def has_arrived(self, words, heard, said):
        """Whether no byte is on its way; those that have been for long are lost."""
        written, read = words[self.slot * BOARD_WORDS + 2 : self.slot * BOARD_WORDS + 4]
        on_the_way = (written - heard, said - read, words[TURNS + 1])
        if on_the_way != self.seen[0]:
            self.seen = (on_the_way, time.monotonic())
        elif time.monotonic() - self.seen[1] > LOST_S:
            self.lost = on_the_way
        return on_the_way == self.lost
