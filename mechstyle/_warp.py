"""NVIDIA Warp, initialised without banner or driver warnings, whether or not its folder of compiled kernels can be written to.

Its banner would go to standard output, which belongs to the command line's JSON, and its remark that there is no CUDA driver to
standard error at every start; whether there is one is what `mechstyle doctor` and `resolve_device` say.
"""

from __future__ import annotations

import atexit
import logging
import os
import shutil
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import warp as wp

OURS = "wp_mechstyle*"
"""Kernels of this package in Warp's folder, a folder for each module; those of others may be gigabytes."""

logger = logging.getLogger(__name__)


@contextmanager
def without_native_stderr() -> Iterator[None]:
    """Send what C code writes to standard error nowhere."""
    nowhere, kept = os.open(os.devnull, os.O_WRONLY), os.dup(2)
    os.dup2(nowhere, 2)
    try:
        yield
    finally:
        os.dup2(kept, 2)
        os.close(kept)
        os.close(nowhere)


def start() -> None:
    """Start Warp, unless it runs already."""
    with without_native_stderr():
        wp.init()


def initialise() -> None:
    """Initialise Warp; where its folder of kernels cannot be written to, with a temporary one that holds what is found there."""
    try:
        start()
    except OSError:
        if wp.config.kernel_cache_dir is None:  # it came to grief before it looked for its folder
            raise
    kept = Path(wp.config.kernel_cache_dir)
    if os.access(kept, os.W_OK):
        return
    own = Path(tempfile.mkdtemp(prefix="mechstyle-kernels-"))
    atexit.register(shutil.rmtree, own, ignore_errors=True)
    place = own / wp.config.version  # where Warp looks in a folder that the environment names, as in processes that this one starts
    os.environ["WARP_CACHE_PATH"], wp.config.kernel_cache_dir = str(own), None
    start()  # nothing, where Warp found the folder and started …
    wp.config.kernel_cache_dir = str(place)  # … and gets the other one afterwards
    if not copied(kept, place):
        logger.warning(
            "%s cannot be written to, so kernels are compiled for this process alone: make it writable, or name another folder in "
            "WARP_CACHE_PATH",
            kept,
        )


def copied(kept: Path, place: Path) -> int:
    """Copy this package's kernels to a new folder, without their rights, which may be to read only; how many files there were."""
    files = [file for file in kept.glob(f"{OURS}/*") if os.access(file, os.R_OK)]
    for file in files:
        target = place / file.relative_to(kept)
        target.parent.mkdir(parents=True, exist_ok=True)
        shutil.copyfile(file, target)
    return len(files)


wp.config.log_level = 40  # errors only
initialise()

__all__ = ["without_native_stderr", "wp"]
