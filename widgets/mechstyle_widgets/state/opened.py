"""What a Studio is opened with: a part, or a run that was made before."""

from __future__ import annotations

from typing import Any

from mechstyle.gallery import PREFIX
from mechstyle.loop.store import parse_address
from mechstyle.records.mesh import SurfaceMesh
from mechstyle.runs.run import Run


def run_in(part: Any, device: str) -> Run | None:
    """The run that `part` names, None if it names a part."""
    if isinstance(part, Run):
        return part
    if isinstance(part, SurfaceMesh) or str(part).startswith(PREFIX):
        return None
    root, _, _ = parse_address(str(part))
    return Run.open(part, device) if root.is_dir() else None
