"""Work in another thread: it is waited for, ended when it is of no use, and silent about what it could not do."""

from __future__ import annotations

from threading import Event, get_ident

import pytest

from mechstyle.errors import SimulationFailed
from mechstyle.geometry.cancelling import meanwhile


def test_both_are_done_when_the_block_is_over():
    begun, done = Event(), []

    def work(_go_on):
        begun.set()
        done.append(get_ident())

    with meanwhile(work):
        assert begun.wait(60), "it works while the block does"
    assert done
    assert done != [get_ident()]


def endless(heard):
    """Work that goes on until it is ended, and tells then."""

    def work(go_on):
        try:
            while True:
                go_on()
        finally:
            heard.append("ended")

    return work


def test_what_ends_the_block_ends_the_work():
    heard = []
    with pytest.raises(KeyboardInterrupt), meanwhile(endless(heard)):
        raise KeyboardInterrupt
    assert heard == ["ended"]


def test_while_the_work_alone_goes_on_it_is_asked_whether_to():
    heard = []

    def stopped():
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt), meanwhile(endless(heard), stopped):
        pass
    assert heard == ["ended"]


def test_what_could_not_be_done_is_for_whoever_asks_for_it():
    def work(_go_on):
        raise SimulationFailed("it cannot be filled")

    with meanwhile(work):
        pass
