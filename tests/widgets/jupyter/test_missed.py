"""What is said between the list of models and their making is said again, once, and nothing else."""

import ipywidgets
import pytest

from mechstyle_widgets.jupyter import missed
from mechstyle_widgets.jupyter.frame import Frame
from mechstyle_widgets.jupyter.one_thread import hear_on_one_thread

LIST = {"content": {"data": {"method": "request_states"}}}
STATE = {"content": {"data": {"method": "request_state"}}}
MADE = {"content": {"data": {"method": "custom", "content": {"kind": "made"}}}, "buffers": []}


class Page:
    """The comm a page asks for all models on."""

    def send(self, _data, **_buffers):
        pass


@pytest.fixture
def told(monkeypatch):
    """What sliders tell a page, by value."""
    hear_on_one_thread()
    heard, send = [], ipywidgets.Widget._send
    monkeypatch.setattr(ipywidgets.Widget, "_control_comm", Page())
    monkeypatch.setattr(missed, "_said", missed._Said())

    def sent(widget, msg, buffers=None):
        if isinstance(widget, ipywidgets.IntSlider):
            heard.append(msg["state"])
        send(widget, msg, buffers)

    monkeypatch.setattr(ipywidgets.Widget, "_send", sent)
    return heard


@pytest.fixture
def frame(told):
    return Frame()


@pytest.fixture
def slider(told):
    return ipywidgets.IntSlider(value=1)


@pytest.fixture
def said_again(told, frame):
    """What sliders tell a page that has made its models."""

    def made():
        told.clear()
        frame._handle_msg(MADE)
        return list(told)

    return made


def asked(slider):
    ipywidgets.Widget._handle_control_comm_msg(LIST)


def asked_of_one(slider):
    slider._handle_msg(STATE)


@pytest.mark.parametrize("ask", [asked, asked_of_one])
def test_what_changed_since_the_list_is_said_again_as_it_is_then(said_again, slider, ask):
    slider.min = -3
    ask(slider)
    slider.value = 2
    slider.value = 5
    assert said_again() == [{"value": 5}]


def test_a_page_that_is_shown_for_the_first_time_is_told_nothing_twice(said_again, slider):
    slider.value = 2
    assert said_again() == []


def test_what_a_page_asks_of_one_model_is_an_answer_and_not_said_again(said_again, slider):
    asked_of_one(slider)
    assert said_again() == []


def test_two_pages_that_are_loaded_at_once_are_both_told(said_again, slider):
    asked(slider)
    slider.value = 2
    asked(slider)
    slider.min = -1
    for _ in range(2):
        assert said_again() == [{"value": 2, "min": -1}]


def test_what_was_said_long_ago_is_not_said_again(said_again, slider):
    asked(slider)
    slider.value = 2
    missed._said.asked -= 2 * missed.LONGEST
    slider.min = -1
    asked(slider)
    assert said_again() == []


def test_a_model_that_was_closed_meanwhile_is_let_go(said_again, slider):
    asked(slider)
    slider.value = 2
    slider.close()
    assert said_again() == []


def test_a_control_that_is_made_meanwhile_is_sent_whole_and_not_said_again(slider):
    asked(slider)
    made = Frame()
    assert made.comm is not None
    assert made.model_id not in missed._said.names
