"""Read files and command lines as nobody should write them: no crash, no hang, no traceback, no memory that the file does not account for.

    python benchmarks/fuzz.py [--seed N] [--cases N]

On stderr it says how far it is, and what is wrong as soon as it is. Exit code 1 if one case is; it is named by kind and number, and
`python -m support.hostile` with the tests' folder on the path does it again.
"""

from __future__ import annotations

import argparse
import json
import os
import subprocess
import sys
import tempfile
from collections import Counter
from pathlib import Path
from typing import Any

sys.path.insert(0, str(Path(__file__).parents[1] / "tests"))
from support.hostile import CASE, WRONG

ROOT = Path(__file__).parents[1]
AT_ONCE = 1000
"""Cases a process: one that crashes takes no more than these with it."""
TOLD = 100
"""Cases between two lines of progress."""


def main() -> int:
    """Try them in processes of their own; print counts and what was wrong."""
    asked = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    asked.add_argument("--seed", type=int, default=0, help="of the first case")
    asked.add_argument("--cases", type=int, default=10_000, help="how many")
    given = asked.parse_args()
    counts, wrong, cpu, megabytes, each = Counter(), [], 0.0, 0, min(AT_ONCE, given.cases)
    for part in range(given.seed, given.seed + -(-given.cases // AT_ONCE)):
        told, found = in_a_process(part, each, (part - given.seed) * each, given.cases)
        wrong += found
        counts.update(told["counts"])
        cpu, megabytes = cpu + told["cpu"], max(megabytes, told["megabytes"])
    for what, count in sorted(counts.items()):
        print(f"  {count:>6}  {what}")
    for line in wrong:
        print(f"{WRONG}{line}")
    sound = counts["read"] + counts["refused"]
    print(f"{sound} cases read or refused in a sentence, {len(wrong)} wrong; {cpu:.0f} CPU s, {megabytes} MB at most")
    return 1 if wrong else 0


def in_a_process(part: int, count: int, before: int, whole: int) -> tuple[dict[str, Any], list[str]]:
    """Try the cases of a part in a process: what it tells, and what is wrong, which was said on stderr when it was found."""
    wrong, last, tried = [], "", 0
    with tempfile.TemporaryDirectory(prefix="mechstyle-fuzz-") as folder:
        paths = os.pathsep.join([str(ROOT), str(ROOT / "tests")])
        environment = {**os.environ, "MECHSTYLE_CACHE": f"{folder}/cache", "PYTHONPATH": paths}
        command = [sys.executable, "-m", "support.hostile", f"{folder}/cases", str(part), str(count)]
        with subprocess.Popen(command, env=environment, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as process:
            for line in process.stderr:
                if line.startswith(WRONG):
                    wrong.append(line.removeprefix(WRONG).strip())
                    sys.stderr.write(line)
                elif line.startswith(CASE):
                    last, tried = line.removeprefix(CASE).strip(), tried + 1
                    if tried % TOLD == 0:
                        sys.stderr.write(f"{before + tried} of {whole} cases, {len(wrong)} wrong in these {count}\n")
            said = process.stdout.read()
    if process.returncode:
        wrong.append(f"the process crashed with {process.returncode} at {last}")
        sys.stderr.write(f"{WRONG}{wrong[-1]}\n")
        return {"counts": {}, "cpu": 0.0, "megabytes": 0}, wrong
    return json.loads(said.splitlines()[-1]), wrong


if __name__ == "__main__":
    sys.exit(main())
