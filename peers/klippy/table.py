"""Figures of a scenario, and the table of all of them."""

import os
import re

from steps import compare, margins_s

COLUMNS = [
    ("scenario", "name", 10), ("commands", "commands", 9), ("naks", "naks", 5), ("again B", "retransmitted", 8), ("late", "late", 5),
    ("margin ms", "margin_ms", 10), ("steps", "steps", 9), ("worst ns", "worst_ns", 9), ("mean ns", "mean_ns", 8), ("result", "result", 7),
]
STATS = re.compile(r"bytes_retransmit=(\d+) bytes_invalid=(\d+)")


def host_counts(log):
    """Bytes sent again, and bytes that the host could not read, by its own count: of each connection the last one told."""
    again = invalid = 0
    if not os.path.exists(log):
        return again, invalid
    with open(log, errors="replace") as file:
        last = {}
        for line in file:
            if line.startswith("Stats "):
                for index, (one, other) in enumerate(STATS.findall(line)):
                    one, other = int(one), int(other)
                    # A connection that begins anew counts from zero.
                    if index in last and one < last[index][0]:
                        again, invalid = again + last[index][0], invalid + last[index][1]
                    last[index] = (one, other)
    return again + sum(one for one, _ in last.values()), invalid + sum(other for _, other in last.values())


def of_board(board, desk, row):
    """Adds what one board has been told and has done."""
    comparison, reader = compare(os.path.join(board.folder, "wire.bin"), os.path.join(board.folder, "steps.csv"))
    tick_ns = comparison.tick_ns
    margins = list(margins_s(reader, tick_ns))
    row["commands"] += reader.commands
    row["naks"] += reader.naks
    row["moves"] += len(margins)
    row["late"] += sum(margin < 0 for margin in margins)
    if margins:
        least = 1e3 * min(margins)
        row["margin_ms"] = least if row["margin_ms"] is None else min(row["margin_ms"], least)
    if desk.checks_steps:
        row["steps"] += comparison.count
        row["cut"] += comparison.cut
        row["sum_ns"] += comparison.sum_ns
        row["worst_ns"] = max(row["worst_ns"], comparison.worst_ns)
        row["reasons"] += [f"{board.name}: {text}" for text in comparison.wrong[:10]]


def figures(name, desk, failure, note):
    row = {"name": name, "note": note, "reasons": [failure] if failure else [], "margin_ms": None}
    row |= dict.fromkeys(("commands", "naks", "moves", "late", "steps", "cut", "sum_ns", "worst_ns"), 0)
    for board in desk.boards:
        try:
            of_board(board, desk, row)
        except (OSError, KeyError, IndexError, ValueError) as error:
            row["reasons"].append(f"{board.name}: its files cannot be read: {error!r}")
    row["retransmitted"], row["invalid"] = host_counts(os.path.join(desk.folder, "klippy.log"))
    if row["late"] and not desk.may_be_late:
        row["reasons"].append(f"{row['late']} commands came after their time")
    row["mean_ns"] = row["sum_ns"] / row["steps"] if row["steps"] else 0.0
    row["result"] = "FAIL" if row["reasons"] else "PASS"
    return row


def cell(value, width):
    if value is None:
        return "-".rjust(width)
    if isinstance(value, float):
        value = f"{value:.1f}"
    return str(value).rjust(width) if not isinstance(value, str) or value[0].isdigit() or value[0] == "-" else value.ljust(width)


def table(rows):
    lines = [" ".join(title.rjust(width) if 0 < index < len(COLUMNS) - 1 else title.ljust(width)
                      for index, (title, _, width) in enumerate(COLUMNS)) + " note"]
    for row in rows:
        lines.append(" ".join(cell(row[key], width) for _, key, width in COLUMNS) + f" {row['note']}")
    return lines
