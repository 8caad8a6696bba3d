"""Who holds a lock keeps others out, and dies with it."""

from __future__ import annotations

import os
import signal
import socket
import subprocess
import sys
import threading

import pytest

from mechstyle._files import exclusive
from mechstyle.errors import BadInput

HOLD = """
import sys
import threading
from pathlib import Path
from mechstyle._files import exclusive
with exclusive(Path(sys.argv[1]), "lane"):
    print("held", flush=True)
    sys.stdin.read()
"""


def refused(path):
    with pytest.raises(BadInput) as caught, exclusive(path, "lane 'main' of DIR"):
        pytest.fail("two hold it")
    return str(caught.value)


def test_a_second_holder_in_the_same_process_is_refused_by_name(tmp_path):
    path = tmp_path / "locks" / "main.lock"
    with exclusive(path, "lane"):
        said = refused(path)
    assert said.startswith(f"lane 'main' of DIR is being carried on by process {os.getpid()} on {socket.gethostname()}: ")
    assert "\n" not in said


def test_it_is_free_again_however_the_block_ends(tmp_path):
    path = tmp_path / "main.lock"
    with pytest.raises(ZeroDivisionError), exclusive(path, "lane"):
        raise ZeroDivisionError
    with exclusive(path, "lane"):
        assert str(os.getpid()) in path.read_text()
    assert path.read_text() == ""


def test_two_locks_do_not_know_each_other(tmp_path):
    main, branch = tmp_path / "main.lock", tmp_path / "branch-1.lock"
    with exclusive(main, "one"):
        with exclusive(branch, "other"):
            assert str(os.getpid()) in refused(main)
            assert str(os.getpid()) in refused(branch)
        assert branch.read_text() == ""
        assert str(os.getpid()) in main.read_text()


def test_another_process_is_refused_and_the_lock_of_a_killed_one_taken_over(tmp_path):
    path = tmp_path / "main.lock"
    command = [sys.executable, "-c", HOLD, str(path)]
    with subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True) as process:
        assert process.stdout.readline() == "held\n"
        assert f"process {process.pid} on " in refused(path)
        process.send_signal(signal.SIGKILL)
    assert path.read_text(), "it left its name behind"
    with exclusive(path, "lane"):
        assert str(os.getpid()) in path.read_text()


@pytest.mark.skipif(sys.platform == "win32", reason="links are for administrators")
def test_a_lock_that_is_a_link_is_refused_and_where_it_leads_is_left(tmp_path):
    """What holds a lock is written into it: a run folder from somebody else had a file of yours emptied."""
    path, mine = tmp_path / "main.lock", tmp_path / "thesis.txt"
    mine.write_text("years of work")
    path.symlink_to(mine)
    with pytest.raises(BadInput, match=r"main\.lock is a link"), exclusive(path, "lane"):
        pytest.fail("it was held")
    assert mine.read_text() == "years of work"


@pytest.mark.skipif(sys.platform == "win32", reason="there are no locks")
def test_a_file_system_without_locks_is_used_without(tmp_path, monkeypatch):
    def refuse(*_):
        raise OSError(37, "No locks available")

    monkeypatch.setattr("fcntl.flock", refuse)
    path = tmp_path / "main.lock"
    with exclusive(path, "lane"), exclusive(path, "lane"):
        assert str(os.getpid()) in path.read_text()
    assert path.read_text() == ""


def test_who_waits_comes_after_who_holds(tmp_path):
    path, order, waits = tmp_path / "main.lock", [], threading.Event()

    def second():
        waits.set()
        with exclusive(path, "lane", wait=True):
            order.append("second")

    other = threading.Thread(target=second)
    with exclusive(path, "lane"):
        other.start()
        waits.wait()
        order.append("first")
    other.join()
    assert order == ["first", "second"]
