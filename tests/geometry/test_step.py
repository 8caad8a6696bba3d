"""STEP files: read with their own unit and axes; damaged ones refused; what to do without the extra."""

import importlib.util

import pytest

from mechstyle.geometry import step
from mechstyle.geometry.files import read
from support.part_files import put, refusal
from support.step_file import box_step


@pytest.mark.parametrize(("unit", "millimetres"), [("mm", 1.0), ("inch", 25.4)])
@pytest.mark.parametrize("suffix", step.SUFFIXES)
def test_a_box_is_read_in_its_unit_with_z_up(tmp_path, unit, millimetres, suffix):
    sides = [round(side / millimetres, 6) for side in (40.0, 30.0, 20.0)]
    part = read(put(tmp_path, f"box.{suffix}", box_step(sides, unit).encode())).mesh
    assert part.extents == pytest.approx((40.0, 30.0, 20.0), abs=1e-3)
    assert part.volume == pytest.approx(24_000.0, rel=1e-4)


@pytest.mark.slow
def test_what_is_damaged_is_refused_and_nothing_is_printed(tmp_path, capfd):
    whole = box_step((40.0, 30.0, 20.0))
    for damaged in (whole[:200], whole.replace("CLOSED_SHELL", "CLOSED_SHOE"), "ISO-10303-21;\nrubbish", "a letter", "\0" * 300):
        message = refusal(put(tmp_path, "box.step", damaged.encode()))
        assert "cannot be read as STEP: it is damaged" in message or "holds no triangles" in message
    assert capfd.readouterr() == ("", "")


def test_another_file_of_that_name_is_named(tmp_path):
    assert "is a web page" in refusal(put(tmp_path, "box.step", b"<html><body>log in</body></html>"))


def test_without_the_extra_one_is_told_what_to_do(tmp_path, monkeypatch):
    monkeypatch.setattr(importlib.util, "find_spec", lambda _name: None)
    assert "pip install 'mechstyle[step]'" in refusal(put(tmp_path, "box.step", box_step((40.0, 30.0, 20.0)).encode()))
