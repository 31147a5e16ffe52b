"""What a scenario has in front of it: boards that run, and a host that is connected to them."""

import os
import sys

from board import Board
from host import Host

HERE = os.path.dirname(os.path.abspath(__file__))
ROOT = os.path.dirname(os.path.dirname(HERE))
PRINTER = os.path.join(ROOT, "docs", "klipper", "prime.cfg")
WORLD = os.path.join(HERE, "world.ini")
# Longest that a host may take until it is ready, in the board's seconds beside its own.
READY_S = 60


class Desk:
    def __init__(self, options, folder):
        self.options, self.folder = options, folder
        os.makedirs(folder, exist_ok=True)
        self.boards, self.host = [], None
        self.page = options.clock.new_page() if options.clock else None
        # With one clock for all the host's seconds are the board's.
        self.pace = 1.0 if self.page else options.pace
        self.checks_steps, self.may_be_late = True, False

    def leave_clock(self):
        """Gives boards that come after the computer's clock: one that stands with its host shows nothing."""
        if self.page:
            self.page, self.pace = None, self.options.pace

    def slow_down(self, pace):
        """Sets the pace of the boards that come after, where they have one."""
        if not self.page:
            self.pace = min(self.pace, pace)

    def command(self):
        options = self.options
        if options.model:
            command = [sys.executable, os.path.join(HERE, "model.py")]
        else:
            command = [options.console, "console", "--elf", options.elf, "--config", WORLD, "--board", "tmc2660", "--state-port", "0"]
        if self.page:
            return [*command, "--clock-file", self.page, "--clock-slot", str(len(self.boards))]
        return [*command, "--pace", str(self.pace)]

    def add_board(self, name="prime"):
        board = Board(self.command(), os.path.join(self.folder, name), name)
        self.boards.append(board)
        if not self.page:
            board.wait_for_pace(self.pace)
        return board

    def configuration(self, more=""):
        """The printer.cfg of the documentation, with what belongs to this desk after it: limits in the host's seconds are as much
        longer as the board is slower."""
        slow = 1 / self.pace
        text = f"[include {PRINTER}]\n\n[mcu]\nserial: {self.boards[0].serial}\nbaud: 250000\n"
        text += f"\n[virtual_sdcard]\npath: {self.folder}\n\n[pause_resume]\n\n[display_status]\n"
        for heater, gain_s in (("extruder", 20), ("heater_bed", 60)):
            text += f"\n[verify_heater {heater}]\ncheck_gain_time: {gain_s * slow:.0f}\nmax_error: {120 * slow:.0f}\n"
        path = os.path.join(self.folder, "printer.cfg")
        with open(path, "w") as file:
            file.write(text + more)
        return path

    def start_host(self, more=""):
        terminals = [board.serial for board in self.boards]
        environment = self.options.clock.environment(self.page, terminals) if self.page else None
        self.host = Host(self.options.klipper, self.folder, self.configuration(more), 1 / self.pace, environment)
        self.host.wait("ready", READY_S * (1 + 1 / self.pace))
        return self.host

    def connect(self, more=""):
        """A board and a host that is ready."""
        self.add_board()
        return self.start_host(more)

    def close(self):
        if self.host:
            self.host.close()
            self.host = None
        if self.page:
            self.options.clock.forget_host(self.page)
        for board in self.boards:
            board.close()
