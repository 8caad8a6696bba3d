"""STEP files as triangles, by Open CASCADE through cascadio, an extra.

Its reader is native code that a damaged file may bring down or keep busy for ever. It therefore runs in a process of its own, with a limit
on its processor time, which does not depend on how busy the machine is.
"""

from __future__ import annotations

import importlib.util
import subprocess
import sys
import tempfile
from pathlib import Path

from mechstyle.errors import BadInput
from mechstyle.geometry.worker import importable, limit_processor_time, out_of_time

SUFFIXES = ("step", "stp")
PROCESSOR = 120
"""Processor time after which a file is given up [s]; a housing of a thousand faces takes two."""
LINEAR, ANGULAR = 0.02, 0.2
"""How far triangles may leave the surface [mm], and turn from one to the next [rad]."""
MISSING = "reading STEP takes an extra: `pip install 'mechstyle[step]'`, or export it as STL or 3MF in the program it was made with"


def glb_of(name: str, content: bytes) -> bytes:
    """The bodies of a STEP file as GLB, in metres and with its own axes.

    Args:
        name: What to call the file in a refusal.
        content: All of it.

    Raises:
        BadInput: If it cannot be read, or what reads it is not installed.
    """
    if importlib.util.find_spec("cascadio") is None:
        raise BadInput(f"{name}: {MISSING}")
    with tempfile.TemporaryDirectory() as folder:
        asked, answer = Path(folder) / "part.step", Path(folder) / "part.glb"
        asked.write_bytes(content)
        command = [sys.executable, "-m", "mechstyle.geometry.step", str(asked), str(answer)]
        done = subprocess.run(command, env=importable(), stdin=subprocess.DEVNULL, capture_output=True, check=False)  # noqa: S603
        if done.returncode or not answer.is_file() or not (found := answer.read_bytes()):
            why = "takes too long to read" if out_of_time(done.returncode) else "cannot be read as STEP"
            raise BadInput(f"{name} {why}: it is damaged, or of a kind that Open CASCADE does not know; export it as STL or 3MF")
        return found


def main(asked: str, answer: str) -> None:
    """The other process."""
    import cascadio  # noqa: PLC0415 — an extra

    limit_processor_time(PROCESSOR)
    Path(answer).write_bytes(cascadio.load(Path(asked).read_bytes(), file_type="step", tol_linear=LINEAR, tol_angular=ANGULAR))


if __name__ == "__main__":
    main(*sys.argv[1:])
