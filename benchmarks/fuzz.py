"""Read files and command lines as nobody should write them: no crash, no hang, no traceback, no memory that the file does not account for.

    python benchmarks/fuzz.py [--seed N] [--cases N]

Exit code 1 if one case is wrong; it is named by kind and number, and `python -m support.hostile` with the tests' folder on the path does
it again.
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

ROOT = Path(__file__).parents[1]
AT_ONCE = 1000
"""Cases a process: one that crashes takes no more than these with it."""


def main() -> int:
    """Try them in processes of their own; print counts and what was wrong."""
    asked = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    asked.add_argument("--seed", type=int, default=0, help="of the first case")
    asked.add_argument("--cases", type=int, default=10_000, help="how many")
    given = asked.parse_args()
    counts, wrong, cpu, megabytes = Counter(), [], 0.0, 0
    for part in range(given.seed, given.seed + -(-given.cases // AT_ONCE)):
        with tempfile.TemporaryDirectory(prefix="mechstyle-fuzz-") as folder:
            paths = os.pathsep.join([str(ROOT), str(ROOT / "tests")])
            environment = {**os.environ, "MECHSTYLE_CACHE": f"{folder}/cache", "PYTHONPATH": paths}
            command = [sys.executable, "-m", "support.hostile", f"{folder}/cases", str(part), str(min(AT_ONCE, given.cases))]
            done = subprocess.run(command, env=environment, capture_output=True, text=True, check=False)
        if done.returncode:
            wrong.append(f"the process crashed with {done.returncode}: {done.stderr.splitlines()[-3:]}")
            continue
        told = json.loads(done.stdout.splitlines()[-1])
        counts.update(told["counts"])
        wrong += told["wrong"]
        cpu, megabytes = cpu + told["cpu"], max(megabytes, told["megabytes"])
    for what, count in sorted(counts.items()):
        print(f"  {count:>6}  {what}")
    for line in wrong:
        print(f"WRONG: {line}")
    sound = counts["read"] + counts["refused"]
    print(f"{sound} cases read or refused in a sentence, {len(wrong)} wrong; {cpu:.0f} CPU s, {megabytes} MB at most")
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
