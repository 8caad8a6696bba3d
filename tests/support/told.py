"""What a piece of a page says to who looks at it."""

import re
from typing import Any

from mechstyle.pictures.fields import STAYS_BENT
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
    assert shown.verdict == own, f"{shown.verdict} is not {own}"  # said in words for a kernel, where nobody rewrites assertions
    assert viewer.up_to_date, f"{viewer._drawn_place} is drawn, or what was corrected there, not {state.lane} {state.iteration}"
    assert viewer.captions[0] == shown.caption, f"{viewer.captions[0]!r} is the caption of {shown.caption!r}"
    tooltips = [button.tooltip for button in studio.take_away._buttons.values()]
    assert all(one.endswith(shown.caption) for one in tooltips), f"{tooltips} tell of {shown.caption!r}"
    own_words = {sentences.NOT_TESTED if own is None else own.outcome}
    assert outcomes(studio._result.value) == own_words, f"{studio._result.value!r} tells of {own_words}"
    if viewer.compared:
        assert viewer.insight == studio.branches.insight(), f"{viewer.insight!r} is not of what is on show, {shown.caption!r}"
    if viewer.compared:
        assert not outcomes(viewer.badge._words.value) or viewer.insight, f"{viewer.badge._words.value!r} says it again"
        assert outcomes(viewer.outcomes[0]) == own_words, f"{viewer.outcomes[0]!r} tells of {own_words}"
    else:
        assert outcomes(viewer.badge._words.value) == own_words, f"{viewer.badge._words.value!r} tells of {own_words}"
    row, bent = None if own is None else own.deciding, viewer.subject.layer(STAYS_BENT)
    if row is not None and row.stress is None and not row.collapses and bent is not None:
        figure, ends = sentences.bend_in(row, row.permanent_set), bent.text_at(bent.peak)
        assert ends == figure, f"the field ends at {ends}, and the verdict says {figure}"
        assert figure in studio._result.value, f"{studio._result.value!r} does not tell of {figure}"
