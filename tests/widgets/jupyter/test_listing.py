"""Listing the models of a kernel while some are being made."""

import ipywidgets

from mechstyle_widgets import Viewer


class Breeding(ipywidgets.IntSlider):
    """What another thread does to the list while it is gone through."""

    def get_state(self, *given, **named):
        ipywidgets.IntSlider()
        return super().get_state(*given, **named)


class Page:
    """The comm a page asks on."""

    def __init__(self):
        self.told = []

    def send(self, data, **_buffers):
        self.told.append(data)


def test_a_page_is_told_of_every_model_while_others_are_made(monkeypatch):
    assert Viewer
    page, breeding = Page(), Breeding(value=7)
    monkeypatch.setattr(ipywidgets.Widget, "_control_comm", page)
    ipywidgets.Widget._handle_control_comm_msg({"content": {"data": {"method": "request_states"}}})
    (told,) = page.told
    assert told["states"][breeding.model_id]["state"]["value"] == 7
