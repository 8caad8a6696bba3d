"""What all tests share: repeatable Hypothesis runs, and two surfaces whose answers are known."""

import itertools
import json
import os
import shutil
from collections import Counter
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
import pytest
from hypothesis import settings
from xdist.scheduler import LoadScopeScheduling

from mechstyle._files import exclusive
from mechstyle.records.mesh import SurfaceMesh
from support.bench import Bench

# Derandomised: a red test is red for everybody. No deadline: two workers share the cores, and a slow example is not a wrong one.
settings.register_profile("repeatable", derandomize=True, deadline=None, max_examples=60)
settings.load_profile("repeatable")

# Corner 4x + 2y + z of the unit cube; two triangles a side, anticlockwise seen from outside.
_CUBE_SIDES = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]


class ByFile(LoadScopeScheduling):  # type: ignore[misc]  # xdist has no types
    """Tests of a file share what was set up for them, in one worker and in order.

    All tests in a browser are one file to it, because JupyterLab and Chromium take half a minute to start, and so are all lessons, which
    open one another's runs.
    """

    def _split_scope(self, nodeid: str) -> str:
        file = nodeid.partition("::")[0]
        return next((folder for folder in FIRST if file.startswith(folder)), file)


FIRST = ("tests/browser/", "tests/notebooks/")
"""The longest, one to each of two workers; short files fill the end, so that both are done together."""
STORED_TETS = Path(__file__).with_name("tets")
"""Tetrahedra of parts of the tests, as the cache keeps them by content: fTetWild takes seconds of a core for each, and gives others every
time. What is missing here is meshed; with $MECHSTYLE_STORE_TETS at 1 it is here afterwards. How parts are meshed is tested in
tests/geometry/remeshing, which keeps none."""


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Order files: the longest first, then by their number of tests."""
    tests = Counter(item.path for item in items)
    long = [item.nodeid.startswith(FIRST) for item in items]
    order = sorted(range(len(items)), key=lambda at: (not long[at], not long[at] and -tests[items[at].path]))
    items[:] = [items[at] for at in order]


def pytest_xdist_make_scheduler(config: pytest.Config, log: object) -> ByFile:
    """How tests are shared among workers."""
    config.option.loadscopereorder = False  # they are in order
    return ByFile(config, log)


def pytest_terminal_summary(terminalreporter: pytest.TerminalReporter, config: pytest.Config) -> None:
    """With `--durations`: where the time went, by room; seconds of all workers together."""
    if config.getoption("durations") is None:
        return
    seconds: Counter[str] = Counter()
    for report in itertools.chain(*terminalreporter.stats.values()):
        if isinstance(report, pytest.TestReport):
            place = Path(report.nodeid.partition("::")[0]).parts[1:]
            seconds[place[0] if place else "tests"] += report.duration
    terminalreporter.section("seconds by room")
    for room, spent in seconds.most_common():
        terminalreporter.line(f"{spent:8.1f} s  {room.removesuffix('.py')}")
    terminalreporter.line(f"{seconds.total():8.1f} s  together")


@pytest.fixture(scope="session")
def of_all(tmp_path_factory) -> Path:
    """The folder of all workers."""
    mine = tmp_path_factory.getbasetemp()
    return mine.parent if "PYTEST_XDIST_WORKER" in os.environ else mine


@pytest.fixture(scope="session", autouse=True)
def cache(of_all) -> Iterator[Path]:
    """One cache for all tests of all workers: each part is meshed once, and the user's own cache stays out of it."""
    tets = of_all / "cache" / "tets"
    with exclusive(of_all / "tets.lock", "tets", wait=True):
        if not tets.is_dir():
            shutil.copytree(STORED_TETS, tets)
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("MECHSTYLE_CACHE", str(of_all / "cache"))
        yield of_all / "cache"
    if os.environ.get("MECHSTYLE_STORE_TETS") == "1":
        shutil.copytree(tets, STORED_TETS, dirs_exist_ok=True)


@pytest.fixture(scope="session")
def made_once(of_all, tmp_path_factory) -> Callable[[str, Callable[[Path], None]], Path]:
    """A folder that is filled once for all workers, `made_once("clip", fill)`: each gets a copy of its own."""

    def made(name: str, fill: Callable[[Path], None]) -> Path:
        first, mine = of_all / "made" / name, tmp_path_factory.mktemp(name) / name
        with exclusive(of_all / "made" / f"{name}.lock", name, wait=True):
            if not first.is_dir():
                fill(mine)
                shutil.copytree(mine, first)
            elif not mine.is_dir():
                shutil.copytree(first, mine)
        return mine

    return made


@pytest.fixture(scope="session")
def cube() -> SurfaceMesh:
    """A cube of side 10 mm in the positive octant: 8 vertices, 12 faces."""
    corners = np.array(list(itertools.product((0.0, 10.0), repeat=3)))
    return SurfaceMesh(corners, np.array([face for a, b, c, d in _CUBE_SIDES for face in ((a, b, c), (a, c, d))]))


@pytest.fixture(scope="session")
def sphere() -> SurfaceMesh:
    """A sphere of radius 10 mm about the origin, octahedron quartered five times: 4098 vertices, 8192 faces."""
    points = np.array([(1, 0, 0), (-1, 0, 0), (0, 1, 0), (0, -1, 0), (0, 0, 1), (0, 0, -1)], dtype=float)
    faces = np.array([(0, 2, 4), (2, 1, 4), (1, 3, 4), (3, 0, 4), (2, 0, 5), (1, 2, 5), (3, 1, 5), (0, 3, 5)])
    for _ in range(5):
        edges, which = np.unique(np.sort(faces[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1), axis=0, return_inverse=True)
        ab, bc, ca = (len(points) + which.reshape(-1, 3)).T
        a, b, c = faces.T
        points = np.vstack([points, points[edges].mean(axis=1)])
        points /= np.linalg.norm(points, axis=1, keepdims=True)
        faces = np.vstack([np.stack(three, axis=1) for three in ((a, ab, ca), (b, bc, ab), (c, ca, bc), (ab, bc, ca))])
    return SurfaceMesh(10.0 * points, faces)


@pytest.fixture(scope="session")
def tiny_clip(made_once) -> Path:
    """A folder with a CLIP of a few thousand random parameters and a tokenizer of single letters, as transformers saves the real one."""
    return made_once("tiny", write_clip)


def write_clip(folder: Path) -> None:
    """Fill a folder as transformers does."""
    import torch  # noqa: PLC0415 — seconds, and few tests need it
    from tokenizers.pre_tokenizers import ByteLevel  # noqa: PLC0415
    from transformers import CLIPConfig, CLIPModel  # noqa: PLC0415

    letters = sorted(ByteLevel.alphabet())
    tokens = [*letters, *(letter + "</w>" for letter in letters), "<|startoftext|>", "<|endoftext|>"]
    size = {"hidden_size": 32, "intermediate_size": 64, "num_hidden_layers": 2, "num_attention_heads": 2}
    words = {**size, "vocab_size": len(tokens), "bos_token_id": len(tokens) - 2, "eos_token_id": len(tokens) - 1}
    config = CLIPConfig(text_config=words, vision_config={**size, "image_size": 32, "patch_size": 8}, projection_dim=16)
    with torch.random.fork_rng(devices=[]):
        torch.manual_seed(0)
        CLIPModel(config).save_pretrained(folder)
    (folder / "vocab.json").write_text(json.dumps({token: number for number, token in enumerate(tokens)}))
    (folder / "merges.txt").write_text("#version: 0.2\n")


@pytest.fixture
def bench(tmp_path) -> Bench:
    """The loop without physics: a stylizer that grows a bump, a simulator whose stress is a known function of the relief."""
    return Bench(tmp_path / "run")
