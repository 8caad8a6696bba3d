"""Words that explain themselves: a sentence for each term of the glossary, and a small picture for those that need one."""

from __future__ import annotations

import re

from mechstyle.records.words import WORDS
from mechstyle_widgets.jupyter.language import said, word

ALSO = {
    "mask": "restraint",
    "restraint": "restraint",
    "movement held back": "restraint",
    "drops": "orientations, poses",
    "it lands": "orientations, poses",
    "may be off by": "tolerance",
    "thinnest": "minimum_wall",
    "correct until it passes": "guarantee",
    "regions": "protect",
    "branches": "lane",
    "lanes": "lane",
    "new lane": "lane",
    "depth": "relief",
    "size": "feature",
    "variation": "seed",
    "shape from": "field",
    "detail": "vertices",
    "holds back": "control",
    "holding back": "control",
    "measured against": "normalisation",
    "stops at": "threshold",
    "tested": "schedule",
    "when to test": "schedule",
    "keep plain": "protect",
    "spare strength": "headroom",
    "style still missing": "style_loss",
    "change since the last test": "travel",
}
"""Labels of controls that mean a term of another word."""
INK, FAINT, ACCENT, OVER = (
    "currentColor",
    "var(--jp-border-color1, #999)",
    "var(--jp-brand-color1, #1976d2)",
    "var(--jp-error-color1, #b3261e)",
)


def terms() -> dict[str, list[str]]:
    """By what stands on screen in small letters, the word, its sentence and its picture as SVG, all in the language spoken."""
    taught, found = dict[str, list[str]](), dict[str, list[str]]()
    for key, (names, sentence) in WORDS.items():
        picture = re.sub("([^<>]+)</text>", lambda caption: f"{word(caption[1])}</text>", PICTURES.get(key, ""))
        taught[key] = [said(sentence), picture]
        shown = ", ".join(map(_called, names.split(", ")))
        found |= {_called(one).lower(): [shown, *taught[key]] for one in names.replace(" · ", ", ").split(", ")}
    return found | {_called(label).lower(): [_called(label), *taught[key]] for label, key in ALSO.items()}


def _called(label: str) -> str:
    """What a label is called, which may begin a line, where it has a capital."""
    return " · ".join(word(one) if word(one) != one else word(one.capitalize()) if one.islower() else one for one in label.split(" · "))


def _picture(*parts: str) -> str:
    return f'<svg viewBox="0 0 280 48" aria-hidden="true" font-size="12" fill="{INK}">{"".join(parts)}</svg>'


def _bar(x: float, width: float, fill: str) -> str:
    return f'<rect x="{x}" y="8" width="{width}" height="16" fill="{fill}" stroke="{FAINT}"/>'


def _word(x: float, words: str) -> str:
    return f'<text x="{x}" y="44">{words}</text>'


def _limit(x: float) -> str:
    return f'<path d="M{x} 2V30" stroke="{OVER}" stroke-width="2"/>'


def _curve(path: str) -> str:
    return f'<path d="{path}" fill="none" stroke="{ACCENT}" stroke-width="2"/><path d="M4 30H276" stroke="{FAINT}"/>'


def _part(x: float, turned: float, fill: str) -> str:
    """A cup over the floor, turned by an angle."""
    return f'<rect x="{x}" y="6" width="14" height="20" transform="rotate({turned} {x + 7} 16)" fill="{fill}" stroke="{INK}"/>'


_FROM_ORIGINAL_TO_LIMIT = (_bar(4, 272, "none"), _bar(4, 110, FAINT), _limit(250), _word(4, "plain part"), _word(236, "yields"))
PICTURES = {
    "demand": _picture(*_FROM_ORIGINAL_TO_LIMIT, _bar(114, 56, ACCENT), _word(128, "style")),
    "headroom": _picture(*_FROM_ORIGINAL_TO_LIMIT, f'<path d="M116 16H248" stroke="{ACCENT}" stroke-width="4"/>', _word(142, "headroom")),
    "restraint": _picture(_curve("M4 28C120 26 160 6 220 4H276"), _word(4, "0: moves freely"), _word(222, "1: stops")),
    "threshold": _picture(_curve("M4 4C100 6 140 28 190 29H276"), _limit(190), _word(4, "moves"), _word(158, "threshold")),
    "schedule": _picture(
        f'<path d="M8 16H272" stroke="{FAINT}" stroke-width="2"/>',
        *(f'<circle cx="{x}" cy="16" r="6" fill="{ACCENT}"/>' for x in (8, 40, 96, 176, 272)),
        _word(4, "start"), _word(86, "dropped on the way"), _word(256, "end"),
    ),
    "nearly_flat": _picture(
        f'<path d="M4 30H276" stroke="{FAINT}"/>',
        *(_part(x, turned, fill) for x, turned, fill in ((20, 0, "none"), (110, -12, "none"), (200, 12, OVER))),
        _word(12, "flat"), _word(182, "the worst"),
    ),
}  # fmt: skip
"""Small pictures of terms that a sentence alone does not teach."""
