"""fTetWild (Hu et al. 2020) as a function that can be interrupted.

It holds the interpreter lock for its whole run, crashes on some input and leaves files where it stands. In a process that can be killed, in
a folder that is thrown away, none of that matters: `tetwild` starts this very module there, and `main` is what it does.
"""

from __future__ import annotations

import contextlib
import ctypes
import math
import shutil
import signal
import subprocess
import sys
import tempfile
import types
import zipfile
from pathlib import Path
from time import time
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from mechstyle.errors import SimulationFailed
from mechstyle.geometry.cancelling import CancelCheck, never_cancel
from mechstyle.geometry.worker import importable, limit_processor_time, out_of_time
from mechstyle.records.mesh import Floats

LOOK = 0.2  # seconds between two looks whether to go on
FOLDER = "mechstyle-mesh-"
"""How the temporary folders of workers are called."""
ABANDONED = 86400.0
"""Age [s] of such a folder at which nobody works in it any more: what was killed cannot remove its own."""
PR_SET_PDEATHSIG = 1
"""Of `prctl` in Linux; with threads it means the end of the one that started this process, which waits for it."""


class Settings(NamedTuple):
    """Settings of an fTetWild run."""

    edge_length: float  # edge length it aims at [mm]
    epsilon: float  # half width of the envelope its boundary stays in, over the diagonal of the bounding box
    # AMIPS energy of the worst tetrahedron at which it is content; 3 is that of a regular one. Content with 30 only, it takes two to
    # three times as long as with 100, for meshes whose drops take a tenth fewer steps and come to the same stresses
    stop_energy: float = 100.0
    iterations: int = 20  # most rounds of optimisation


def tetwild(
    vertices: Floats, faces: NDArray[np.int32], settings: Settings, *, timeout: float, go_on: CancelCheck = never_cancel
) -> tuple[Floats, NDArray[np.int32]]:
    """Vertices [mm] and tetrahedra of the inside of a surface, in whatever order and orientation fTetWild leaves them.

    The worker ends after `timeout` seconds of processor time, however long that takes on a busy machine, and is killed when anything is
    raised here, by `go_on` or Ctrl-C.

    Raises:
        SimulationFailed: If it runs out of time, dies, or finds nothing inside.
    """
    # Folders of processes that were killed go; links, and what belongs to somebody else, stay.
    for old in Path(tempfile.gettempdir()).glob(f"{FOLDER}*"):
        with contextlib.suppress(OSError):  # another process may be removing it
            if time() - old.lstat().st_mtime > ABANDONED:
                shutil.rmtree(old, ignore_errors=True)
    with tempfile.TemporaryDirectory(prefix=FOLDER) as name:
        folder = Path(name)
        request, answer = folder / "request.npz", folder / "answer.npz"
        np.savez(request, vertices=vertices, faces=faces, processor=timeout, **settings._asdict())
        command = [sys.executable, "-m", "mechstyle.geometry.remeshing.tetwild", str(request), str(answer)]
        done = _ended(command, folder, go_on)
        if out_of_time(done.returncode):
            spent = f"{timeout:.0f} s of processor time"
            raise SimulationFailed(f"fTetWild was stopped after {spent} without a mesh; the part may have walls or details too fine for it")
        if done.returncode != 0:
            said = done.stderr.decode(errors="replace").strip().splitlines()
            raise SimulationFailed(f"fTetWild failed (exit code {done.returncode}): {said[-1] if said else 'without a word'}")
        try:
            with np.load(answer, allow_pickle=False) as found:
                inside, tets = found["vertices"].astype(np.float64), found["tets"].astype(np.int32)
        except (OSError, KeyError, ValueError, zipfile.BadZipFile) as error:
            raise SimulationFailed("fTetWild ended without leaving a mesh") from error
        if not len(tets):
            raise SimulationFailed("fTetWild found nothing inside the surface")
        return inside, tets


def _ended(command: list[str], folder: Path, go_on: CancelCheck) -> subprocess.CompletedProcess[bytes]:
    """As `subprocess.run`, asking now and then whether to go on."""
    with subprocess.Popen(  # noqa: S603 (this very interpreter, fixed arguments)
        command, cwd=folder, env=importable(), stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE
    ) as process:
        try:
            while True:
                go_on()
                with contextlib.suppress(subprocess.TimeoutExpired):
                    _, said = process.communicate(timeout=LOOK)
                    return subprocess.CompletedProcess(command, process.returncode, stderr=said)
        except BaseException:
            process.kill()
            raise


def main(request: str, answer: str) -> None:
    """The other process: fill the surface in the file `request` with the settings in it; write vertices and tets to the file `answer`.

    The system ends it as soon as its parent ends, in whatever way; on other systems than Linux there is the limit of its time.
    """
    if sys.platform == "linux":
        ctypes.CDLL(None).prctl(PR_SET_PDEATHSIG, signal.SIGKILL)
    with np.load(request, allow_pickle=False) as asked:
        limit_processor_time(math.ceil(asked["processor"]))
        # The package imports pyvista, and with it VTK, for functions that are not used here: an empty module will do.
        sys.modules.setdefault("pyvista", types.ModuleType("pyvista"))
        from pytetwild.pytetwild import tetrahedralize  # noqa: PLC0415 (the stand-in must be there first)

        vertices, tets = tetrahedralize(
            asked["vertices"], asked["faces"], edge_length_abs=float(asked["edge_length"]), epsilon=float(asked["epsilon"]),
            stop_energy=float(asked["stop_energy"]), num_opt_iter=int(asked["iterations"]), simplify=False, num_threads=1, quiet=True,
        )  # fmt: skip
    np.savez(answer, vertices=vertices, tets=tets)


if __name__ == "__main__":
    main(*sys.argv[1:])
