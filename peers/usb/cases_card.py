"""The card as a drive of the computer: Linux's usb-storage, sd and vfat, fsck.vfat and eject."""

import hashlib
import os
import random
import shutil

from bench import case, clean, expect, plug
from cases_board import ask

DISK, PORT = "/dev/sda", "/dev/ttyACM0"
BYTES = 4 << 20
# Written by the computer and played by the machine: there and back along X, a little along Y, and how many steps that is.
JOB = "G91\n" + "G1 X5 Y0.25 F6000\nG1 X-5 Y0.25\n" * 20 + "G90\n"
STEPS = 40 * (5 + 0.25) * 80


def md5(data):
    return hashlib.md5(data).hexdigest()


def lend(guest, board):
    """Has the machine lend its card, and waits until Linux sees it."""
    plug(guest, board, DISK)
    # A virtual board may be slow, and Linux gives up a command after 30 s.
    guest.do(f"echo 600 > /sys/block/sda/device/timeout; stty -F {PORT} raw -echo")
    expect(size(guest) == 0, "there is a medium before it is lent")
    mount(guest)


def size(guest):
    """Bytes of the medium that Linux sees; 0: there is none."""
    return int(guest.do(f"blockdev --getsize64 {DISK} 2> /dev/null || echo 0"))


def mount(guest):
    heard = ask(guest, PORT, "msc")
    guest.wait(f"[ $(blockdev --getsize64 {DISK} 2> /dev/null || echo 0) -gt 0 ]", 30)
    guest.do(f"mount -t vfat {DISK} /mnt")
    return heard


# The machine sets the count of free clusters to "unknown" when it writes, as it may (FAT 1.03, FSI_Free_Count): a hint that
# nobody keeps is better than a wrong one.
UNKNOWN = "Free cluster summary uninitialized"


def check(guest, known=()):
    """fsck.vfat on the card that is not mounted."""
    code, said = guest.run(f"fsck.fat -n {DISK}")
    # Its version, and what there is on the card; a word more is something amiss. The guest has no tables of characters.
    lines = [line for line in said.splitlines() if "codepage" not in line and "conversion" not in line and not line.startswith(tuple(known))]
    expect(code == 0 and len(lines) == 2, f"fsck.fat: exit code {code}: {' | '.join(lines)[-300:]}")
    return lines[-1].removeprefix(f"{DISK}: ")


def timed(guest, board, line):
    """Kilobytes a second of the board's clock that a copy of the file takes with this line."""
    began = board.state()["s"]
    guest.do(line, 600)
    return BYTES / (board.state()["s"] - began) / 1000


@case("card: a drive: files both ways, fsck, eject")
def drive(bench):
    folder = os.path.join(bench.out, "lent")
    shutil.rmtree(folder, ignore_errors=True)
    os.makedirs(folder)
    there, back = random.Random(5).randbytes(BYTES), random.Random(6).randbytes(BYTES)
    with open(os.path.join(folder, "there.bin"), "wb") as file:
        file.write(there)
    guest, board = bench.guest(), bench.board("drive", sd=folder)
    with open(os.path.join(guest.share, "back.bin"), "wb") as file:
        file.write(back)
    with open(os.path.join(guest.share, "from the computer.gcode"), "w") as file:
        file.write(JOB)
    try:
        lend(guest, board)
        refused = ask(guest, PORT, "ls /sd")
        expect("a computer uses the SD card over USB" in refused, f"ls while it is lent: {refused!r}")
        read = timed(guest, board, "cat /mnt/there.bin > /tmp/there.bin")
        found = guest.do("md5sum < /tmp/there.bin").split()[0]
        expect(found == md5(there), "a file of the card is another one on the computer")
        # As a user would: from here on it is a card that Linux has formatted.
        guest.do(f"umount /mnt && mkfs.fat -F 32 -n VELVET {DISK} > /dev/null 2>&1 && mount -t vfat {DISK} /mnt", 600)
        written = timed(guest, board, "cp /share/back.bin /mnt/back.bin && sync")
        guest.do("mkdir '/mnt/A folder with a name' && cp /share/*.gcode '/mnt/A folder with a name/' && umount /mnt")
        first = check(guest)
        clean(guest)
        guest.do(f"eject -s {DISK}")
        expect(size(guest) == 0, "the medium is still there behind eject")
        # It ends here unless the sum is right.
        ask(guest, PORT, "md5sum /sd/back.bin", end=f"{md5(back)} /sd/back.bin")
        begin = board.state()["edges"]
        ask(guest, PORT, 'play "/sd/A folder with a name/from the computer.gcode"')
        steps = board.rest(60, still=2.0)["edges"] - begin
        expect(steps == STEPS, f"the machine made {steps} steps of what Linux wrote, not {STEPS:.0f}")
        # And once more, without a reset: what the machine wrote is there, and the volume is whole.
        ask(guest, PORT, "cp /sd/back.bin /sd/copy.bin")
        mount(guest)
        found = guest.do("md5sum < /mnt/copy.bin; umount /mnt").split()[0]
        expect(found == md5(back), "the machine's copy is another one on the computer")
        second = check(guest, [UNKNOWN])
        guest.do(f"eject -s {DISK}")
        return (f"{BYTES >> 20} MiB there at {read:.0f} and back at {written:.0f} kB/s of the board's time, equal MD5 both ways; fsck.fat: {first}, and after the machine "
                f"wrote as well {second}; the {STEPS:.0f} steps of a file that Linux wrote")
    finally:
        board.close()
