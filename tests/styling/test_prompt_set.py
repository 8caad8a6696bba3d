"""Some four hundred prompts as people write them, and what each must give."""

import re
from pathlib import Path

import numpy as np
import pytest

from mechstyle.errors import BadInput
from mechstyle.styling.drawing.colours import rgb, shaded
from mechstyle.styling.prompt import read
from mechstyle.styling.vocabulary import COLOURS, SHADES
from support import ROOT

LINES = [line for line in Path(__file__).with_name("prompts.txt").read_text("utf-8").splitlines() if line and not line.startswith("#")]
PROMPTS = [(prompt, *rest.split(" ~ ")) for prompt, rest in (line.split(" => ") for line in LINES)]


def colour(words):
    """Hexadecimal digits of a colour, with a shade before it or none."""
    *shade, name = words.split()
    red, green, blue = np.rint(255.0 * shaded(rgb(COLOURS[name]), SHADES[shade[0]] if shade else 1.0)).astype(int)
    return f"#{red:02x}{green:02x}{blue:02x}"


def test_the_set_is_large_and_holds_no_prompt_twice():
    assert len(PROMPTS) >= 200
    assert len({prompt for prompt, *_ in PROMPTS}) == len(PROMPTS)


@pytest.mark.parametrize(("prompt", "reading", "notes"), [(p, r, n) for p, r, *n in PROMPTS], ids=[p for p, *_ in PROMPTS])
def test_a_prompt_gives_what_it_must(prompt, reading, notes):
    if reading.startswith("!"):
        with pytest.raises(BadInput, match=re.escape(reading.removeprefix("! "))):
            read(prompt)
        return
    found = read(prompt)
    assert found.words == re.sub("<(.*?)>", lambda match: colour(match[1]), reading)
    assert len(found.notes) == len(notes)
    for note in notes:
        assert any(note in said for said in found.notes), found.notes


def test_prompts_that_were_held_back_give_what_they_gave_once_their_kinds_were_mended():
    lines = (ROOT / "benchmarks" / "held-back.txt").read_text("utf-8").splitlines()
    held_back = [line.split(" => ") for line in lines if line and not line.startswith("#")]
    assert len(held_back) > 500
    for prompt, right in held_back:
        if right == "!":
            with pytest.raises(BadInput):
                read(prompt)
        else:
            assert right.split("|") == sorted({wish.style or "plain" for wish in read(prompt).wishes}), prompt
