"""Seconds per iteration of guidance by CLIP on a tube of 25k vertices, with random weights of ViT-B/32: a report, not a test.

Speed does not depend on what the weights are, so none are fetched. Wall time depends on what else the machine does; CPU time beside it.

    python benchmarks/clip.py [--device cpu|cuda] [--images 15|25|35|45] [--iterations 5] [--field network|vertex] [--eager]

On CUDA an iteration is replayed as a graph once it has been recorded; --eager launches its kernels one by one instead.
"""

from __future__ import annotations

import argparse
import platform
import statistics
import sys
import time
from typing import Any

import numpy as np
import torch
from transformers import BatchEncoding, CLIPConfig, CLIPModel

from mechstyle.records.mesh import SurfaceMesh
from mechstyle.styling.learned import stylizer as learned
from mechstyle.styling.learned.clip import Clip
from mechstyle.styling.learned.guidance import VIEWS, ClipGuidance
from mechstyle.styling.learned.renderer import Renderer
from mechstyle.styling.learned.style_field import StyleField
from mechstyle.styling.learned.stylizer import FIELD_RATE, VERTEX_RATE, NeuralStylizer, VertexField
from mechstyle.styling.learned.unit_shape import UnitShape

WARM_UP = 5


class FirstWords:
    """Stands in for the tokenizer, whose vocabulary comes with real weights: every prompt is the same two words."""

    def __call__(self, prompt: str, return_tensors: str) -> BatchEncoding:  # noqa: ARG002
        """Begin, two words, end, in the numbering of CLIP's vocabulary."""
        ids = torch.tensor([[49406, 320, 4133, 49407]])
        return BatchEncoding({"input_ids": ids, "attention_mask": torch.ones_like(ids)})


def tube(inner: float = 37.0, outer: float = 40.0, height: float = 100.0, around: int = 158, along: int = 158) -> SurfaceMesh:
    """The wall of a pen holder [mm], 25k vertices 1.3 to 1.6 mm apart, made here so that nothing but the stylizer is needed."""
    corners = np.array([(inner, 0.0), (outer, 0.0), (outer, height), (inner, height), (inner, 0.0)])
    walked = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(corners, axis=0), axis=1))])
    place = np.linspace(0.0, walked[-1], along, endpoint=False)
    radius, z = (np.interp(place, walked, corners[:, axis])[:, None] for axis in (0, 1))
    angle = np.linspace(0.0, 2.0 * np.pi, around, endpoint=False)
    vertices = np.stack([radius * np.cos(angle), radius * np.sin(angle), z + 0.0 * angle], axis=2).reshape(-1, 3)
    here = np.arange(along * around).reshape(along, around)
    right, up = np.roll(here, -1, axis=1), np.roll(here, -1, axis=0)
    faces = np.concatenate([np.stack([here, right, up], axis=2), np.stack([right, np.roll(right, -1, axis=0), up], axis=2)])
    return SurfaceMesh(vertices, faces.reshape(-1, 3))


def prepared(device: str, images: int, field: str) -> NeuralStylizer:
    """A stylizer of the tube, guided by random weights."""
    part = tube()
    torch.manual_seed(0)
    clip = Clip(CLIPModel(CLIPConfig()), FirstWords(), device)
    bound = np.full(len(part.vertices), 0.36)
    shape = UnitShape.of(part, bound, bound, np.ones(len(part.vertices)), device)
    renderer = Renderer(torch.tensor(part.faces), clip.picture_size, device=device)
    guidance = ClipGuidance(clip, "brick", renderer, crops=(images // VIEWS - 1) // 2, device=device)
    if field == "vertex":
        return NeuralStylizer(shape, VertexField(len(part.vertices)), guidance, rate=VERTEX_RATE)
    return NeuralStylizer(shape, StyleField(clip.text_size), guidance, rate=FIELD_RATE)


def timed(stylizer: NeuralStylizer, iterations: int, device: str) -> tuple[list[float], float]:
    """Wall seconds of each iteration, and CPU seconds per iteration."""
    seconds = []
    cpu = time.process_time()
    for _ in range(iterations):
        start = time.perf_counter()
        stylizer.step()
        if device != "cpu":
            torch.cuda.synchronize()
        seconds.append(time.perf_counter() - start)
    return seconds, (time.process_time() - cpu) / iterations


def hardware(device: str) -> str:
    """What it ran on."""
    if device != "cpu":
        return torch.cuda.get_device_name()
    return f"{platform.processor() or platform.machine()}, {torch.get_num_threads()} threads"


def arguments() -> Any:
    """The command line."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--device", default="cpu", choices=("cpu", "cuda"))
    parser.add_argument("--images", type=int, default=15, choices=range(3 * VIEWS, 34 * VIEWS, 2 * VIEWS))
    parser.add_argument("--iterations", type=int, default=5)
    parser.add_argument("--field", default="network", choices=("network", "vertex"))
    parser.add_argument("--eager", action="store_true")
    return parser.parse_args()


def main() -> None:
    """Print milliseconds per iteration."""
    asked = arguments()
    if asked.eager:
        learned.WARM_UP = sys.maxsize
    stylizer = prepared(asked.device, asked.images, asked.field)
    first, _ = timed(stylizer, 1 if asked.device == "cpu" else WARM_UP, asked.device)
    seconds, cpu = timed(stylizer, asked.iterations, asked.device)
    print(f"{hardware(asked.device)}: {asked.images} images, {asked.field}, torch {torch.__version__}")
    print(f"  first {first[0]:.2f} s")
    median, least = 1e3 * statistics.median(seconds), 1e3 * min(seconds)
    print(f"  then median {median:.1f} ms, least {least:.1f} ms an iteration; CPU time {1e3 * cpu:.0f} ms")
    proposal = stylizer.proposal()
    for _ in range(0 if asked.eager or asked.device == "cpu" else WARM_UP):
        stylizer.loss(proposal.displacement, proposal.colour)
    start = time.perf_counter()
    stylizer.loss(proposal.displacement, proposal.colour)
    print(f"  style loss of a surface {1e3 * (time.perf_counter() - start):.1f} ms")
    if asked.device != "cpu":
        print(f"  peak memory {torch.cuda.max_memory_allocated() / 2**30:.2f} GiB")


if __name__ == "__main__":
    main()
