"""Where Warp keeps compiled kernels: a folder that cannot be written to stands in nobody's way."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

from support import ROOT

SAID = "cannot be written to, so kernels are compiled for this process alone: make it writable, or name another folder in WARP_CACHE_PATH"

PROGRAM = """
import json, os, subprocess, sys

refused, *more = sys.argv[1:]
allowed = os.access
os.access = lambda path, mode: allowed(path, mode) and not (mode == os.W_OK and refused and str(path).startswith(refused))

import warp._src.build
from mechstyle._warp import wp

@wp.kernel
def doubled(values: wp.array(dtype=float)):
    values[wp.tid()] = 2.0 * values[wp.tid()]

def compiled(*_, **__):
    raise AssertionError("compiled, though it was there")

if "no compiling" in more:
    warp._src.build.build_cpu = compiled
values = wp.array([1.0, 2.0], dtype=float, device="cpu")
wp.launch(doubled, 2, inputs=[values], device="cpu")
if "child" in more:
    subprocess.run([sys.executable, "-c", "import mechstyle_doubled", "", "no compiling"], check=True)
print(json.dumps([values.numpy().tolist(), wp.config.kernel_cache_dir]))
"""


@pytest.fixture
def launched(tmp_path):
    """Launches a kernel with a folder of kernels, in a process of its own; where each process kept it, and what was said."""
    (tmp_path / "mechstyle_doubled.py").write_text(PROGRAM, encoding="utf-8")  # a name as of this package's kernels

    def launch(folder: Path, *arguments: str) -> tuple[list[Path], list[str]]:
        environment = {**os.environ, "WARP_CACHE_PATH": str(folder), "PYTHONPATH": os.pathsep.join([str(ROOT), str(tmp_path)])}
        run = [sys.executable, "-c", "import mechstyle_doubled", *arguments]
        done = subprocess.run(run, env=environment, capture_output=True, text=True, check=False)
        assert done.returncode == 0, done.stderr
        answers = [json.loads(line) for line in done.stdout.splitlines()]
        assert all(values == [2.0, 4.0] for values, _ in answers)
        return [Path(place) for _, place in answers], done.stderr.splitlines()

    return launch


def test_without_a_folder_for_kernels_they_are_compiled_for_this_process_and_those_it_starts(launched, tmp_path):
    (tmp_path / "file").touch()  # in the folder's place it refuses the administrator, too
    (child, parent), said = launched(tmp_path / "file" / "kernels", "", "child")
    assert child == parent, "what a process it starts needs is compiled already"
    assert not parent.parent.exists(), "removed at the end"
    assert len(said) == 1
    assert said[0].startswith(str(tmp_path / "file" / "kernels"))
    assert said[0].endswith(SAID)


def test_a_folder_of_kernels_that_may_only_be_read_is_read(launched, tmp_path):
    kept = tmp_path / "kernels"
    assert launched(kept, "")[1] == []
    before = {path: path.read_bytes() for path in kept.rglob("*") if path.is_file()}
    for path in (kept, *kept.rglob("*")):
        path.chmod(0o555)
    (place,), said = launched(kept, str(kept), "no compiling")
    assert said == []
    assert not place.parent.exists()
    for path in (kept, *kept.rglob("*")):
        path.chmod(0o755)
    assert {path: path.read_bytes() for path in kept.rglob("*") if path.is_file()} == before


def test_an_empty_folder_that_may_only_be_read_is_told_of(launched, tmp_path):
    kept = tmp_path / "kernels"
    kept.mkdir()
    _, said = launched(kept, str(kept))
    assert len(said) == 1
    assert said[0].endswith(SAID)
