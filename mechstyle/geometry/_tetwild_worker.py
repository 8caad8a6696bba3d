"""One fTetWild run in a process of its own: `python -m mechstyle.geometry._tetwild_worker REQUEST.npz ANSWER.npz`.

fTetWild holds the interpreter lock for its whole run, crashes on some input and leaves files where it stands. In a process
that can be killed, in a folder that is thrown away, none of that matters.
"""

from __future__ import annotations

import ctypes
import faulthandler
import math
import signal
import sys
import types
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

PR_SET_PDEATHSIG = 1
"""Of `prctl` in Linux; with threads it means the end of the one that started this process, which waits for it."""


def main(request: str, answer: str) -> None:
    """Tetrahedralise the surface in `request` with the settings in it; write vertices and tets to `answer`."""
    _end_with_parent()
    with np.load(request, allow_pickle=False) as asked:
        # A C thread ends this process even if the parent died and can no longer kill it.
        faulthandler.dump_traceback_later(float(asked["limit"]), exit=True)
        _limit_processor_time(math.ceil(asked["processor"]))
        tetrahedralize = _tetrahedralize()
        vertices, tets = tetrahedralize(
            asked["vertices"],
            asked["faces"],
            edge_length_abs=float(asked["edge_length"]),
            epsilon=float(asked["epsilon"]),
            stop_energy=float(asked["stop_energy"]),
            num_opt_iter=int(asked["iterations"]),
            simplify=False,
            num_threads=1,
            quiet=True,
        )
    np.savez(answer, vertices=vertices, tets=tets)


def _end_with_parent() -> None:
    """Have the system end this process as soon as its parent ends, in whatever way; Linux only, elsewhere there is the limit."""
    if sys.platform == "linux":
        ctypes.CDLL(None).prctl(PR_SET_PDEATHSIG, signal.SIGKILL)


def _limit_processor_time(seconds: int) -> None:
    """Have the system end this process by SIGXCPU when it has computed for so long [s]; on Windows there is only the limit by the clock."""
    if sys.platform != "win32":
        import resource  # noqa: PLC0415 (not there on Windows)

        resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
        _, most = resource.getrlimit(resource.RLIMIT_CPU)
        resource.setrlimit(resource.RLIMIT_CPU, (seconds if most == resource.RLIM_INFINITY else min(seconds, most), most))


def _tetrahedralize() -> Callable[..., tuple[NDArray[np.float64], NDArray[np.int32]]]:
    """The function itself. Its package imports pyvista, and with it VTK, for others that are not used here: an empty module will do."""
    sys.modules.setdefault("pyvista", types.ModuleType("pyvista"))
    from pytetwild.pytetwild import tetrahedralize  # noqa: PLC0415 (the stand-in must be there first)

    return tetrahedralize


if __name__ == "__main__":
    main(*sys.argv[1:])
