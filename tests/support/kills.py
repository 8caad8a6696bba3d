"""Runs that are killed: `python -m support.kills FOLDER SEED SHEET REAL` prints what became of that many of each kind as JSON.

In a process of its own, because each run is a fork of it: two kinds are killed, lanes on a sheet, which are quick, and a real run of a
small block with
its tetrahedra and drops. What counts is that the folder ends with the bytes of one that nobody killed.
"""

from __future__ import annotations

import json
import os
import random
import signal
import sys
import time
from collections import Counter
from collections.abc import Callable
from pathlib import Path

from mechstyle.errors import MechStyleError
from mechstyle.loop.store import Store
from support.faults import KILLED, REFUSALS, STEPS, Steps, clocks_going_backwards, failing_at
from support.lanes import lane_on_a_sheet

Carry = Callable[[Path], object]
LEFT_BEHIND = ".new-"
"""Beginning of the name of a file that was being written when its process was killed; nothing reads it, `mechstyle gc` removes it."""


def contents(root: Path) -> dict[str, bytes]:
    """The bytes that two equal runs share: not what was left behind, who holds a lock, nor seconds and places in a summary."""
    files = [path for path in sorted(root.rglob("*")) if path.is_file() and not path.name.startswith(LEFT_BEHIND)]
    found = {str(path.relative_to(root)): path.read_bytes() for path in files if path.parent.name != "locks"}
    for name, content in found.items():
        if name.startswith("summaries"):
            found[name] = json.dumps({**json.loads(content), "seconds": None, "files": None}).encode()
    return found


def on_a_sheet(root: Path) -> object:
    """A lane on a sheet, from wherever it stands; with restraint and corrections to resume into."""
    return lane_on_a_sheet(root, gain=200.0, iterations=25, every=7)


def on_a_block(root: Path) -> object:
    """A real run of a small block; the same tetrahedra for all, as the cache has them."""
    from mechstyle.records.mesh import SurfaceMesh  # noqa: PLC0415 — physics is loaded where it is run
    from mechstyle.runs.recipes import recipe_for  # noqa: PLC0415
    from mechstyle.runs.run import Draft  # noqa: PLC0415
    from support.part_files import PART  # noqa: PLC0415

    drops = {"element": "tet4", "window": 0.1, "nearly_flat": False, "orientations": 2}
    wanted = recipe_for("bumps", iterations=8, schedule="every", every=3, **drops)
    return Draft(wanted, SurfaceMesh(PART.vertices, PART.faces), 1000, folder=root, device="cpu").begin().go()


def cpu_seconds() -> float:
    """CPU time of this process and of all forks that have ended [s]."""
    return sum(os.times()[:4])


def forked(work: Callable[[], object]) -> int:
    """Status of a fork that does some work: 0 done, 2 refused in a sentence, 3 anything else that was raised, -9 killed."""
    sys.stdout.flush()
    child = os.fork()
    if child == 0:
        status = 3
        try:
            work()
            status = 0
        except MechStyleError:
            status = 2
        except BaseException as error:  # noqa: BLE001 — a fork must not go on as its parent
            sys.stderr.write(f"{type(error).__name__}: {error}\n")
        finally:
            os._exit(status)
    return os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])


def faulty(carry: Carry, root: Path, steps: Steps) -> int:
    """Status of carrying a run on with a disk that fails."""

    def work() -> None:
        with failing_at(steps):
            carry(root)

    return forked(work)


def steps_of(carry: Carry, root: Path) -> int:
    """How many steps of writing a whole run takes; counted in a fork, as the memory of what was drawn before is not to help."""
    way_out, way_in = os.pipe()

    def work() -> None:
        with failing_at(Steps()) as steps:
            carry(root)
        os.write(way_in, str(steps.taken).encode())

    assert forked(work) == 0, "a run that nobody kills ends"
    os.close(way_in)
    with os.fdopen(way_out) as told:
        return int(told.read())


def killed_after(carry: Carry, root: Path, seconds: float) -> int:
    """Status of a run that is killed from outside, wherever it is after some seconds."""
    child = os.fork()
    if child == 0:
        try:
            carry(root)
        finally:
            os._exit(0)
    time.sleep(seconds)
    os.kill(child, signal.SIGKILL)
    return os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])


def survives(carry: Carry, folder: Path, seed: int, moments: int, *, refusals: int, outside: int = 0) -> dict[str, object]:
    """Kill runs of one kind at seeded moments, refuse them the disk at others, and carry each on to its end.

    Args:
        carry: Begins a run in a folder, or goes on with it.
        folder: Where.
        seed: Of the moments.
        moments: Kills inside writes.
        refusals: Faults of the disk that the process survives.
        outside: Kills from outside, at a time.

    Returns:
        Counts, and how every run that did not end in the bytes of a whole one was treated.
    """
    begun = cpu_seconds()
    draw, counts, wrong = random.Random(seed), Counter[str](), []
    whole = folder / "whole"
    total = steps_of(carry, whole)
    wanted = contents(whole)
    root = folder / "killed"
    done = 0
    while done < moments + refusals:
        fault = KILLED if done < moments else draw.choice(sorted(REFUSALS))
        at = draw.randrange(total)
        status = faulty(carry, root, Steps(fault, at, lasting=fault != KILLED))
        if status == (-signal.SIGKILL if fault == KILLED else 2):
            counts[f"{fault} in {STEPS[at % 3]}"] += 1
            done += 1
        elif status != 0:  # 0: this part of the run takes fewer steps
            wrong.append(f"{fault} at step {at}: status {status}")
            done += 1
        if status == 0 or draw.random() < 0.5:  # or it is killed again, further on
            if (ended := faulty(carry, root, Steps())) != 0 or contents(root) != wanted:
                wrong.append(f"{fault} at step {at}: carried on with status {ended} to other bytes")
            counts["ends compared"] += 1
            root = folder / f"killed-{done}-{counts['ends compared']}"
    for _ in range(outside):
        root = folder / f"outside-{counts['killed at a time']}"
        if killed_after(carry, root, draw.uniform(0.02, 2.0)) == -signal.SIGKILL:
            counts["killed at a time"] += 1
        if faulty(carry, root, Steps()) != 0 or contents(root) != wanted:
            wrong.append(f"killed from outside: other bytes in {root.name}")
        counts["ends compared"] += 1
    return {"steps": total, "counts": dict(counts), "wrong": wrong, "cpu": round(cpu_seconds() - begun, 1)}


def clocks_do_not_matter(folder: Path) -> bool:
    """Whether a run whose clocks go backwards comes to the bytes of another."""

    def work() -> None:
        with clocks_going_backwards():
            on_a_sheet(folder / "backwards")

    on_a_sheet(folder / "forwards")
    return forked(work) == 0 and contents(folder / "backwards") == contents(folder / "forwards")


def side_by_side(folder: Path) -> dict[str, int]:
    """Two processes begin one real run at once: how each ended, and 1 for the bytes of a run that had the folder for itself."""
    on = folder / "one"
    children = []
    for _ in range(2):
        child = os.fork()
        if child == 0:
            status = 3
            try:
                on_a_block(on)
                status = 0
            except MechStyleError as error:
                status = 2 if "being carried on by" in str(error) else 3
            finally:
                os._exit(status)
        children.append(child)
    statuses = sorted(os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]) for child in children)
    on_a_block(on)
    on_a_block(folder / "alone")
    equal = contents(on) == contents(folder / "alone")
    return {"first": statuses[0], "second": statuses[1], "equal": int(equal), "lanes": len(Store(on).lanes())}


def main(folder: Path, seed: int, sheet: int, real: int) -> dict[str, object]:
    """Everything, in counts."""
    told: dict[str, object] = {"sheet": survives(on_a_sheet, folder / "sheet", seed, sheet, refusals=max(sheet // 4, 3))}
    told["clocks"] = clocks_do_not_matter(folder / "clocks")
    if real:
        import mechstyle.runs.run  # noqa: F401, PLC0415 — once, and not in every fork

        assert forked(lambda: on_a_block(folder / "cached")) == 0, "the block is meshed once, for all"
        told["block"] = survives(on_a_block, folder / "block", seed, real, refusals=max(real // 4, 1), outside=max(real // 2, 1))
        told["side by side"] = side_by_side(folder / "two")
    return told


if __name__ == "__main__":
    sys.stdout.write(json.dumps(main(Path(sys.argv[1]), *map(int, sys.argv[2:5]))))
