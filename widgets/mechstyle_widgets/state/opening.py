"""The run that a Studio of nothing opens on: the trophy of the lessons, free and held back, shipped so that nothing is computed.

`python -m mechstyle_widgets.state.opening` makes it anew.
"""

from __future__ import annotations

import hashlib
import io
import os
import shutil
import tarfile
import tempfile
import zlib
from importlib.resources import files
from pathlib import Path

from mechstyle import teaching
from mechstyle._files import cache_folder
from mechstyle.loop.store import Store
from mechstyle.runs.folders import default_folder, folder_for
from mechstyle.runs.recipes import FREESTYLE
from mechstyle.runs.run import Run
from mechstyle_widgets.state.studio_state import FREE

PACKED = Path(str(files("mechstyle_widgets.state") / "static" / "opening.tar.xz"))
NOT_SHIPPED = ("locks", "images")
"""Folders of a run that say nothing of it."""


def opening() -> Run:
    """The shipped run, unpacked where what may be deleted is kept; it is there whole or not at all."""
    packed = PACKED.read_bytes()
    place = cache_folder() / f"opening-{hashlib.sha256(packed).hexdigest()[:12]}"
    if not place.is_dir():
        place.parent.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryDirectory(dir=place.parent) as aside, tarfile.open(fileobj=io.BytesIO(packed)) as archive:
            archive.extractall(Path(aside) / "run", filter="data")
            if not place.is_dir():  # another kernel may have been quicker
                Path(aside, "run").rename(place)
    return Run.open(place, "auto")


def shipped(run: Run) -> bool:
    """Whether it is the shipped run, which nobody goes on with where it lies."""
    return run.store.place.parent == cache_folder().absolute() and run.store.place.name.startswith("opening-")


def of_ones_own(run: Run) -> Run:
    """A run one may go on with: of the shipped one, a copy where runs are kept."""
    if not shipped(run):
        return run
    place = folder_for(default_folder(run.recipe), run.recipe, beside=True)
    if "main" not in Store(place).lanes():
        shutil.copytree(run.store.place, place, dirs_exist_ok=True)
    return Run(Store.open(place), run.lane, run.device)


def packed(run: Run) -> bytes:
    """A run as it is shipped: objects as they are, which all together take less room than each packed by itself."""
    root, data = run.store.place, io.BytesIO()
    with tarfile.open(fileobj=data, mode="w:xz", preset=9) as archive:
        for path in sorted(one for one in root.rglob("*") if one.is_file() and one.relative_to(root).parts[0] not in NOT_SHIPPED):
            content = path.read_bytes()
            if path.is_relative_to(root / "objects"):
                content = zlib.compress(zlib.decompress(content), 0)
            entry = tarfile.TarInfo(path.relative_to(root).as_posix())
            entry.size = len(content)
            archive.addfile(entry, io.BytesIO(content))
    return data.getvalue()


def main() -> None:
    """Run both anew and pack them."""
    with tempfile.TemporaryDirectory() as folder:
        os.chdir(folder)  # no path of this machine is in what is shipped
        run = teaching.run(folder=".")
        run.branch(0, lane=FREE, **FREESTYLE).go()
        PACKED.parent.mkdir(exist_ok=True)
        PACKED.write_bytes(packed(run))
        os.chdir("/")


if __name__ == "__main__":
    main()
