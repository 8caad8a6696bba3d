"""What a piece of a page says to who looks at it."""

import re
from typing import Any

from mechstyle.records import sentences
from mechstyle_widgets.state.on_show import on_show
from mechstyle_widgets.state.outcomes import LOOKS


def outcomes(html: str) -> set[str]:
    """Outcomes it says of what is on show; what is folded away, and rests under the mouse, tells of others, too."""
    seen = re.sub(r"<style>.*?</style>|<details>.*</details>", "", html, flags=re.DOTALL)
    seen = re.sub(r"<[^>]*>", " ", seen)
    return {one for one in (*LOOKS, sentences.NOT_TESTED) if re.search(rf"\b{one}\b", seen)}


def assert_tells_one_truth(studio: Any) -> None:
    """Badge, Result, pictures and tooltips say of the surface that is drawn what its own test found, or that it had none."""
    state, viewer, shown = studio.state, studio.viewer, on_show(studio.state)
    own = state.run.store.checkpoint(state.row().digest).verdict
    assert shown.verdict == own
    assert viewer._drawn_place == (state.lane, state.iteration)
    assert viewer.captions[0] == shown.caption
    assert all(button.tooltip.endswith(shown.caption) for button in studio.take_away._buttons.values())
    own_words = {sentences.NOT_TESTED if own is None else own.outcome}
    assert outcomes(studio._result.value) == own_words
    if not (viewer.insight and viewer.compared):
        assert outcomes(viewer.badge._words.value) == own_words
