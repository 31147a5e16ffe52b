"""What the host is asked to do, and what the machine must have done by then. Each takes a desk and returns a note."""

import math
import os
import time

import benchmark
from host import Refused

# Distance between where the host believes the tool and where it is, millimetres.
NEAR_MM = 0.05
NEAR_C = 3.0
HOMING_S, PRINT_S = 120, 7200
# Pace of two boards on one computer.
PACE_OF_TWO = 0.1
# Time in which motors stand when the board with their end stop has died.
LOST_S = 0.06


def expect(is_so, text):
    if not is_so:
        raise Refused(text)


def truth(desk):
    return desk.boards[0].watch.state()


def at_place(desk, x, y, z, of_z=0):
    """Holds the true place of the tool against where it was sent; `of_z` is the board whose carriage is Z."""
    tool = truth(desk)["tool"][:2] + desk.boards[of_z].watch.state()["tool"][2:]
    off = max(abs(one - other) for one, other in zip(tool, (x, y, z)))
    expect(off < NEAR_MM, f"the tool is at {tool}, not at {(x, y, z)}")
    return off


def connect(desk):
    desk.connect()
    host = desk.host
    mcu = host.query(mcu=None)["mcu"]
    for motor in ("stepper_x", "stepper_y", "stepper_z", "extruder"):
        host.run(f"DUMP_TMC STEPPER={motor}", 30)
    return f"{mcu['mcu_version']}, {len(mcu['mcu_constants'])} constants"


def home(desk):
    host = desk.connect()
    host.run("G28", HOMING_S)
    axes = host.query(toolhead=["homed_axes"])["toolhead"]["homed_axes"]
    expect(axes == "xyz", f"homed are {axes!r}")
    host.run("G1 Z10 F600\nG1 X100 Y60 F9000\nM400", HOMING_S)
    return f"{at_place(desk, 100, 60, 10):.3f} mm off"


def heat(desk):
    host = desk.connect()
    host.run("M140 S40\nM104 S80\nM109 S80\nM190 S40", 600)
    heaters = truth(desk)["heaters"]
    for name, celsius in (("hotend", 80), ("bed", 40)):
        expect(abs(heaters[name][0] - celsius) < NEAR_C, f"{name} is at {heaters[name][0]} C, not at {celsius}")
    host.run("M104 S0\nM140 S0\nG4 P6000", 60)
    duties = {name: heater[1] for name, heater in truth(desk)["heaters"].items()}
    expect(max(duties.values()) < 0.01, f"still heated: {duties}")
    return f"hot end {heaters['hotend'][0]:.1f} C, bed {heaters['bed'][0]:.1f} C"


def mesh(desk):
    host = desk.connect()
    host.run("G28\nG1 Z5 F600\nBED_MESH_CALIBRATE", 600)
    matrix = host.query(bed_mesh=["probed_matrix"])["bed_mesh"]["probed_matrix"]
    heights = [height for row in matrix for height in row]
    expect(len(heights) == 9, f"a mesh of {len(heights)} points")
    worst = max(map(abs, heights))
    expect(worst < NEAR_MM, f"the level bed is {worst:.3f} mm off")
    return f"9 points, {worst:.3f} mm at most"


def small_print(path):
    """Three layers of a ring with a pocket of straight lines: arcs of short moves, corners and retractions."""
    out = ["G21", "G90", "M83", "G92 E0"]
    for layer in range(1, 4):
        out.append(f"G1 Z{0.2 * layer:.2f} F600")
        out.append("G1 X112 Y100 F9000\nG1 E1 F2400")
        for side in range(1, 73):
            angle = 2 * math.pi * side / 72
            out.append(f"G1 X{100 + 12 * math.cos(angle):.3f} Y{100 + 12 * math.sin(angle):.3f} E0.035 F3000")
        for row in range(8):
            y = 93 + 2 * row
            x = (94, 106) if row % 2 else (106, 94)
            out.append(f"G1 X{x[0]} Y{y} F9000\nG1 X{x[1]} Y{y} E0.4 F4800")
        out.append("G1 E-1 F2400")
    out.append("G1 Z10 F600\nG1 X20 Y180 F9000\nM107")
    with open(path, "w") as file:
        file.write("\n".join(out) + "\n")


def put_file(desk):
    """Puts the file to print where the host looks for it: as its own copy, for it may be compressed."""
    path = os.path.join(desk.folder, "part.gcode")
    if not desk.options.gcode:
        small_print(path)
        return (20, 180, 10)
    import gzip

    opened = gzip.open if desk.options.gcode.endswith(".gz") else open
    with opened(desk.options.gcode, "rb") as source, open(path, "wb") as copy:
        copy.write(source.read())
    return None


def follow_print(desk):
    """Waits for the end of a print, and shows how far it is."""
    host, shown, began = desk.host, -1, time.monotonic()
    while True:
        status = host.query(print_stats=None, virtual_sdcard=None)
        stats, progress = status["print_stats"], int(100 * status["virtual_sdcard"]["progress"])
        if progress // 5 > shown // 5:
            print(f"   {progress} %, {stats['print_duration']:.0f} s, board at {truth(desk)['s']:.0f} s", flush=True)
            shown = progress
        if stats["state"] == "complete":
            return stats
        expect(stats["state"] in ("printing", "standby"), f"the print is {stats['state']}: {stats['message']}")
        expect(time.monotonic() - began < PRINT_S / desk.pace, "the print does not end")
        time.sleep(0.5)


COLD = "\n[extruder]\nmin_extrude_temp: 5\n"


def print_file(desk, of_z=0):
    end = put_file(desk)
    desk.host.run("G28", HOMING_S)
    desk.host.run("SDCARD_PRINT_FILE FILENAME=part.gcode", 60)
    stats = follow_print(desk)
    desk.host.run("M400", 60)
    off = f", {at_place(desk, *end, of_z):.3f} mm off" if end else ""
    return f"{stats['filament_used']:.1f} mm of filament{off}"


def print_part(desk):
    desk.connect(COLD if not desk.options.gcode else "")
    return print_file(desk)


def stop(desk):
    """The computer of the host stands for a second of the board's time while it moves and heats."""
    desk.leave_clock()
    host = desk.connect()
    host.run("G28\nM104 S60", HOMING_S)
    desk.may_be_late = True
    try:
        host.api.socket.sendall(b'{"id":0,"method":"gcode/script","params":{"script":"G1 X190 Y190 F600"}}\x03')
        time.sleep(2 / desk.pace)
        host.stand(1 / desk.pace)
        host.wait("shutdown", 20 / desk.pace)
    except Refused as reason:
        expect("not shutdown but shutdown" in str(reason), str(reason))
    message = host.info()["state_message"].strip().splitlines()[0]
    time.sleep(0.3 / desk.pace)
    edges = truth(desk)["edges"]
    # What the machine tells is a mean over about a second.
    time.sleep(6 / desk.pace)
    expect(truth(desk)["edges"] == edges, "motors still run after the shutdown")
    duties = {name: heater[1] for name, heater in truth(desk)["heaters"].items()}
    expect(max(duties.values()) < 0.01, f"still heated after the shutdown: {duties}")
    try:
        host.api.ask("gcode/firmware_restart", 10)
    except Refused:
        pass
    time.sleep(2)
    host.wait("ready", 60 * (1 + 1 / desk.pace))
    host.run("G28", HOMING_S)
    return message


def add_two(desk, z_endstop):
    """Two boards, Z and the extruder on the second one; the end stop of Z is where it is said. A host that is ready."""
    desk.add_board("first")
    second = desk.add_board("second")
    more = f"{COLD}\n[mcu second]\nserial: {second.serial}\nbaud: 250000\n"
    for section, step, turn, select in (("stepper_z", "PG3", "PG4", "PG7"), ("extruder", "PC6", "PG5", "PG6")):
        more += f"\n[{section}]\nstep_pin: second:{step}\ndir_pin: !second:{turn}\nenable_pin: !second:PH13\n"
        more += f"\n[tmc2660 {section}]\ncs_pin: second:{select}\n"
    return desk.start_host(more + f"\n[stepper_z]\nendstop_pin: ^{z_endstop}\n")


def two(desk):
    """Z and the extruder on a second board; one host for both."""
    desk.slow_down(PACE_OF_TWO)
    add_two(desk, "second:PI0")
    return print_file(desk, of_z=1)


def lost(desk):
    """The board with the end stop dies while motors of the other one look for it: they stand, though the host cannot help."""
    desk.slow_down(PACE_OF_TWO)
    desk.checks_steps, desk.may_be_late = False, True
    host = add_two(desk, "PI0")
    first, second = desk.boards
    edges = lambda: second.watch.state()["edges"]
    host.api.socket.sendall(b'{"id":0,"method":"gcode/script","params":{"script":"G28 Z"}}\x03')
    began = edges()
    while edges() < began + 1000:
        time.sleep(0.001)
    at = second.watch.state()
    first.process.kill()
    if desk.page:
        desk.options.clock.forget_board(desk.page, 0)
    # The trigger's time-out of several boards is 25 ms; as much again for what was on its way.
    while second.watch.state()["s"] < at["s"] + LOST_S:
        time.sleep(0.01)
    then = edges()
    expect(then > began + 100, "the motors did not move")
    time.sleep(0.5 / desk.pace)
    expect(edges() == then, f"motors still run {LOST_S} s after the other board's death")
    try:
        host.wait("shutdown", 30 / desk.pace)
    except Refused as reason:
        expect("shutdown" in str(reason), str(reason))
    return f"{then - at['edges']} edges of 4000 a second after its death"


def bench(desk):
    """Klipper's own measure of how fast a board can step: the least ticks between steps, of one motor and of three."""
    desk.checks_steps = False
    board = desk.add_board()
    return benchmark.run(board.serial)


SCENARIOS = {
    "connect": connect, "home": home, "heat": heat, "mesh": mesh, "print": print_part, "benchmark": bench, "stop": stop, "two": two,
    "lost": lost,
}
