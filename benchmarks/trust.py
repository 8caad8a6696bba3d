"""Kill runs, refuse them the disk and run two at once: nothing of a run may be lost.

    python benchmarks/trust.py [--seed N] [--sheet N] [--block N]

Each run that was killed must end, carried on, in the bytes of a run that nobody touched; exit code 1 if one does not.
"""

from __future__ import annotations

import argparse
import json
import os
import subprocess
import sys
import tempfile
from pathlib import Path

ROOT = Path(__file__).parents[1]


def main() -> int:
    """Run it in a process of its own, in a folder that is thrown away; print counts."""
    asked = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    asked.add_argument("--seed", type=int, default=0, help="of the moments")
    asked.add_argument("--sheet", type=int, default=110, help="kills of runs without physics")
    asked.add_argument("--block", type=int, default=30, help="kills of real runs of a small block")
    given = asked.parse_args()
    with tempfile.TemporaryDirectory(prefix="mechstyle-trust-") as folder:
        paths = os.pathsep.join([str(ROOT), str(ROOT / "tests")])
        environment = {**os.environ, "MECHSTYLE_CACHE": f"{folder}/cache", "PYTHONPATH": paths}
        command = [sys.executable, "-m", "support.kills", f"{folder}/runs", *map(str, (given.seed, given.sheet, given.block))]
        told = json.loads(subprocess.run(command, env=environment, stdout=subprocess.PIPE, check=True).stdout)
    wrong = [line for kind in ("sheet", "block") for line in told.get(kind, {}).get("wrong", [])]
    for kind in ("sheet", "block"):
        if kind in told:
            print(f"{kind}: {told[kind]['steps']} steps of writing in a run, {told[kind]['cpu']} CPU s")
            for what, count in sorted(told[kind]["counts"].items()):
                print(f"  {count:>5}  {what}")
    two = told.get("side by side", {"first": 0, "second": 2, "equal": 1})
    if two != {"first": 0, "second": 2, "equal": 1} | {"lanes": two.get("lanes", 1)}:
        wrong.append(f"two processes on one folder: {two}")
    if not told["clocks"]:
        wrong.append("a run whose clocks go backwards comes to other bytes")
    print(f"clocks going backwards: {'same bytes' if told['clocks'] else 'OTHER BYTES'}")
    print(f"two processes on one folder: {two}")
    for line in wrong:
        print(f"WRONG: {line}")
    print(f"{len(wrong)} wrong")
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
