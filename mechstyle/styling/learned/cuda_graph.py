"""A function of tensors that a GPU records once, then repeats as a whole: launching a thousand kernels takes longer than running them."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from typing import Generic, Protocol, TypeVar

import torch

WARM_UP = 3
"""Calls before recording, in which libraries choose their algorithms and set their memory aside."""


class Tensors(Protocol):
    """An argument whose tensors can be listed, always in the same order and of the same shapes."""

    @property
    def tensors(self) -> tuple[torch.Tensor, ...]:
        """All of them."""


Given = TypeVar("Given", bound=Tensors)
Found = TypeVar("Found")


class Recorded(Generic[Given, Found]):
    """Calls a function a few times, then records it as a CUDA graph and from then on replays that.

    The function may depend on nothing but its argument and on tensors that stay where they are, and must not wait for the GPU. What it
    returns is overwritten by the next call.
    """

    def __init__(self, function: Callable[[Given], Found], gpu: torch.device) -> None:
        self._function, self._gpu = function, gpu
        self._calls = 0
        self._graph: torch.cuda.CUDAGraph | None = None

    def __call__(self, given: Given) -> Found:
        """The function of this, on its GPU."""
        with torch.cuda.device(self._gpu):
            return self._called(given)

    def _called(self, given: Given) -> Found:
        if self._calls < WARM_UP:
            self._calls += 1
            return self._aside(given)
        if self._graph is None:
            self._given = given  # whose memory the graph reads; what is given later is copied there
            self._graph = torch.cuda.CUDAGraph()
            with torch.cuda.graph(self._graph, stream=_side(torch.cuda.current_device())):  # records, without running anything
                self._found = self._function(given)
        for place, value in zip(self._given.tensors, given.tensors, strict=True):
            place.copy_(value)
        self._graph.replay()
        return self._found

    def _aside(self, given: Given) -> Found:
        """Call the function on another stream than the default one, on which nothing can be recorded afterwards."""
        stream, before = _side(torch.cuda.current_device()), torch.cuda.current_stream()
        stream.wait_stream(before)
        with torch.cuda.stream(stream):
            found = self._function(given)
        before.wait_stream(stream)
        return found


@cache
def _side(device: int) -> torch.cuda.Stream:
    """The stream of all that is recorded on a GPU: autograd wants a gradient where the values came from, another function's, maybe."""
    return torch.cuda.Stream(device)
