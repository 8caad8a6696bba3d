"""The worker: killed whatever happens here, and every way it can fail said in words."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import tempfile

import numpy as np
import pytest
from manifold3d import Manifold

from mechstyle.errors import SimulationFailed
from mechstyle.geometry.remeshing import tetwild as module
from mechstyle.geometry.remeshing.evening import surface_of
from mechstyle.geometry.remeshing.tetwild import Settings, tetwild
from mechstyle.geometry.worker import importable
from mechstyle.records.mesh import TetMesh


@pytest.fixture(scope="module")
def box():
    return surface_of(Manifold.cube((10.0, 20.0, 30.0)))


def run(box, **options):
    return tetwild(box.vertices, box.faces, Settings(8.0, 1e-3), timeout=60.0, **options)


def answering(monkeypatch, script):
    """Let another program stand in for the worker; it finds the answer's path in sys.argv[2]."""
    real = subprocess.Popen
    monkeypatch.setattr(module.subprocess, "Popen", lambda command, **options: real([command[0], "-c", script, *command[3:]], **options))


def test_a_box_is_filled(box):
    vertices, tets = run(box)
    assert np.abs(TetMesh(vertices, tets).volumes).sum() == pytest.approx(6000.0, rel=0.01)  # the envelope: .04 mm of 2200 mm²


def test_what_a_killed_process_left_is_removed_by_the_next_when_nobody_can_be_using_it(box, monkeypatch, tmp_path):
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    for name in ("mechstyle-mesh-new", "mechstyle-mesh-old", "else-old"):
        (tmp_path / name).mkdir()
        (tmp_path / name / "request.npz").touch()
    (tmp_path / "mechstyle-mesh-link").symlink_to(tmp_path / "else-old")
    for name in ("mechstyle-mesh-old", "mechstyle-mesh-link", "else-old"):
        os.utime(tmp_path / name, (0.0, 0.0), follow_symlinks=False)
    run(box)
    assert {path.name for path in tmp_path.iterdir()} == {"mechstyle-mesh-new", "mechstyle-mesh-link", "else-old"}
    assert (tmp_path / "else-old" / "request.npz").exists()


@pytest.mark.parametrize("interruption", [KeyboardInterrupt, SystemExit, RuntimeError])
def test_whatever_is_raised_here_kills_the_worker(box, monkeypatch, interruption):
    started = []

    def interrupted(process, *_, **__):
        started.append(process)
        raise interruption

    monkeypatch.setattr(subprocess.Popen, "communicate", interrupted)
    with pytest.raises(interruption):
        run(box)
    assert [process.returncode for process in started] == [-9]  # killed, and waited for: a zombie has no return code


def test_whoever_waits_may_end_it_and_is_asked_again_and_again(box, monkeypatch):
    """A run that is stopped while the part is meshed anew used to wait for that to end."""
    answering(monkeypatch, "import time; time.sleep(600)")
    looks = iter([False, False, True])

    def go_on():
        if next(looks):
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        run(box, go_on=go_on)
    assert next(looks, None) is None


@pytest.mark.skipif(sys.platform == "win32", reason="Windows limits no processor time")
def test_a_worker_that_waits_longer_than_it_may_compute_is_not_ended(box, monkeypatch):
    """A busy machine: parts were read or refused by what else it did."""
    answering(monkeypatch, "import sys, numpy; numpy.savez(sys.argv[2], vertices=numpy.eye(4, 3), tets=[[0, 1, 2, 3]])")
    assert len(tetwild(box.vertices, box.faces, Settings(8.0, 1e-3), timeout=1e-4)[1]) == 1, "it takes longer to start"


@pytest.mark.skipif(sys.platform == "win32", reason="Windows limits no processor time")
def test_a_worker_that_computes_too_long_is_ended(box):
    """By its own time, not the clock: where others compute as well, a part was refused that needs a tenth of its time."""
    with pytest.raises(SimulationFailed, match="stopped after 2 s of processor time"):
        tetwild(box.vertices, box.faces, Settings(0.3, 1e-3), timeout=2.0)


def test_where_a_system_has_no_signal_for_that_a_mesh_is_a_mesh(box, monkeypatch):
    """Windows: the signal's number was taken as 0 there, which is also how a worker ends that has done its work."""
    monkeypatch.delattr(signal, "SIGXCPU", raising=False)
    assert len(run(box)[1])


@pytest.mark.skipif(sys.platform == "win32", reason="Windows limits no processor time")
def test_a_limit_that_is_set_already_is_not_asked_to_be_raised():
    """A cluster's own limit for its users; asking for more than that ended every worker."""
    script = "import resource; resource.setrlimit(resource.RLIMIT_CPU, (60, 60)); "
    script += "from mechstyle.geometry.worker import limit_processor_time; limit_processor_time(300); "
    script += "print(resource.getrlimit(resource.RLIMIT_CPU))"
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=False, env=importable())
    assert done.stdout.strip() == "(60, 60)", done.stderr


def test_the_last_words_of_a_dead_worker_are_passed_on(box, monkeypatch):
    answering(monkeypatch, "import sys; sys.exit('first\\nno memory left')")
    with pytest.raises(SimulationFailed, match=r"exit code 1\): no memory left$"):
        run(box)


def test_a_worker_that_dies_in_silence_is_told(box, monkeypatch):
    answering(monkeypatch, "import os; os.abort()")
    with pytest.raises(SimulationFailed, match=r"exit code -6\): without a word$"):
        run(box)


@pytest.mark.parametrize("script", ["", "import sys; open(sys.argv[2], 'wb').write(b'PK cut off')"], ids=["no answer", "half an answer"])
def test_an_answer_that_is_not_there_is_told(box, monkeypatch, script):
    answering(monkeypatch, script)
    with pytest.raises(SimulationFailed, match="ended without leaving a mesh"):
        run(box)


def test_a_mesh_of_nothing_is_told(box, monkeypatch):
    answering(monkeypatch, "import sys, numpy; numpy.savez(sys.argv[2], vertices=numpy.zeros((0, 3)), tets=numpy.zeros((0, 4), int))")
    with pytest.raises(SimulationFailed, match="found nothing inside"):
        run(box)
