"""fTetWild (Hu et al. 2020) as a function that can be interrupted."""

from __future__ import annotations

import contextlib
import os
import shutil
import signal
import subprocess
import sys
import tempfile
import zipfile
from pathlib import Path
from time import monotonic, time
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from mechstyle.errors import SimulationFailed
from mechstyle.geometry.going_on import GoOn, regardless
from mechstyle.records.mesh import Floats

GRACE = 10.0  # seconds after the limit at which an orphaned worker ends itself
LOOK = 0.2  # seconds between two looks whether to go on
PATIENCE = 4.0
"""The clock may run on for so many times what the processor may: on a busy machine a part was refused that takes a tenth of its time."""

FOLDER = "mechstyle-mesh-"
"""How the temporary folders of workers are called."""
ABANDONED = 86400.0
"""Age [s] of such a folder at which nobody works in it any more: what was killed cannot remove its own."""


class Settings(NamedTuple):
    """Settings of an fTetWild run.

    Attributes:
        edge_length: Edge length it aims at [mm].
        epsilon: Half width of the envelope its boundary stays in, over the diagonal of the bounding box.
        stop_energy: AMIPS energy of the worst tetrahedron at which it is content; 3 is that of a regular one. Content with 30 only, it
            takes two to three times as long as with 100, for meshes whose drops take a tenth fewer steps and come to the same stresses.
        iterations: Most rounds of optimisation.
    """

    edge_length: float
    epsilon: float
    stop_energy: float = 100.0
    iterations: int = 20


def tetwild(
    vertices: Floats, faces: NDArray[np.int32], settings: Settings, *, timeout: float, go_on: GoOn = regardless
) -> tuple[Floats, NDArray[np.int32]]:
    """Vertices [mm] and tetrahedra of the inside of a surface, in whatever order and orientation fTetWild leaves them.

    The worker ends after `timeout` seconds of processor time, or PATIENCE times as long by the clock, and is killed when anything is raised
    here, by `go_on` or Ctrl-C.

    Raises:
        SimulationFailed: If it runs out of time, dies, or finds nothing inside.
    """
    _remove_abandoned()
    with tempfile.TemporaryDirectory(prefix=FOLDER) as name:
        folder = Path(name)
        request, answer = folder / "request.npz", folder / "answer.npz"
        longest = PATIENCE * timeout
        np.savez(request, vertices=vertices, faces=faces, processor=timeout, limit=longest + GRACE, **settings._asdict())
        command = [sys.executable, "-m", "mechstyle.geometry._tetwild_worker", str(request), str(answer)]
        try:
            done = _ended(command, folder, longest, go_on)
        except subprocess.TimeoutExpired as error:
            raise _out_of_time(f"{longest:.0f} s") from error
        if hasattr(signal, "SIGXCPU") and done.returncode == -signal.SIGXCPU:
            raise _out_of_time(f"{timeout:.0f} s of processor time")
        return _answer(answer, done)


def _remove_abandoned() -> None:
    """Remove the folders of processes that were killed; links, and what belongs to somebody else, stay."""
    for folder in Path(tempfile.gettempdir()).glob(f"{FOLDER}*"):
        with contextlib.suppress(OSError):  # another process may be removing it
            if time() - folder.lstat().st_mtime > ABANDONED:
                shutil.rmtree(folder, ignore_errors=True)


def _out_of_time(spent: str) -> SimulationFailed:
    return SimulationFailed(f"fTetWild was stopped after {spent} without a mesh; the part may have walls or details too fine for it")


def _ended(command: list[str], folder: Path, timeout: float, go_on: GoOn) -> subprocess.CompletedProcess[bytes]:
    """As `subprocess.run` with a limit in seconds, asking now and then whether to go on."""
    until = monotonic() + timeout
    with subprocess.Popen(  # noqa: S603 (this very interpreter, fixed arguments)
        command, cwd=folder, env=_environment(), stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE
    ) as process:
        try:
            while True:
                go_on()
                try:
                    _, said = process.communicate(timeout=max(0.0, min(LOOK, until - monotonic())))
                    return subprocess.CompletedProcess(command, process.returncode, stderr=said)
                except subprocess.TimeoutExpired:
                    if monotonic() >= until:
                        raise
        except BaseException:
            process.kill()
            raise


def _answer(path: Path, done: subprocess.CompletedProcess[bytes]) -> tuple[Floats, NDArray[np.int32]]:
    if done.returncode != 0:
        said = done.stderr.decode(errors="replace").strip().splitlines()
        raise SimulationFailed(f"fTetWild failed (exit code {done.returncode}): {said[-1] if said else 'without a word'}")
    try:
        with np.load(path, allow_pickle=False) as found:
            vertices, tets = found["vertices"].astype(np.float64), found["tets"].astype(np.int32)
    except (OSError, KeyError, ValueError, zipfile.BadZipFile) as error:
        raise SimulationFailed("fTetWild ended without leaving a mesh") from error
    if not len(tets):
        raise SimulationFailed("fTetWild found nothing inside the surface")
    return vertices, tets


def _environment() -> dict[str, str]:
    """The environment with this package importable from another folder."""
    root = str(Path(__file__).resolve().parents[2])
    paths = [root, *filter(None, [os.environ.get("PYTHONPATH")])]
    return {**os.environ, "PYTHONPATH": os.pathsep.join(paths)}
