"""How far one reads from a styled surface to its verdict: files that are entered, and calls that lead up the house."""

from __future__ import annotations

import ast
import sys
from functools import cache
from pathlib import Path

import numpy as np
import pytest

import mechstyle
from mechstyle.records.load_cases import Load, LoadCase, Patch, Support
from mechstyle.records.mesh import SurfaceMesh
from mechstyle.simulation import simulator as module
from support.dropped_block import simulator
from validation.meshes import box

ROOT = Path(mechstyle.__file__).parent
FILES, CLIMBS = 14, 8
DATA = ("records/mesh.py", "records/recipe.py", "records/simulation.py", "records/material.py", "records/load_cases.py")
"""Records: one reads their fields, not their code."""
PRESSED = LoadCase(
    name="pressed", supports=(Support(at="resting face"),), loads=(Load(at=Patch(near=(6.0, 5.0, 16.0, 3.0)), force=(0.0, 0.0, -5.0)),)
)


def place_of(path: str) -> str:
    """A file of the package as `room/file.py`, "" for any other."""
    return Path(path).relative_to(ROOT).as_posix() if path.startswith(str(ROOT)) else ""


@cache
def floor_of(place: str) -> int:
    """How many imports, one upon the other, a file stands on; those for types alone, or made when they are wanted, do not count."""
    imported = [node for node in ast.parse((ROOT / place).read_text()).body if isinstance(node, ast.ImportFrom)]
    names = [f"{node.module}.{alias.name}" for node in imported for alias in node.names] + [str(node.module) for node in imported]
    below = {f"{name.partition('.')[2].replace('.', '/')}.py" for name in names if name.startswith("mechstyle.")} - {place}
    return 1 + max((floor_of(one) for one in below if (ROOT / one).is_file()), default=0)


@pytest.fixture(scope="module")
def calls(tmp_path_factory):
    """The first call of every function on the way: its file, and the file that it is called from."""
    from mechstyle.loop.objects import Memo, Objects  # noqa: PLC0415 — after the walk has its names

    tets = box((4, 3, 4), (12.0, 10.0, 16.0))
    used, faces = np.unique(tets.boundary_faces, return_inverse=True)
    folder = tmp_path_factory.mktemp("walk")
    block, memo = (SurfaceMesh(tets.vertices[used], faces.reshape(-1, 3)), tets), Memo(folder / "memo", Objects(folder / "objects"))
    relief = np.where(block[0].vertices[:, 2] > 15.0, 0.3, 0.0).astype(np.float32)
    dropped = simulator(block, memo, window=0.05, orientations=1, loads=(PRESSED,))
    seen, found = set(), list[tuple[str, str]]()

    def entered(frame, event, _):
        code = frame.f_code
        if event != "call" or code in seen or code.co_name.startswith("<") or not place_of(code.co_filename):
            return
        seen.add(code)
        caller = frame.f_back
        while caller is not None and not place_of(caller.f_code.co_filename):
            caller = caller.f_back
        found.append((place_of(code.co_filename), "" if caller is None else place_of(caller.f_code.co_filename)))

    sys.setprofile(entered)
    try:
        verdict = dropped.judge(dropped.simulate(relief, thorough=True))
    finally:
        sys.setprofile(None)
    assert verdict.rows
    return found


def test_from_surface_to_verdict_few_files_are_entered(calls):
    """Those whose functions the simulator's room calls; what these do inside is read by who wants to know it."""
    room = "simulation/"
    entered = {place for place, caller in calls if place.startswith(room) or caller.startswith(room) or not caller} - set(DATA)
    assert Path(module.__file__).name in {Path(place).name for place in entered}
    assert len(entered) <= FILES, sorted(entered)


def test_from_surface_to_verdict_hardly_a_call_leads_up(calls):
    """A climb is a call of what stands on a higher floor than its caller: a function that was handed down."""
    climbs = [(place, caller) for place, caller in calls if caller and floor_of(place) > floor_of(caller)]
    assert len(climbs) <= CLIMBS, climbs
    assert floor_of("simulation/simulator.py") > floor_of("fea/drop.py") > floor_of("records/mesh.py")
