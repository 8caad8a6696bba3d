"""PrusaSlicer without its window."""

import os
import re
import shutil
import subprocess

import pytest

FOUR_FILAMENTS = (
    *("--nozzle-diameter=0.4,0.4,0.4,0.4", "--filament-diameter=1.75,1.75,1.75,1.75", "--temperature=210,210,210,210"),
    *("--single-extruder-multi-material", "--layer-height=0.3", "--first-layer-height=0.3", "--fill-density=0%", "--skirts=0"),
)
"""A printer of four filaments and one nozzle, layers of 0.3 mm, no infill."""


def prusa_slicer(*arguments):
    """Run PrusaSlicer without its window."""
    if shutil.which("prusa-slicer") is None:
        assert "MECHSTYLE_SKIP_NOTHING" not in os.environ, "there is no prusa-slicer on PATH"
        pytest.skip("NO PRUSASLICER: painted files were NOT sliced; apt-get install --no-install-recommends prusa-slicer")
    subprocess.run(["prusa-slicer", *map(str, arguments)], capture_output=True, check=True)


def tools_by_height(gcode):
    """Which tools lay plastic at each height [mm]."""
    found, tool, height = {}, 0, 0.0
    for line in gcode.splitlines():
        if re.fullmatch(r"T\d", line):
            tool = int(line[1])
        elif place := re.search(r"^G1 Z([\d.]+)", line):
            height = float(place[1])
        elif re.search(r"^G1 X\S+ Y\S+ E[\d.]", line):
            found.setdefault(height, set()).add(tool)
    return found
