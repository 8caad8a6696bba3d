"""Layouts and styles that controls share."""

import ipywidgets
import pytest
from ipywidgets.widgets import widget as library

from mechstyle_widgets import Studio
from mechstyle_widgets.jupyter.looks import close_family, lean, sharing, show

MODELS, BYTES = 420, 2_000_000
"""What a Studio may be made of before a run, half as much again as its 25k vertices and controls come to; it was 836, and 8.5 MB."""


@pytest.fixture
def two():
    """Controls of one widget that say the same."""
    with sharing():
        return [lean(ipywidgets.HTML, layout={"width": "36px"}) for _ in range(2)]


def test_in_a_widget_the_same_looks_are_one(two):
    one, other = two
    assert one.layout is other.layout
    assert one.style is other.style


def test_two_widgets_share_no_look(two):
    """A page keeps all that was shown with a control as long as its layout lives: 2.8 MB each run of a cell."""
    with sharing():
        assert lean(ipywidgets.HTML, layout={"width": "36px"}).layout is not two[0].layout
    assert lean(ipywidgets.HTML, layout={"width": "36px"}).layout is not two[0].layout


def test_looks_are_closed_with_the_last_control_that_has_them(two):
    one, other = two
    show(one, False)
    hidden = one.layout
    show(one, True)
    close_family(ipywidgets.VBox([one]))
    assert hidden.comm is None
    assert other.layout.comm is not None
    close_family(ipywidgets.VBox([other]))
    assert other.layout.comm is None


def test_what_is_closed_while_a_control_is_made_leaves_it_its_look():
    """What hid it afterwards was refused: other controls share this look."""
    with sharing():
        other = ipywidgets.VBox([lean(ipywidgets.HTML, layout={"width": "7px"})])

        class Interrupted(ipywidgets.HTML):
            def __init__(self, **traits):
                close_family(other)
                super().__init__(**traits)

        made = lean(Interrupted, layout={"height": "9px"})
    assert made.layout.comm is not None
    show(made, False)
    assert made.layout.display == "none"


def test_looks_are_closed_while_controls_are_made(two):
    """Python may remove a widget that nobody holds in any thread, between any two steps of what makes another."""
    made = []

    class Unhurried(ipywidgets.Box):
        @property
        def style(self):
            made.append(lean(ipywidgets.HTML))

    amid = [lean(Unhurried) for _ in range(2)]
    close_family(ipywidgets.VBox(two))
    assert len(made) == len(amid)
    assert all(control.layout.comm is not None for control in made)
    assert two[0].layout.comm is None


def test_a_studio_run_again_and_again_leaves_nothing():
    """The next one is made before the last one is closed, as a cell does it."""
    before, last = set(library._instances), Studio(prompt="brick")
    for _ in range(3):
        shown, last = last, Studio(prompt="brick")
        shown.close()
    last.close()
    assert set(library._instances) <= before  # what other tests left may go in between


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
