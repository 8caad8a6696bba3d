"""Work in a fresh interpreter: what holds this one for seconds would keep a kernel from answering.

`multiprocessing` would do, but it runs a script that uses it once more in every process it spawns.
"""

from __future__ import annotations

import os
import pickle
import queue
import subprocess
import sys
import threading
from collections.abc import Callable, Iterator
from contextlib import suppress
from typing import Any

from mechstyle.errors import MechStyleError

LOOK = 0.1
"""Between two looks whether to go on [s]."""
_END = object()


class WorkerProcess:
    """A function at work in another process, saying one thing after another."""

    def __init__(self, function: Callable[..., None], *arguments: Any) -> None:
        """Start `function(say, *arguments)`; function, arguments and all that is said are pickled."""
        command = [sys.executable, "-m", __name__]
        self._process = subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE)  # noqa: S603 — this very module
        self._said: queue.SimpleQueue[Any] = queue.SimpleQueue()
        self._thread = threading.Thread(target=self._listen, args=((function, arguments),), daemon=True)
        self._thread.start()

    def said(self, go_on: Callable[[], object] = lambda: None) -> Iterator[Any]:
        """Yield its messages as they come, until it ends or is stopped; what it raised is raised here.

        `go_on` is called ten times a second while waiting; what that raises stops the work.
        """
        try:
            while True:
                go_on()
                try:
                    word = self._said.get(timeout=LOOK)
                except queue.Empty:
                    continue
                if word is _END:
                    return
                if isinstance(word, MechStyleError):
                    raise word
                yield word
        finally:
            self.stop()

    def stop(self) -> None:
        """End it now."""
        self._process.kill()
        self._thread.join()

    def _listen(self, task: Any) -> None:
        """In a thread: hand over the task, pass on what is said."""
        way_in, way_out = self._process.stdin, self._process.stdout
        assert way_in is not None
        assert way_out is not None
        try:
            with way_out, suppress(EOFError, OSError, pickle.UnpicklingError):  # it has ended, or was stopped in the middle of a word
                with way_in:
                    pickle.dump(task, way_in)
                while True:
                    self._said.put(pickle.load(way_out))  # noqa: S301 — from a process of our own
            self._process.wait()
        finally:  # whoever waits must not wait for ever
            self._said.put(_END)


def _work() -> None:
    """Main function of the worker process."""
    own = os.dup(sys.stdout.fileno())
    os.dup2(sys.stderr.fileno(), sys.stdout.fileno())  # what libraries print must not be taken for an answer
    function, arguments = pickle.load(sys.stdin.buffer)  # noqa: S301 — from the process that started this one
    with os.fdopen(own, "wb") as way_out:

        def say(word: Any) -> None:
            pickle.dump(word, way_out)
            way_out.flush()

        try:
            function(say, *arguments)
        except MechStyleError as error:
            say(error)


if __name__ == "__main__":
    _work()
