#!/usr/bin/env python3
"""Writes ribbon-vase.stl: a small vase whose wall hangs in folds like a velvet ribbon.

The wall is one closed curve at every height: a circle of radius `profile(z)` with FOLDS soft waves that grow and turn
on the way up. Standard library only; the same numbers give the same file, byte for byte.

    python3 ribbon_vase.py ribbon-vase.stl
"""

import math
import struct
import sys

HEIGHT_MM = 18.0
FOLDS = 7
TWIST_DEGREES = 80.0
AROUND = 210  # A multiple of FOLDS, so that every fold has the same facets.
UPWARD = 45


def smooth(t):
    """0 to 1 with level ends."""
    return t * t * (3.0 - 2.0 * t)


def profile(t):
    """Mean radius in mm at relative height t: a foot, a waist at a third, a flaring lip."""
    foot, waist, lip = 8.0, 6.6, 9.6
    if t < 0.35:
        return foot + (waist - foot) * smooth(t / 0.35)
    return waist + (lip - waist) * smooth((t - 0.35) / 0.65)


def depth(t):
    """Depth of the folds in mm: shallow at the foot, deep at the lip."""
    return 0.35 + 1.25 * t**1.4


def point(around, up):
    t = up / UPWARD
    angle = 2.0 * math.pi * around / AROUND
    wave = FOLDS * (angle - math.radians(TWIST_DEGREES) * t)
    # A second harmonic leans the folds over, as cloth does.
    radius = profile(t) + depth(t) * (math.cos(wave) + 0.18 * math.cos(2.0 * wave + 0.9))
    return (radius * math.cos(angle), radius * math.sin(angle), HEIGHT_MM * t)


def triangles():
    rings = [[point(a, u) for a in range(AROUND)] for u in range(UPWARD + 1)]
    for low, high in zip(rings, rings[1:]):
        for a in range(AROUND):
            b = (a + 1) % AROUND
            yield low[a], low[b], high[b]
            yield low[a], high[b], high[a]
    bottom, top = (0.0, 0.0, 0.0), (0.0, 0.0, HEIGHT_MM)
    for a in range(AROUND):
        b = (a + 1) % AROUND
        yield bottom, rings[0][b], rings[0][a]
        yield top, rings[-1][a], rings[-1][b]


def main(path):
    facets = list(triangles())
    with open(path, "wb") as stl:
        stl.write(b"ribbon vase, mm".ljust(80))
        stl.write(struct.pack("<I", len(facets)))
        for corners in facets:
            # Readers compute the normal from the corners when it is zero.
            stl.write(struct.pack("<12fH", 0, 0, 0, *(c for corner in corners for c in corner), 0))


if __name__ == "__main__":
    main(sys.argv[1] if len(sys.argv) > 1 else "ribbon-vase.stl")
