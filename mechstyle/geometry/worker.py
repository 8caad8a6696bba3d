"""Processes of their own for native code that may crash or never end, with a limit on their processor time."""

from __future__ import annotations

import faulthandler
import os
import signal
import sys
from pathlib import Path

PATIENCE = 20.0
"""On Windows, which limits no processor time, the clock may run on for so many times that limit."""


def importable() -> dict[str, str]:
    """The environment with this package importable from another folder."""
    paths = [str(Path(__file__).resolve().parents[2]), *filter(None, [os.environ.get("PYTHONPATH")])]
    return {**os.environ, "PYTHONPATH": os.pathsep.join(paths)}


def limit_processor_time(seconds: int) -> None:
    """Have the system end this process by SIGXCPU when it has computed for so long [s]; on Windows a C thread does, by the clock."""
    if sys.platform == "win32":
        faulthandler.dump_traceback_later(PATIENCE * seconds, exit=True)
    else:
        import resource  # noqa: PLC0415 (not there on Windows)

        resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
        _, most = resource.getrlimit(resource.RLIMIT_CPU)
        resource.setrlimit(resource.RLIMIT_CPU, (seconds if most == resource.RLIM_INFINITY else min(seconds, most), most))


def out_of_time(returncode: int) -> bool:
    """Whether a process of this exit code was ended by that limit."""
    return hasattr(signal, "SIGXCPU") and returncode == -signal.SIGXCPU
