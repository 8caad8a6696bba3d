"""Whether the optional libraries of the style field and of CLIP are installed; torch is imported nowhere before this was asked."""

from __future__ import annotations

import importlib.util

from mechstyle.errors import MissingPiece

LIBRARIES = ("torch", "transformers", "safetensors")


def need_clip_extra() -> None:
    """Refuse what needs torch where it is not installed.

    Raises:
        MissingPiece: With the command that installs it and what works without.
    """
    absent = [name for name in LIBRARIES if importlib.util.find_spec(name) is None]
    if absent:
        raise MissingPiece(
            f"the network and CLIP need {', '.join(absent)}: install with `pip install 'mechstyle[clip]'`, "
            "or use the offline styles on vertices (guidance 'offline', field 'vertex'), which need neither"
        )
