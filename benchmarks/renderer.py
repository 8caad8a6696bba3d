"""Milliseconds of the renderer that guides a style, forward and with gradients: a report, not a test.

The surface is a torus with bumps, about as fine as a standardised part. On CUDA the same work is also replayed as one graph.

    python benchmarks/renderer.py [--device cpu|cuda] [--views 5] [--size 224] [--repeats 7]
"""

from __future__ import annotations

import argparse
import math
import time
from collections.abc import Callable

import torch

from mechstyle.styling.learned.renderer import Renderer, random_views

AROUND, ALONG = 250, 100
BUDGET = 350.0
"""Milliseconds of forward and backward of five views of 224² on one core."""
VARIANTS = {"hard outlines": {"antialias": False}, "faded outlines": {}}


def torus(device: str) -> tuple[torch.Tensor, torch.Tensor]:
    """Positions within the unit sphere, shape [25000, 3], and faces, shape [50000, 3]."""
    u, v = torch.meshgrid(*(torch.arange(count) * (2 * math.pi / count) for count in (AROUND, ALONG)), indexing="ij")
    tube = 0.3 + 0.02 * torch.sin(11 * u) * torch.cos(7 * v)
    ring = 0.62 + tube * v.cos()
    positions = torch.stack([ring * u.cos(), tube * v.sin(), -ring * u.sin()], dim=-1).view(-1, 3)
    number = torch.arange(AROUND * ALONG).view(AROUND, ALONG)
    a, b, c, d = number, number.roll(-1, 0), number.roll((-1, -1), (0, 1)), number.roll(-1, 1)
    faces = torch.stack([torch.stack(three, dim=-1) for three in ((a, b, c), (a, c, d))]).view(-1, 3)
    return positions.to(device), faces.to(device)


def milliseconds(work: Callable[[], object], repeats: int, device: str) -> float:
    """The shortest of several runs, after one that compiles."""
    times = []
    for _ in range(repeats + 1):
        start = time.perf_counter()
        work()
        if device != "cpu":
            torch.cuda.synchronize()
        times.append(1e3 * (time.perf_counter() - start))
    return min(times[1:])


def as_graph(work: Callable[[], object]) -> Callable[[], object]:
    """The same work recorded once and replayed."""
    side = torch.cuda.Stream()
    side.wait_stream(torch.cuda.current_stream())
    with torch.cuda.stream(side):
        for _ in range(3):
            work()
    torch.cuda.current_stream().wait_stream(side)
    graph = torch.cuda.CUDAGraph()
    with torch.cuda.graph(graph):
        work()
    return graph.replay


def main() -> None:
    """Print a line per variant."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--device", default="cpu")
    for name, default in (("views", 5), ("size", 224), ("repeats", 7)):
        parser.add_argument(f"--{name}", type=int, default=default)
    given = parser.parse_args()
    torch.set_num_threads(1)
    positions, faces = torus(given.device)
    colours = (0.5 + 0.4 * torch.sin(9 * positions)).requires_grad_()
    positions.requires_grad_()
    cameras = random_views(given.views, (0.5, 0.3), 4.0, torch.Generator().manual_seed(0)).to(given.device)
    print(f"{given.views} views of {given.size}², {len(positions)} vertices, {given.device} [ms]; budget {BUDGET:g} on one core")
    totals = {}
    for name, options in VARIANTS.items():
        renderer = Renderer(faces, given.size, device=given.device, **options)

        def forward(renderer: Renderer = renderer) -> torch.Tensor:
            return renderer(positions, colours, cameras).image

        def both(forward: Callable[[], torch.Tensor] = forward) -> object:
            return torch.autograd.grad(forward().square().mean(), (positions, colours))

        totals[name] = milliseconds(both, given.repeats, given.device)
        line = f"{name:15} forward {milliseconds(forward, given.repeats, given.device):7.2f}   with gradients {totals[name]:7.2f}"
        if given.device != "cpu":
            line += f"   as a graph {milliseconds(as_graph(both), given.repeats, given.device):7.2f}"
        print(line)
    print(f"faded to hard outlines: {totals['faded outlines'] / totals['hard outlines']:.2f}")


if __name__ == "__main__":
    main()
