"""PrusaSlicer without its window."""

import os
import re
import shutil
import subprocess

import pytest


def prusa_slicer(*arguments):
    """Run PrusaSlicer without its window."""
    if shutil.which("prusa-slicer") is None:
        assert "MECHSTYLE_SKIP_NOTHING" not in os.environ, "there is no prusa-slicer on PATH"
        pytest.skip("NO PRUSASLICER: painted files were NOT sliced; apt-get install --no-install-recommends prusa-slicer")
    subprocess.run(["prusa-slicer", *map(str, arguments)], capture_output=True, check=True)


def hours_in(gcode):
    """Printing time that a G-code says of itself [h]."""
    words = re.search(r"estimated printing time \(normal mode\) = (.*)", gcode)[1]
    hours = {"d": 24.0, "h": 1.0, "m": 1 / 60, "s": 1 / 3600}
    return sum(int(number) * hours[unit] for number, unit in re.findall(r"(\d+)([dhms])", words))
