"""The stylizer that descends a guidance by gradients: a style field or a value per vertex, towards a target or a prompt.

A GPU records an iteration once, then repeats it as a whole: launching a thousand kernels takes longer than running them.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import cache
from typing import Generic, NamedTuple, TypeVar

import numpy as np
import torch
from numpy.typing import ArrayLike
from torch import nn
from torch.utils import deterministic

from mechstyle.records.mesh import Field
from mechstyle.styling.learned.guidance import ClipDraws, Draws, Guidance, NoDraws
from mechstyle.styling.learned.style_field import standardised
from mechstyle.styling.learned.unit_shape import Logits, Look, UnitShape
from mechstyle.styling.style import Proposal

FIELD_RATE = 5e-4
VERTEX_RATE = 2e-2
"""Steps of Adam for the network, as published, and for values per vertex, which reach their bounds in about a hundred of them."""
DECAY = 0.9
DECAY_EVERY = 100

os.environ.setdefault("CUBLAS_WORKSPACE_CONFIG", ":4096:8")  # without it no product of matrices is repeatable on a GPU


class Surface(NamedTuple):
    """Argument of the loss: a displacement [mm], shape [n], and colours, shape [n, 3]."""

    displacement: torch.Tensor
    colour: torch.Tensor

    @property
    def tensors(self) -> tuple[torch.Tensor, ...]:
        """Both."""
        return tuple(self)


class VertexField(nn.Module):
    """Colour and displacement before their bounds as free values per vertex, zero at first; stands where a style field may."""

    def __init__(self, count: int) -> None:
        super().__init__()
        self.colour = nn.Parameter(torch.zeros(count, 3))
        self.displacement = nn.Parameter(torch.zeros(count, 1))

    def features(self, points: torch.Tensor) -> torch.Tensor:
        """The points: the values do not depend on them."""
        return points

    def forward(self, features: torch.Tensor, text: torch.Tensor) -> tuple[torch.Tensor, torch.Tensor]:  # noqa: ARG002
        """Colour, shape [n, 3], and displacement, shape [n, 1]."""
        return self.colour, self.displacement


class NeuralStylizer:
    """Adam on the parameters of a field, one step an iteration, with the published schedule of its rate.

    It is open loop: a hard mask of frozen vertices is part of the shape and so of the gradient, but what the engine holds back elsewhere
    is never fed back. Everything random in iteration i is drawn from a generator seeded by (seed, i), so a state needs no generator's.

    Args:
        shape: The part with its bounds and frozen vertices.
        field: A `StyleField` or a `VertexField`; its initial parameters are where every style starts.
        guidance: What is wanted.
        rate: Initial step of Adam.
        seed: Decides views and crops.
    """

    _draws: Draws

    def __init__(self, shape: UnitShape, field: nn.Module, guidance: Guidance, *, rate: float, seed: int = 0) -> None:
        self._shape, self._guidance, self._rate, self._seed = shape, guidance, rate, seed
        self._field = field.to(shape.positions.device)
        self._first = {name: value.clone() for name, value in self._field.state_dict().items()}
        gpu = shape.positions.device
        self._distance = Recorded(self._distant, gpu) if shape.positions.is_cuda else self._distant
        count = len(shape.positions)
        self.start_from(np.zeros(count), np.full((count, 3), 0.5))

    def proposal(self) -> Proposal:
        """The current proposal; at first no displacement and mid-grey."""
        return Proposal(_array(self._seen.displacement), _array(self._seen.colour))

    def step(self) -> Proposal:
        """One iteration of descent."""
        self._adam.param_groups[0]["lr"].fill_(self._rate * DECAY ** (self._iteration // DECAY_EVERY))
        with _repeatable():
            self._descend(self._draws)
            self._seen = self._look(NoDraws())  # what is proposed now, and what the next iteration descends from
        self._iteration += 1
        self._draws = self._drawn()  # of the next iteration, while a GPU is still at this one
        return self.proposal()

    def loss(self, displacement: ArrayLike, colour: ArrayLike) -> float:
        """Distance of any displacement [mm], shape [n], and colour, shape [n, 3], from what is wanted."""
        with torch.no_grad(), _repeatable():
            return float(self._distance(Surface(self._tensor(displacement), self._tensor(colour))))

    def start_from(self, displacement: ArrayLike, colour: ArrayLike) -> None:
        """Begin afresh at a surface another style has left: the field's output is added to what gives that surface."""
        self._start = self._shape.logits(self._tensor(displacement), self._tensor(colour))
        self._begin(self._first, 0)

    def state(self) -> dict[str, Field]:
        """The field with its buffers, both moments of Adam, where it started and the iteration (exact in float32 up to 2²⁴)."""
        moments = {name: self._adam.state.get(value, {}) for name, value in self._field.named_parameters()}
        none = {name: torch.zeros_like(value) for name, value in self._field.named_parameters()}
        tensors = {
            **{f"field/{name}": value for name, value in self._field.state_dict().items()},
            **{f"first/{name}": moment.get("exp_avg", none[name]) for name, moment in moments.items()},
            **{f"second/{name}": moment.get("exp_avg_sq", none[name]) for name, moment in moments.items()},
            "start/colour": self._start.colour, "start/displacement": self._start.displacement,
            "iteration": torch.tensor([float(self._iteration)]),
        }  # fmt: skip
        return {name: _array(value) for name, value in tensors.items()}

    def restore(self, state: dict[str, Field]) -> None:
        """Go on from a `state` of a stylizer of the same part, field and guidance with the same bytes."""
        tensors = {name: self._tensor(value) for name, value in state.items()}
        self._start = Logits(tensors["start/colour"], tensors["start/displacement"])
        self._begin({name: tensors[f"field/{name}"] for name in self._first}, int(state["iteration"][0]))
        for name, parameter in self._field.named_parameters():
            moments = {"exp_avg": tensors[f"first/{name}"], "exp_avg_sq": tensors[f"second/{name}"]}
            self._adam.state[parameter] = {"step": self._tensor(float(self._iteration)), **moments}

    def _distant(self, surface: Surface) -> torch.Tensor:
        return self._guidance.distance(Look(*surface, self._shape.placed(surface.displacement)))

    def _descended(self, draws: Draws) -> None:
        """Loss of what was seen last, gradient and step: a function of tensors, so that a GPU may record it."""
        self._adam.zero_grad()
        self._guidance.loss(self._seen, draws).backward()
        self._adam.step()

    def _looked(self, _: NoDraws) -> Look:
        colour, displacement = self._field(self._features, self._guidance.text)
        return self._shape.look(Logits(colour + self._start.colour, displacement[:, 0] + self._start.displacement))

    def _drawn(self) -> Draws:
        return self._guidance.draw(torch.Generator().manual_seed(self._seed * 1_000_003 + self._iteration))

    def _begin(self, parameters: dict[str, torch.Tensor], iteration: int) -> None:
        self._field.load_state_dict(parameters)
        on_gpu, gpu = self._shape.positions.is_cuda, self._shape.positions.device
        self._adam = torch.optim.Adam(self._field.parameters(), lr=self._tensor(self._rate), fused=on_gpu, capturable=on_gpu)
        self._descend: Callable[[Draws], None] = Recorded(self._descended, gpu) if on_gpu else self._descended
        self._look: Callable[[NoDraws], Look] = Recorded(self._looked, gpu) if on_gpu else self._looked
        self._iteration = iteration
        with torch.no_grad():  # computed once: neither the points nor the frequencies change from here
            self._features = self._field.features(standardised(self._shape.positions))
        with _repeatable():
            self._seen = self._look(NoDraws())
        self._draws = self._drawn()

    def _tensor(self, values: ArrayLike) -> torch.Tensor:
        return torch.tensor(np.asarray(values), dtype=torch.float32, device=self._shape.positions.device)


def _array(tensor: torch.Tensor) -> Field:
    array: Field = tensor.detach().cpu().numpy().copy()
    return array


@contextmanager
def _repeatable() -> Iterator[None]:
    """Deterministic algorithms on; on a GPU matrix products in TF32 (10-bit mantissa)."""
    before, filled = torch.are_deterministic_algorithms_enabled(), deterministic.fill_uninitialized_memory
    products = torch.backends.cuda.matmul.fp32_precision
    torch.backends.cuda.matmul.fp32_precision = "tf32"
    torch.use_deterministic_algorithms(mode=True)
    deterministic.fill_uninitialized_memory = False  # nothing here reads what it has not written, and filling takes a seventh of the time
    try:
        yield
    finally:
        torch.use_deterministic_algorithms(mode=before)
        deterministic.fill_uninitialized_memory = filled
        torch.backends.cuda.matmul.fp32_precision = products


WARM_UP = 3
"""Calls before recording, in which libraries choose their algorithms and set their memory aside."""


Given = TypeVar("Given", bound=Surface | NoDraws | ClipDraws)
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
