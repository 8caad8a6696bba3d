"""What a page says is heard on the thread of the cells; what it asks for is listed while models are being made."""

import asyncio
import threading

import ipywidgets
import pytest

from mechstyle_widgets.jupyter import one_thread
from mechstyle_widgets.jupyter.one_thread import hear_on_one_thread


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
    hear_on_one_thread()
    page, breeding = Page(), Breeding(value=7)
    monkeypatch.setattr(ipywidgets.Widget, "_control_comm", page)
    ipywidgets.Widget._handle_control_comm_msg({"content": {"data": {"method": "request_states"}}})
    (told,) = page.told
    assert told["states"][breeding.model_id]["state"]["value"] == 7


@pytest.fixture
def slid():
    """A slider, and what was heard of it on which thread."""
    slider, heard = ipywidgets.IntSlider(), []
    slider.observe(lambda change: heard.append((change["new"], threading.current_thread())), "value")
    return slider, heard


def say(slider, value):
    slider._handle_msg({"content": {"data": {"method": "update", "state": {"value": value}}}})


def test_a_page_is_heard_on_the_thread_of_the_cells_and_waited_for(slid):
    slider, heard = slid

    def page():
        for value in (3, 4):
            say(slider, value)
            assert slider.value == value

    async def main():
        hear_on_one_thread()
        await asyncio.to_thread(page)

    asyncio.run(main())
    assert heard == [(3, threading.main_thread()), (4, threading.main_thread())]


def test_a_cell_that_runs_for_long_holds_up_neither_what_is_said_nor_its_order(slid, monkeypatch):
    monkeypatch.setattr(one_thread, "LONGEST", 0.01)
    slider, heard = slid

    async def main():
        hear_on_one_thread()
        page = threading.Thread(target=lambda: [say(slider, value) for value in (3, 4)])
        page.start()
        page.join(30.0)  # the loop does not turn meanwhile
        assert not page.is_alive()
        assert heard == []
        await asyncio.sleep(0)

    asyncio.run(main())
    assert [value for value, _ in heard] == [3, 4]


def test_without_an_event_loop_it_is_heard_where_it_is_said(slid):
    slider, heard = slid

    async def main():
        hear_on_one_thread()

    asyncio.run(main())
    page = threading.Thread(target=say, args=(slider, 3))
    page.start()
    page.join(30.0)
    assert heard == [(3, page)]


def test_what_waited_while_its_widget_was_closed_is_not_heard(slid, monkeypatch):
    """A page told of the faces of a part that had been closed meanwhile, by the id of a buffer that was gone."""
    monkeypatch.setattr(one_thread, "LONGEST", 0.01)
    slider, heard = slid

    async def main():
        hear_on_one_thread()
        page = threading.Thread(target=lambda: say(slider, 3))
        page.start()
        page.join()  # a cell is at work
        slider.close()
        await asyncio.sleep(0)

    asyncio.run(main())
    assert heard == []
