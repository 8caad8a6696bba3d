"""What a thread works out comes back on the event loop, and of what was asked for meanwhile only the last."""

from __future__ import annotations

import asyncio
import threading

from mechstyle_widgets.jupyter.throttle import LatestOnly


def asked_while_it_works(*wishes, then=lambda _: None, raises=()):
    """Ask for wishes while the first is worked on; what was brought, and by which thread each was worked on and brought."""
    brought, worked, told = [], [], []

    async def ask() -> None:
        go_on, ended = threading.Event(), asyncio.Event()
        loop = asyncio.get_running_loop()
        loop.set_exception_handler(lambda _loop, context: told.append(context["exception"]))

        def work(wish):
            assert go_on.wait(30)
            worked.append((wish, threading.current_thread()))
            if wish in raises:
                raise ValueError(wish)
            return 2 * wish

        newest = LatestOnly(work, lambda wish, answer: brought.append((wish, answer, threading.current_thread())))
        end, newest._end = newest._end, lambda *given: (end(*given), newest._busy or ended.set())
        for wish in wishes:
            newest.ask(wish)
        then(newest)
        go_on.set()
        await asyncio.wait_for(ended.wait(), 30)

    asyncio.run(ask())
    return brought, worked, told


def test_without_a_loop_it_works_at_once():
    brought = []
    LatestOnly(lambda wish: 2 * wish, lambda *told: brought.append(told)).ask(3)
    assert brought == [(3, 6)]


def test_of_what_comes_while_it_works_the_last_counts():
    brought, worked, _ = asked_while_it_works(1, 2, 3)
    assert [(wish, answer) for wish, answer, _ in brought] == [(1, 2), (3, 6)]
    assert all(thread is threading.main_thread() for _, _, thread in brought)
    assert not any(thread is threading.main_thread() for _, thread in worked)


def test_what_is_cancelled_is_not_brought():
    brought, worked, _ = asked_while_it_works(1, 2, then=LatestOnly.cancel)
    assert brought == []
    assert [wish for wish, _ in worked] == [1]


def test_an_error_is_told_on_the_loop_and_the_next_wish_is_worked_on():
    brought, _, told = asked_while_it_works(1, 2, raises=(1,))
    assert [str(error) for error in told] == ["1"]
    assert [wish for wish, *_ in brought] == [2]
