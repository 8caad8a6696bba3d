"""Read files and command lines as nobody should write them: no crash, no hang, no traceback, no memory that the file does not account for.

    python benchmarks/fuzz.py [--first N] [--cases N] [--jobs N]

On stderr it says how far it is, and what is wrong as soon as it is. Exit code 1 if one case is; it is named by kind and number, and
`--first NUMBER --cases 1` does it again. It needs what MechStyle needs, and no tools of tests.
"""

from __future__ import annotations

import argparse
import json
import os
import subprocess
import sys
import tempfile
from collections import Counter
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

sys.path.insert(0, str(Path(__file__).parents[1] / "tests"))
from support.hostile import CASE, WRONG

ROOT = Path(__file__).parents[1]
AT_ONCE = 200
"""Cases a process: one that crashes takes no more than these with it."""


def main() -> int:
    """Try them in processes of their own; print counts and what was wrong."""
    asked = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    asked.add_argument("--first", type=int, default=0, help="number of the first case")
    asked.add_argument("--cases", type=int, default=10_000, help="how many")
    asked.add_argument("--jobs", type=int, default=1, help="processes at once")
    given = asked.parse_args()
    counts, wrong, cpu, megabytes, end = Counter(), [], 0.0, 0, given.first + given.cases
    parts = [(first, min(AT_ONCE, end - first)) for first in range(given.first, end, AT_ONCE)]
    with ThreadPoolExecutor(given.jobs) as processes:
        for (first, count), (said, found) in zip(parts, processes.map(in_a_process, parts), strict=True):
            wrong += found
            counts.update(said["counts"])
            cpu, megabytes = cpu + said["cpu"], max(megabytes, said["megabytes"])
            sys.stderr.write(f"{first + count - given.first} of {given.cases} cases, {len(wrong)} wrong, {cpu:.0f} CPU s\n")
    for what, count in sorted(counts.items()):
        print(f"  {count:>6}  {what}")
    for line in wrong:
        print(f"{WRONG}{line}")
    sound = counts["read"] + counts["refused"]
    print(f"{sound} cases read or refused in a sentence, {len(wrong)} wrong; {cpu:.0f} CPU s, {megabytes} MB at most")
    return 1 if wrong else 0


def in_a_process(part: tuple[int, int]) -> tuple[dict[str, Any], list[str]]:
    """Try cases, by the number of the first and their count, in a process: what it says, and what is wrong, which is on stderr at once."""
    wrong, last = [], ""
    with tempfile.TemporaryDirectory(prefix="mechstyle-fuzz-") as folder:
        paths = os.pathsep.join([str(ROOT), str(ROOT / "tests")])
        environment = {**os.environ, "MECHSTYLE_CACHE": f"{folder}/cache", "PYTHONPATH": paths}
        command = [sys.executable, "-m", "support.hostile", f"{folder}/cases", *map(str, part)]
        with subprocess.Popen(command, env=environment, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as process:
            for line in process.stderr:
                if line.startswith(WRONG):
                    wrong.append(line.removeprefix(WRONG).strip())
                    sys.stderr.write(line)
                elif line.startswith(CASE):
                    last = line.removeprefix(CASE).strip()
            said = process.stdout.read()
    if process.returncode:
        wrong.append(f"the process crashed with {process.returncode} at {last}")
        sys.stderr.write(f"{WRONG}{wrong[-1]}\n")
        return {"counts": {}, "cpu": 0.0, "megabytes": 0}, wrong
    return json.loads(said.splitlines()[-1]), wrong


if __name__ == "__main__":
    sys.exit(main())
