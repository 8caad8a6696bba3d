"""The path data of SVG 1.1 (section 8.3) as an outline of lines and Bézier curves."""

from __future__ import annotations

import math
import re

import numpy as np
from matplotlib.path import Path as Outline

_TOKEN = re.compile(r"[MmLlHhVvCcSsQqTtAaZz]|[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?")
_TAKES = {"M": 2, "L": 2, "H": 1, "V": 1, "C": 6, "S": 4, "Q": 4, "T": 2, "A": 7, "Z": 0}
_ARC = re.compile(r"[\s,]*([-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?)")
_FLAG = re.compile(r"[\s,]*([01])")
MOST_NUMBERS = 2_000_000

Point = complex


def outline_of_path(data: str) -> Outline:
    """The outline that path data describes; what follows a mistake in it is left out, as the standard asks.

    Raises:
        ValueError: If it has more than MOST_NUMBERS characters.
    """
    if len(data) > MOST_NUMBERS:
        raise ValueError("a path that long")
    pen = _Pen()
    at = 0
    for letter in re.finditer(r"([A-DF-Za-df-z])([^A-DF-Za-df-z]*)", data):  # e belongs to numbers
        command, arguments = letter[1], letter[2]
        takes = _TAKES.get(command.upper())
        if takes is None or (at == 0 and command.upper() != "M"):
            break
        numbers = _arc_numbers(arguments) if takes == 7 else [float(number) for number in _TOKEN.findall(arguments)]
        at += 1
        if takes == 0:
            pen.close()
            continue
        for start in range(0, len(numbers) - takes + 1, takes):
            following = {"M": "L", "m": "l"}.get(command, command) if start else command
            pen.go(following, numbers[start : start + takes])
    if not pen.codes:
        return Outline(np.zeros((0, 2)))
    return Outline(np.array([(point.real, point.imag) for point in pen.points]), pen.codes)


def _arc_numbers(text: str) -> list[float]:
    """The arguments of arcs, whose two flags may be written without a space after them."""
    numbers: list[float] = []
    at = 0
    while True:
        found = (_FLAG if len(numbers) % 7 in (3, 4) else _ARC).match(text, at)
        if found is None:
            return numbers
        numbers.append(float(found[1]))
        at = found.end()


class _Pen:
    """What was drawn so far; points are complex numbers."""

    def __init__(self) -> None:
        self.points: list[Point] = []
        self.codes: list[np.uint8] = []
        self._here = self._start = self._handle = 0j
        self._before = ""
        self._closed = False

    def go(self, command: str, n: list[float]) -> None:
        """One command with its arguments."""
        kind = command.upper()
        base = self._here if command.islower() else 0j
        if kind in "HV":
            along = base.real + n[0] if kind == "H" else base.imag + n[0]
            pairs = [complex(along, self._here.imag) if kind == "H" else complex(self._here.real, along)]
        else:
            pairs = [base + complex(x, y) for x, y in zip(n[-2::-2][::-1], n[-1::-2][::-1], strict=True)] if kind != "A" else []
        if self._closed and kind != "M":  # drawing goes on where the ring was closed
            self._add([self._here], Outline.MOVETO)
        self._closed = False
        if kind == "M":
            self._add(pairs, Outline.MOVETO)
            self._start = pairs[0]
        elif kind in "LHV":
            self._add(pairs, Outline.LINETO)
        elif kind in "CS":
            mirrored = 2.0 * self._here - self._handle if self._before in "CS" and self._before else self._here
            first, second, end = pairs if kind == "C" else (mirrored, *pairs)
            self._add([first, second, end], Outline.CURVE4)
            self._handle = second
        elif kind in "QT":
            mirrored = 2.0 * self._here - self._handle if self._before in "QT" and self._before else self._here
            middle, end = pairs if kind == "Q" else (mirrored, *pairs)
            self._add([middle, end], Outline.CURVE3)
            self._handle = middle
        else:
            self._arc(n, base + complex(n[5], n[6]))
        self._before = kind

    def close(self) -> None:
        """Back to where the ring began."""
        if self.codes:
            self._add([self._start], Outline.CLOSEPOLY)
            self._closed, self._before = True, "Z"

    def _add(self, points: list[Point], code: np.uint8) -> None:
        self.points += points
        self.codes += [code] * len(points)
        self._here = points[-1]

    def _arc(self, n: list[float], end: Point) -> None:
        """An elliptical arc as Bézier curves of at most a quarter turn (SVG 1.1, appendix F.6)."""
        rx, ry, start = abs(n[0]), abs(n[1]), self._here
        if min(rx, ry) == 0.0 or start == end:
            self._add([end], Outline.LINETO)
            return
        turn = complex(math.cos(math.radians(n[2])), math.sin(math.radians(n[2])))
        half = (start - end) / 2.0 / turn
        stretch = math.hypot(half.real / rx, half.imag / ry)
        rx, ry = rx * max(stretch, 1.0), ry * max(stretch, 1.0)
        one = complex(half.real / rx, half.imag / ry)  # half the chord on the unit circle
        apart = math.sqrt(max(1.0 / max(abs(one) ** 2, 1e-30) - 1.0, 0.0)) * (-1.0 if bool(n[3]) == bool(n[4]) else 1.0)
        middle = apart * complex(one.imag, -one.real)
        first, last = one - middle, -one - middle
        sweep = math.atan2((last / first).imag, (last / first).real)
        sweep += 2.0 * math.pi * ((n[4] == 1.0 and sweep < 0.0) - (n[4] == 0.0 and sweep > 0.0))
        pieces = max(math.ceil(abs(sweep) / (math.pi / 2.0) - 1e-9), 1)
        reach = 4.0 / 3.0 * math.tan(sweep / pieces / 4.0)
        centre = (start + end) / 2.0 + turn * complex(middle.real * rx, middle.imag * ry)
        angle = math.atan2(first.imag, first.real)
        for piece in range(pieces):
            begins, ends = (angle + sweep * (piece + step) / pieces for step in (0, 1))
            a, b = (complex(math.cos(one), math.sin(one)) for one in (begins, ends))
            controls = [a + reach * 1j * a, b - reach * 1j * b, b]
            self._add([centre + turn * complex(point.real * rx, point.imag * ry) for point in controls], Outline.CURVE4)
        self.points[-1] = self._here = end
