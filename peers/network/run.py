#!/usr/bin/env python3
"""The board on a network of Linux, a TAP device in a namespace of its own, and Debian's programs there.

    run.py OUT

Wants root, Linux, and Debian's dnsmasq-base, iputils-ping, inetutils-telnet, netcat-openbsd, nmap, dbus-daemon,
avahi-daemon and avahi-utils. What came of each step is printed, and written to OUT/summary.json. The system's own
services are left alone: avahi and its bus run in the namespace, with a /run of their own.
"""

import json
import os
import re
import shutil
import subprocess
import sys
import time

HERE = os.path.dirname(os.path.abspath(__file__))
sys.path.insert(0, os.path.join(os.path.dirname(HERE), "senders"))

from board import GRBL, ROOT, TELNET, Board, Failed, Steps, with_network

CONFIG = os.path.join(ROOT, "config/samples/cartesian.ini")
SPACE, DEVICE, OWN = "velvet-peers", "velvet0", "10.99.0.1"
WANTED = {"ip": "iproute2", "dnsmasq": "dnsmasq-base", "ping": "iputils-ping", "telnet": "inetutils-telnet", "nc": "netcat-openbsd", "nmap": "nmap",
          "dbus-daemon": "dbus-daemon", "avahi-daemon": "avahi-daemon", "avahi-browse": "avahi-utils"}
# Pings behind those that count, a second of them.
BEHIND = 20
CLOSED = "\n[network]\nenable = true\n"


def call(*command, text=None, seconds=300):
    """What a program says, whatever it ends with; this process is in the namespace already."""
    done = subprocess.run(command, input=text, capture_output=True, text=True, timeout=seconds, check=False)
    return done.stdout + done.stderr


def enter():
    """Goes on in a namespace that lives as long as this process and its children do."""
    if os.environ.get("VELVET_PEERS_SPACE") != SPACE:
        os.execvpe("unshare", ["unshare", "--net", "--mount", sys.executable, *sys.argv], {**os.environ, "VELVET_PEERS_SPACE": SPACE})
    for line in ("link set lo up", f"tuntap add dev {DEVICE} mode tap", f"addr add {OWN}/24 dev {DEVICE}", f"link set {DEVICE} up"):
        subprocess.run(["ip", *line.split()], check=True)
    subprocess.run(["mount", "-t", "tmpfs", "tmpfs", "/run"], check=True)


def announce(out):
    """A bus and avahi, which looks for names on the device."""
    for folder in ("/run/dbus", "/run/avahi-daemon"):
        os.makedirs(folder)
    settings = os.path.join(out, "avahi.conf")
    with open(settings, "w") as file:
        file.write(f"[server]\nhost-name=desk\nuse-ipv6=no\nallow-interfaces={DEVICE}\n")
    bus = subprocess.Popen(["dbus-daemon", "--system", "--nofork", "--nopidfile"], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    path = os.path.join(out, "avahi.log")
    for _ in range(100):
        if os.path.exists("/run/dbus/system_bus_socket"):
            break
        time.sleep(0.2)
    with open(path, "w") as log:
        avahi = subprocess.Popen(["avahi-daemon", "--no-drop-root", "--no-chroot", "--no-rlimits", "-f", settings], stdout=log, stderr=log)
    for _ in range(100):
        if "startup complete" in open(path).read():
            break
        time.sleep(0.2)
    return [avahi, bus]


def serve(out):
    """Debian's server for addresses and names, with files of its own."""
    return subprocess.Popen(["dnsmasq", "--keep-in-foreground", "--conf-file=/dev/null", "--no-resolv", "--no-hosts", "--user=root", f"--interface={DEVICE}",
                             "--except-interface=lo", "--bind-interfaces", "--pid-file=", "--dhcp-authoritative", "--dhcp-range=10.99.0.50,10.99.0.60,1h",
                             f"--dhcp-leasefile={lease_file(out)}"], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)


def lease_file(out):
    return os.path.join(out, "leases")


def lease(out):
    """The lease of the server's file: address and name."""
    try:
        with open(lease_file(out)) as file:
            words = file.read().split()
    except FileNotFoundError:
        words = []
    return (words[2], words[3]) if len(words) > 3 else None


def start(out, name, section=None):
    if os.path.exists(lease_file(out)):
        os.remove(lease_file(out))
    server = serve(out)
    config = with_network(CONFIG, out, name, section) if section else with_network(CONFIG, out, name)
    board = Board(config, out, name, arguments=["--tap", DEVICE])
    board.until("a lease", lambda _: lease(out), 40)
    board.until("the address in use", lambda s, begun=board.state()["s"]: s["s"] > begun + 4, 10)
    return server, board, lease(out)


def expect(is_so, words):
    if not is_so:
        raise Failed(words)


def pings(address, count, size):
    """How many of the first pings are answered; those behind them give the answers time. Ping itself waits for the last
    answer no longer than two others took, and the virtual board may stand still for longer on a busy computer."""
    said = call("ping", "-n", "-c", str(count + BEHIND), "-i", "0.05", "-s", str(size), "-W", "2", address)
    got = len({number for number in map(int, re.findall(r"icmp_seq=(\d+)", said)) if number <= count})
    times = re.search(r"= ([\d.]+)/([\d.]+)/([\d.]+)", said)
    return got, f"{got} of {count} answered; {times.group(2) + ' ms at the mean' if times else 'none'}"


def all_of(count, address, size):
    got, note = pings(address, count, size)
    expect(got == count, note)
    return note


def dropped(address):
    """Packets in fragments are not put together again: docs/network.md says so."""
    got, note = pings(address, 3, 3000)
    expect(got == 0, note)
    return f"{note}: it comes in fragments, which the board drops"


def talk(address, port, text, wait=4.0):
    """What the board answers to text by nc, which ends its own direction behind it."""
    said = call("nc", "-N", "-w", str(int(wait)), address, str(port), text=text)
    return said


def open_ports(address):
    return sorted(int(port) for port in re.findall(r"^(\d+)/tcp +open", call("nmap", "-n", "-Pn", "-p-", "-T4", "--min-rate", "2000", address), re.M))


def telnet(address):
    """Telnet wants its input open until the answers are there."""
    process = subprocess.Popen(["telnet", address, str(TELNET)], stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
    for line in ("", "M115", "M105", "net"):
        time.sleep(1)
        process.stdin.write(line + "\n")
        process.stdin.flush()
    time.sleep(2)
    process.kill()
    said = process.communicate()[0]
    expect("FIRMWARE_NAME" in said and "T:" in said and "velvet.local" in said, said[-300:])
    return "M115, M105 and net are answered"


def half_closed(address):
    said = talk(address, TELNET, "M115\n" + "M105\n" * 20)
    answers = len(re.findall(r"^.*ok B:.* T:", said, re.M))
    expect("FIRMWARE_NAME" in said and answers == 20, f"{answers} answers of 20: {said}")
    return "M115 and 20 times M105, all answered behind the end of the input"


def found_by_avahi(address):
    """Services of the board, by name and port, and its name's address."""
    seen = call("avahi-browse", "--all", "--no-db-lookup", "--resolve", "--parsable", "--terminate", seconds=60)
    rows = [line.split(";") for line in seen.splitlines() if line.startswith("=")]
    services = {(row[4], int(row[8])) for row in rows if row[6] == "velvet.local" and row[7] == address}
    expect(("_telnet._tcp", TELNET) in services, f"avahi-browse: {seen}")
    resolved = call("avahi-resolve", "-4", "--name", "velvet.local", seconds=30).split()
    expect(resolved[-1:] == [address], f"avahi-resolve: {resolved}")
    backwards = call("avahi-resolve", "--address", address, seconds=30).split()
    return f"{', '.join(f'{kind} at {port}' for kind, port in sorted(services))}; velvet.local is {address}, which is {backwards[-1]}"


def datagram_ports(address):
    """Ports for datagrams that nmap finds open or silent: those of mDNS, DHCP's client, DNS, NTP."""
    said = call("nmap", "-n", "-Pn", "-sU", "-p", "53,67,68,69,123,161,1900,5353", "--max-retries", "2", address)
    rows = re.findall(r"^(\d+)/udp +(\S+)", said, re.M)
    expect({int(port) for port, state in rows if state != "closed"} <= {68, 5353}, said)
    return ", ".join(f"{port} {state}" for port, state in rows)


def ports_are(address, wanted):
    found = open_ports(address)
    expect(found == wanted, f"open: {found}")
    return f"of 65,535 TCP ports open: {found or 'none'}"


def prodded(board, address):
    # Port 9 answers nobody; the rest of the options make nmap try versions and the system.
    call("nmap", "-n", "-Pn", "-sV", "-O", "-p", f"{TELNET},{GRBL},9", address, seconds=400)
    said = ""
    for _ in range(10):
        said = talk(address, TELNET, "get steps\nM105\n")
        if "T:" in said:
            break
        time.sleep(5)
    expect("T:" in said, f"no answer after it: {said[-200:]}")
    late = re.search(r"steps late: \d+", said)
    return f"answers after it; {late.group(0) if late else said[-120:]}"


def main():
    out = os.path.abspath(sys.argv[1])
    lacking = [package for program, package in WANTED.items() if not shutil.which(program)]
    if lacking or os.geteuid() != 0 or not os.path.exists("/dev/net/tun"):
        print(f"skipped: wants root, /dev/net/tun and {' '.join(lacking) or 'nothing else'} (apt-get install --no-install-recommends {' '.join(lacking)})")
        return 0
    enter()
    os.makedirs(out, exist_ok=True)
    steps = Steps("network")
    server, board, (address, name) = start(out, "network")
    try:
        steps.step("lease", lambda: f"{address}, told the name {name}")
        for count, size in ((10, 56), (10, 1400), (100, 56)):
            steps.step(f"ping {size}", lambda count=count, size=size: all_of(count, address, size))
        steps.step("ping 3000", lambda: dropped(address))
        steps.step("telnet", lambda: telnet(address))
        steps.step("nc", lambda: half_closed(address))
        helpers = announce(out)
        steps.step("avahi", lambda: found_by_avahi(address))
        for helper in helpers:
            helper.kill()
            helper.wait()
        steps.step("nmap -sU", lambda: datagram_ports(address))
        steps.step("nmap", lambda: ports_are(address, [TELNET, GRBL]))
        steps.step("nmap -sV -O", lambda: prodded(board, address))
    finally:
        board.close()
        server.kill()
        server.wait()
    server, board, (address, _) = start(out, "closed", CLOSED)
    try:
        steps.step("nothing on", lambda: ports_are(address, []))
    finally:
        board.close()
        server.kill()
    with open(os.path.join(out, "summary.json"), "w") as file:
        json.dump(steps.rows, file, indent=1)
    return 1 if any(row["passed"] is False for row in steps.rows) else 0


if __name__ == "__main__":
    sys.exit(main())
