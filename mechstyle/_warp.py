"""NVIDIA Warp, initialised without banner or driver warnings.

Its banner would go to standard output, which belongs to the command line's JSON, and its remark that there is no CUDA driver to
standard error at every start; whether there is one is what `mechstyle doctor` and `resolve_device` say.
"""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager

import warp as wp


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


wp.config.log_level = 40  # errors only
with without_native_stderr():
    wp.init()

__all__ = ["without_native_stderr", "wp"]
