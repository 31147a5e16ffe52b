"""The page on which a board writes its time and a host reads it: built when `--lock` asks for it."""

import os
import subprocess
import tempfile

HERE = os.path.dirname(os.path.abspath(__file__))


class Clock:
    """The library that a host is started with, and the pages it shares with boards."""

    def __init__(self, out):
        self.folder = tempfile.mkdtemp(prefix="klippy-clock-")
        self.library = os.path.join(self.folder, "clock.so")
        source = os.path.join(HERE, "clock.c")
        subprocess.run(["cc", "-O2", "-Wall", "-shared", "-fPIC", "-o", self.library, source, "-ldl", "-lpthread"], check=True)
