"""Layouts and styles that controls share."""

import ipywidgets
import pytest
import traitlets
from ipywidgets.widgets import widget as library

from mechstyle_widgets import Studio
from mechstyle_widgets.jupyter.closing import close_family
from mechstyle_widgets.jupyter.looks import lean, look, show

MODELS, BYTES = 420, 2_000_000
"""What a Studio may be made of before a run, half as much again as its 25k vertices and controls come to; it was 836, and 8.5 MB."""


def test_the_same_looks_are_one():
    one, other = (lean(ipywidgets.Button, layout={"width": "36px"}) for _ in range(2))
    assert one.layout is other.layout
    assert one.style is other.style
    assert lean(ipywidgets.Button, layout={"width": "37px"}).layout is not one.layout


def test_hiding_one_leaves_the_others():
    one, other = (lean(ipywidgets.HTML, layout={"width": "36px"}) for _ in range(2))
    show(one, False)
    assert (one.layout.display, one.layout.width) == ("none", "36px")
    assert other.layout.display is None
    show(one, True)
    assert one.layout is other.layout


def test_a_layout_of_its_own_is_changed_where_it_is():
    own = ipywidgets.HTML(layout={"width": "36px"})
    layout = own.layout
    show(own, False)
    assert own.layout is layout
    assert layout.display == "none"


def test_what_others_share_is_not_changed_by_mistake():
    with pytest.raises(traitlets.TraitError, match="share"):
        lean(ipywidgets.HTML, layout={"width": "38px"}).layout.width = "1px"
    look(width="38px").close()  # it is not what it is asked for any more


def test_closing_one_leaves_the_looks_of_the_others():
    kept = lean(ipywidgets.HTML, layout={"width": "39px"})
    close_family(ipywidgets.VBox([lean(ipywidgets.HTML, layout={"width": "39px"})]))
    assert kept.layout.comm is not None


def test_looks_that_were_closed_are_made_anew():
    look(width="40px").close()
    assert look(width="40px").comm is not None


def test_a_studio_is_of_few_and_small_models():
    """A page that is loaded anew asks for all of them at once, and gives up on what it does not find within two seconds."""
    before = set(library._instances)
    studio = Studio(prompt="brick")
    made = [library._instances[name] for name in set(library._instances) - before]
    sent = [ipywidgets.widgets.widget._remove_buffers(one.get_state()) for one in made]
    size = sum(len(str(state)) + sum(memoryview(one).nbytes for one in buffers) for state, _, buffers in sent)
    studio.close()
    assert len(made) < MODELS
    assert size < BYTES
