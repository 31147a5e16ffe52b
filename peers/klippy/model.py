"""A board in a few lines, to try the other programs here without an image: the protocol, motors, switches and heat.

    model.py [--pace RATE | --clock-file PAGE [--clock-slot N]] --out FOLDER

It stands where `virtual-prime console` stands otherwise: the same words on standard error, the same files.
"""

import argparse
import heapq
import json
import math
import os
import select
import socket
import sys
import time
import zlib
from collections import deque

from clock import Page
from wire import Dictionary, Splitter, block

FREQUENCY = 200_000_000
TICK_NS = 5
MASK = 0xFFFFFFFF
REST_C = 22.0
COMMANDS = """identify offset=%u count=%c|get_uptime|get_clock|get_config|allocate_oids count=%c|finalize_config crc=%u|emergency_stop
clear_shutdown|reset|debug_nop|config_digital_out oid=%c pin=%u value=%c default_value=%c max_duration=%u
set_digital_out_pwm_cycle oid=%c cycle_ticks=%u|queue_digital_out oid=%c clock=%u on_ticks=%u|update_digital_out oid=%c value=%c
set_digital_out pin=%u value=%c|config_analog_in oid=%c pin=%u
query_analog_in oid=%c clock=%u sample_ticks=%u sample_count=%c rest_ticks=%u bytes_per_report=%c min_value=%hu max_value=%hu range_check_count=%c
config_stepper oid=%c step_pin=%c dir_pin=%c invert_step=%c step_pulse_ticks=%u|queue_step oid=%c interval=%u count=%hu add=%hi
set_next_step_dir oid=%c dir=%c|reset_step_clock oid=%c clock=%u|stepper_get_position oid=%c
stepper_stop_on_trigger oid=%c trsync_oid=%c|config_endstop oid=%c pin=%c pull_up=%c
endstop_home oid=%c clock=%u sample_ticks=%u sample_count=%c rest_ticks=%u pin_value=%c trsync_oid=%c trigger_reason=%c
endstop_query_state oid=%c|config_trsync oid=%c|trsync_start oid=%c report_clock=%u report_ticks=%u expire_reason=%c
trsync_set_timeout oid=%c clock=%u|trsync_trigger oid=%c reason=%c|config_spi oid=%c pin=%u cs_active_high=%c
spi_set_bus oid=%c spi_bus=%u mode=%u rate=%u|spi_transfer oid=%c data=%*s|spi_send oid=%c data=%*s"""
RESPONSES = """uptime high=%u clock=%u|clock clock=%u|config is_config=%c crc=%u is_shutdown=%c move_count=%hu|starting
stats count=%u sum=%u sumsq=%u|shutdown clock=%u static_string_id=%hu|is_shutdown static_string_id=%hu
analog_in_state oid=%c next_clock=%u values=%*s|stepper_position oid=%c pos=%i
endstop_state oid=%c homing=%c next_clock=%u pin_value=%c|trsync_state oid=%c can_trigger=%c trigger_reason=%c clock=%u
spi_transfer_response oid=%c response=%*s"""
REASONS = {"Timer too close": 2, "Command request": 3, "Stepper too far in past": 4}
# Motor by its step pin: its name, steps for each millimetre, where it stands at power-on, the pin of its switch.
MOTORS = {"PD3": ("alpha", 80, 30, "PD0"), "PK2": ("beta", 80, 40, "PI1"), "PG3": ("gamma", 400, 10, "PI0"), "PC6": ("delta", 415, 0, None)}
SWITCHES = {"PD0": "alpha", "PI1": "beta", "PI0": "gamma", "PB10": "gamma"}
# By heater pin: sensor pin, power and loss by heat capacity, constant B of the thermistor.
HEATERS = {"PE0": ("PF11", 3.3, 0.0083, 4300), "PE3": ("PB0", 0.625, 0.005, 3974)}


def lines(text):
    return [line for row in text.split("\n") for line in row.split("|")]


def dictionary():
    numbers = iter(range(2, 127))
    pins = {f"P{port}0": [16 * index, 16] for index, port in enumerate("ABCDEFGHIJK")}
    facts = {
        "commands": {text: 1 if text.startswith("identify") else next(numbers) for text in lines(COMMANDS)},
        "responses": {"identify_response offset=%u data=%.*s": 0, **{text: next(numbers) for text in lines(RESPONSES)}},
        "enumerations": {"pin": pins, "spi_bus": {"spi4": 0}, "static_string_id": REASONS},
        "config": {"CLOCK_FREQ": FREQUENCY, "MCU": "model", "STATS_SUMSQ_BASE": 256, "STEPPER_STEP_BOTH_EDGE": 1, "ADC_MAX": 4095,
                   "SERIAL_BAUD": 250000, "RECEIVE_WINDOW": 192},
        "version": "model", "build_versions": "none", "app": "model", "license": "MIT OR Apache-2.0",
    }
    return zlib.compress(json.dumps(facts).encode())


class Stopped(Exception):
    """A reason to shut down."""


class Motor:
    def __init__(self, board, pin):
        self.name, self.scale, start, _ = MOTORS[pin]
        self.board = board
        self.at_steps = start * self.scale
        self.home()

    def home(self):
        """As after power-on, but where it stands."""
        self.queue, self.last, self.direction, self.position = deque(), 0, 0, 0
        self.needs_reset = False
        self.trsync = None

    def run(self, now, steps):
        """Takes the steps that are due."""
        while self.queue:
            move = self.queue[0]
            due = self.board.unwrap(self.last + move[0])
            if due > now:
                return
            if now - due > FREQUENCY:
                raise Stopped("Stepper too far in past")
            self.last = due & MASK
            move[0] += move[2]
            move[1] -= 1
            up = move[3] == 0
            self.at_steps += 1 if up else -1
            self.position += -1 if up else 1
            steps.append((due, self.name, 1 if up else -1))
            if move[1] == 0:
                self.queue.popleft()


class Model:
    def __init__(self, pace, out):
        self.pace, self.out = pace, out
        self.identity = dictionary()
        self.words = Dictionary(self.identity)
        self.replies = {message.name: message for message in self.words.responses.values()}
        self.pins = {number: name for name, number in self.words.numbers("pin").items()}
        self.motors = {pin: Motor(self, pin) for pin in MOTORS}
        self.heat = {pin: REST_C for pin in HEATERS}
        self.steps = open(os.path.join(out, "steps.csv"), "w")
        self.steps.write("time_ns,actuator,direction\n")
        self.edges = 0
        self.sockets = [self.listen("debug (USART2)"), self.listen("the machine's state")]
        self.clients = [None, None]
        self.heard = self.said = 0
        self.now = self.zero = 0
        self.last_heat = self.last_stats = 0
        self.reset()

    def listen(self, name):
        listening = socket.create_server(("127.0.0.1", 0))
        listening.setblocking(False)
        print(f"{name} on tcp 127.0.0.1:{listening.getsockname()[1]}", file=sys.stderr, flush=True)
        return listening

    def reset(self):
        self.zero = self.now
        self.splitter, self.expected, self.out_bytes = Splitter(), 0, bytearray()
        self.noise = 0
        self.objects, self.duties, self.timers = {}, {}, []
        self.crc, self.is_config, self.reason = 0, 0, 0
        for motor in self.motors.values():
            motor.home()
        self.say("starting")

    @property
    def clock(self):
        return self.now - self.zero

    def unwrap(self, clock):
        near = self.clock
        return near + ((clock - near + (1 << 31)) & MASK) - (1 << 31)

    def say(self, name, **values):
        self.out_bytes += block(self.expected, self.replies[name].write(values))

    def stop(self, text):
        if not self.reason:
            self.reason = REASONS[text]
            self.duties, self.timers = {}, []
            for motor in self.motors.values():
                motor.queue.clear()
            self.say("shutdown", clock=self.clock & MASK, static_string_id=self.reason)

    def hear(self, data):
        for sequence, content in self.splitter.feed(data):
            if sequence == self.expected:
                for name, values in self.words.read(content, self.words.commands):
                    try:
                        self.obey(name, values)
                    except Stopped as reason:
                        self.stop(str(reason))
                    if name == "reset":
                        return
                self.expected = self.expected + 1 & 0xF
            self.out_bytes += block(self.expected)
        if self.splitter.noise > self.noise:
            self.noise = self.splitter.noise
            self.out_bytes += block(self.expected)

    def obey(self, name, values):
        action = getattr(self, f"do_{name}", None)
        if self.reason and name not in ("identify", "get_uptime", "get_clock", "get_config", "emergency_stop", "reset"):
            self.say("is_shutdown", static_string_id=self.reason)
        elif action:
            action(**values)
        elif name.startswith("config_"):
            self.objects[values["oid"]] = values

    def do_identify(self, offset, count):
        self.say("identify_response", offset=offset, data=self.identity[offset : offset + count])

    def do_get_uptime(self):
        self.say("uptime", high=self.clock >> 32, clock=self.clock & MASK)

    def do_get_clock(self):
        self.say("clock", clock=self.clock & MASK)

    def do_get_config(self):
        self.say("config", is_config=self.is_config, crc=self.crc, is_shutdown=int(bool(self.reason)), move_count=1024)

    def do_finalize_config(self, crc):
        self.crc, self.is_config = crc, 1

    def do_emergency_stop(self):
        raise Stopped("Command request")

    def do_reset(self):
        self.reset()

    def do_config_stepper(self, oid, step_pin, **_):
        self.objects[oid] = self.motors[self.pins[step_pin]]

    def do_queue_step(self, oid, interval, count, add):
        motor = self.objects[oid]
        if motor.needs_reset:
            return
        if not motor.queue and self.unwrap(motor.last + interval) < self.clock:
            raise Stopped("Timer too close")
        motor.queue.append([interval, count, add, motor.direction])

    def do_set_next_step_dir(self, oid, dir):
        self.objects[oid].direction = dir

    def do_reset_step_clock(self, oid, clock):
        self.objects[oid].last, self.objects[oid].needs_reset = clock, False

    def do_stepper_get_position(self, oid):
        self.say("stepper_position", oid=oid, pos=self.objects[oid].position)

    def do_stepper_stop_on_trigger(self, oid, trsync_oid):
        self.objects[oid].trsync = trsync_oid

    def do_trsync_start(self, oid, report_clock, report_ticks, expire_reason):
        self.objects[oid].update(armed=bool(report_ticks), expire=expire_reason, ticks=report_ticks, timeout=None)
        if report_ticks:
            self.at(report_clock, lambda: self.report(oid, report_clock))

    def report(self, oid, clock):
        trsync = self.objects[oid]
        if trsync["armed"]:
            self.say("trsync_state", oid=oid, can_trigger=1, trigger_reason=0, clock=clock & MASK)
            following = clock + trsync["ticks"]
            self.at(following, lambda: self.report(oid, following))

    def do_trsync_set_timeout(self, oid, clock):
        self.objects[oid]["timeout"] = clock
        self.at(clock, lambda: self.objects[oid]["timeout"] == clock and self.trigger(oid, self.objects[oid]["expire"], clock))

    def trigger(self, oid, reason, clock):
        trsync = self.objects[oid]
        if trsync["armed"]:
            trsync.update(armed=False, reason=reason)
            for motor in self.motors.values():
                if motor.trsync == oid:
                    motor.queue.clear()
                    motor.trsync, motor.needs_reset = None, True
            self.say("trsync_state", oid=oid, can_trigger=0, trigger_reason=reason, clock=clock & MASK)

    def do_trsync_trigger(self, oid, reason):
        trsync = self.objects[oid]
        if trsync["armed"]:
            self.trigger(oid, reason, 0)
        self.say("trsync_state", oid=oid, can_trigger=0, trigger_reason=trsync.get("reason", reason), clock=0)

    def level(self, pin):
        name = SWITCHES[self.pins[pin]]
        return int(any(motor.name == name and motor.at_steps <= 0 for motor in self.motors.values()))

    def do_endstop_home(self, oid, clock, rest_ticks, pin_value, trsync_oid, trigger_reason, sample_count, **_):
        stop = self.objects[oid]
        stop["homing"] = sample_count
        if sample_count:
            stop.update(wanted=pin_value, trsync=trsync_oid, reason=trigger_reason, rest=rest_ticks, next=clock)
            self.at(clock, lambda: self.look(oid, clock))

    def look(self, oid, clock):
        stop = self.objects[oid]
        if not stop.get("homing"):
            return
        following = clock + max(stop["rest"], 20_000)
        if self.level(stop["pin"]) == stop["wanted"]:
            stop.update(homing=0, next=clock + stop["rest"])
            self.trigger(stop["trsync"], stop["reason"], clock)
        else:
            self.at(following, lambda: self.look(oid, following))

    def do_endstop_query_state(self, oid):
        stop = self.objects[oid]
        homing, following = int(bool(stop.get("homing"))), stop.get("next", 0) & MASK
        self.say("endstop_state", oid=oid, homing=homing, next_clock=following, pin_value=self.level(stop["pin"]))

    def do_spi_transfer(self, oid, data):
        self.say("spi_transfer_response", oid=oid, response=bytes((4, 0, 0))[: len(data)])

    def do_set_digital_out_pwm_cycle(self, oid, cycle_ticks):
        self.objects[oid]["cycle"] = cycle_ticks

    def do_queue_digital_out(self, oid, clock, on_ticks):
        output = self.objects[oid]
        duty = min(1.0, on_ticks / output.get("cycle", 1))
        self.at(clock, lambda: self.duties.update({self.pins[output["pin"]]: duty}))

    def do_update_digital_out(self, oid, value):
        self.duties[self.pins[self.objects[oid]["pin"]]] = value

    def do_query_analog_in(self, oid, clock, sample_count, rest_ticks, **_):
        self.objects[oid].update(samples=sample_count, rest=rest_ticks)
        self.at(clock, lambda: self.sample(oid, clock))

    def sample(self, oid, clock):
        sensor = self.objects[oid]
        heater = next(pin for pin, (input, *_) in HEATERS.items() if input == self.pins[sensor["pin"]])
        celsius, beta = self.heat[heater], HEATERS[heater][-1]
        ohms = 100_000 * math.exp(beta * (1 / (celsius + 273.15) - 1 / 298.15))
        value = int(sensor["samples"] * 4095 * ohms / (ohms + 4700))
        following = clock + sensor["rest"]
        self.say("analog_in_state", oid=oid, next_clock=following & MASK, values=value.to_bytes(2, "little"))
        self.at(following, lambda: self.sample(oid, following))

    def at(self, clock, action):
        heapq.heappush(self.timers, (self.unwrap(clock & MASK), len(self.timers), id(action), action))

    def step_to(self, now):
        """Lets the board's time go on in slices of 100 us."""
        while self.now < now:
            self.now = min(now, self.now + FREQUENCY // 10_000)
            steps = []
            while self.timers and self.timers[0][0] <= self.clock:
                heapq.heappop(self.timers)[-1]()
            try:
                for motor in self.motors.values():
                    motor.run(self.clock, steps)
            except Stopped as reason:
                self.stop(str(reason))
            for due, name, direction in sorted(steps):
                self.steps.write(f"{(due + self.zero) * TICK_NS},{name},{direction}\n")
            self.edges += len(steps)
        seconds, self.last_heat = (self.now - self.last_heat) / FREQUENCY, self.now
        for pin, (_, power, loss, _) in HEATERS.items():
            self.heat[pin] += seconds * (power * self.duties.get(pin, 0) - loss * (self.heat[pin] - REST_C))
        if self.now - self.last_stats > 5 * FREQUENCY:
            self.last_stats = self.now
            self.say("stats", count=1, sum=1, sumsq=1)

    def state(self):
        heaters = {name: [self.heat[pin], self.duties.get(pin, 0)] for name, pin in (("hotend", "PE0"), ("bed", "PE3"))}
        tool = [motor.at_steps / motor.scale for motor in list(self.motors.values())[:3]]
        return json.dumps({"s": self.now / FREQUENCY, "tool": tool, "edges": self.edges, "heaters": heaters}) + "\n"

    def serve(self):
        for index, listening in enumerate(self.sockets):
            try:
                self.clients[index] = listening.accept()[0]
                self.clients[index].setblocking(False)
                self.clients[index].setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
            except BlockingIOError:
                pass
        for index, client in enumerate(self.clients):
            try:
                data = client.recv(4096) if client else b""
            except BlockingIOError:
                continue
            if data and index == 0:
                self.heard += len(data)
                self.hear(data)
            elif data:
                client.sendall(self.state().encode() * data.count(b"\n"))
        if self.out_bytes and self.clients[0]:
            try:
                self.said += len(self.out_bytes)
                self.clients[0].sendall(self.out_bytes)
            except OSError:
                self.clients[0] = None
        self.out_bytes.clear()

    def run(self, page):
        began = time.monotonic()
        poll = select.poll()
        poll.register(sys.stdout, 0)
        # That nobody takes its words any more ends it.
        while not poll.poll(0):
            if page is None:
                self.step_to(int((time.monotonic() - began) * self.pace * FREQUENCY))
                time.sleep(0.0005)
            elif page.may_go(self.now * TICK_NS, self.heard, self.said):
                self.step_to(self.now + FREQUENCY // 2000)
                page.tell(self.now * TICK_NS)
            self.serve()
        self.steps.close()


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--pace", type=float, default=1.0)
    parser.add_argument("--out", required=True)
    parser.add_argument("--clock-file")
    parser.add_argument("--clock-slot", type=int, default=0)
    options = parser.parse_args()
    os.makedirs(options.out, exist_ok=True)
    page = Page(options.clock_file, options.clock_slot) if options.clock_file else None
    Model(options.pace, options.out).run(page)


if __name__ == "__main__":
    main()
