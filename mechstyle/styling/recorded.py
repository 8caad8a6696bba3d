"""A function of tensors that a GPU records once, then repeats as a whole: launching a thousand kernels takes longer than running them."""

from __future__ import annotations

from collections.abc import Callable

import torch

from mechstyle.styling.guidance import Draws

WARM_UP = 3
"""Calls before recording, in which libraries choose their algorithms and set their memory aside."""


class Recorded:
    """Calls a function a few times, then records it as a CUDA graph and from then on replays that.

    The function may depend on nothing but its argument and on tensors that stay where they are, and must not wait for the GPU.
    """

    def __init__(self, function: Callable[[Draws], None]) -> None:
        self._function = function
        self._calls = 0
        self._graph: torch.cuda.CUDAGraph | None = None

    def __call__(self, draws: Draws) -> None:
        """The function of these draws."""
        if self._calls < WARM_UP:
            self._calls += 1
            self._aside(draws)
            return
        if self._graph is None:
            self._inputs = draws  # whose memory the graph reads; later draws are copied there
            self._graph = torch.cuda.CUDAGraph()
            with torch.cuda.graph(self._graph):  # records, without running anything
                self._function(draws)
        for place, value in zip(self._inputs.tensors, draws.tensors, strict=True):
            place.copy_(value)
        self._graph.replay()

    def _aside(self, draws: Draws) -> None:
        """Call the function on another stream than the default one, on which nothing can be recorded afterwards."""
        stream, before = torch.cuda.Stream(), torch.cuda.current_stream()
        stream.wait_stream(before)
        with torch.cuda.stream(stream):
            self._function(draws)
        before.wait_stream(stream)
