"""Layouts and styles that controls share."""

import ipywidgets
import pytest
import traitlets
from ipywidgets.widgets import widget as library

from mechstyle_widgets import Studio
from mechstyle_widgets.jupyter.looks import close_family, close_unused, lean, sharing, show

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


def test_what_is_made_within_something_shares_with_it():
    with sharing():
        outer = lean(ipywidgets.HTML, layout={"width": "36px"})
        with sharing():
            assert lean(ipywidgets.HTML, layout={"width": "36px"}).layout is outer.layout
        assert lean(ipywidgets.HTML, layout={"width": "37px"}).layout is not outer.layout


def test_two_widgets_share_no_look(two):
    """A page keeps all that was shown with a control as long as its layout lives: 2.8 MB each run of a cell."""
    with sharing():
        assert lean(ipywidgets.HTML, layout={"width": "36px"}).layout is not two[0].layout
    assert lean(ipywidgets.HTML, layout={"width": "36px"}).layout is not two[0].layout


def test_hiding_one_leaves_the_others(two):
    one, other = two
    show(one, False)
    assert (one.layout.display, one.layout.width) == ("none", "36px")
    assert other.layout.display is None
    show(one, True)
    assert one.layout is other.layout


def test_a_layout_of_its_own_is_changed_where_it_is():
    own = lean(ipywidgets.HTML, layout={"width": "36px"})
    layout = own.layout
    show(own, False)
    assert own.layout is layout
    assert layout.display == "none"


def test_what_others_share_is_not_changed_by_mistake(two):
    with pytest.raises(traitlets.TraitError, match="share"):
        two[0].layout.width = "1px"


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


def test_looks_that_are_closed_twice_at_a_time_are_closed_once(two):
    """One that closes them is met by another on its way."""
    look, layout, style = two[0].layout, two[0].layout, two[0].style
    closed = look.close
    look.close = lambda: (closed(), setattr(look, "close", closed), close_unused([style]))
    for one in two:
        one.close()
    close_unused([layout])
    close_unused([layout])
    assert (layout.comm, style.comm) == (None, None)


def test_a_studio_run_again_and_again_leaves_nothing():
    """The next one is made before the last one is closed, as a cell does it."""
    before, last = set(library._instances), Studio(prompt="brick")
    for _ in range(3):
        shown, last = last, Studio(prompt="brick")
        shown.close()
    last.close()
    assert set(library._instances) <= before  # what other tests left may go in between


def test_looks_that_were_closed_are_made_anew(two):
    one, other = two
    show(one, False)
    one.layout.close()
    show(other, False)
    assert other.layout.comm is not None


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
