"""Do the tests notice when the code is wrong? Small seeded changes of the pure modules, one at a time, each against its module's own tests.

A change (mutant) that fails a test is killed; one that passes them all survives. A survivor that cannot be seen from outside is explained
in mutants.toml beside this file, one by one. The run fails if a survivor is not explained there, or if more than 8 % survive.
The working tree is never written: a mutant exists only in the memory of the process that tests it.

    python benchmarks/mutants.py [--seed 0] [--per-module 16] [--module prompt] [--workers 2]
    python benchmarks/mutants.py --drawn 25 [--seed 0]    # of the whole product, each against its module's own tests

Changed are comparisons, arithmetic, logic, numbers, booleans, conditions, opposites such as min and max, statements that can be left out
and what is returned; not texts, and not annotations.
"""

from __future__ import annotations

import argparse
import ast
import builtins
import contextlib
import importlib.util
import itertools
import json
import linecache
import os
import random
import re
import signal
import subprocess
import sys
import time
import tomllib
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import asdict, dataclass
from importlib.machinery import ModuleSpec, SourceFileLoader
from pathlib import Path
from types import CodeType

import pytest
from rich.console import Console
from rich.table import Table

ROOT = Path(__file__).parents[1]
EXPLAINED = Path(__file__).with_suffix(".toml")
MODULES = (
    "mechstyle/loop/control.py", "mechstyle/loop/schedule.py", "mechstyle/loop/correction.py", "mechstyle/loop/minimum_wall.py",
    "mechstyle/fea/permanent_set.py", "mechstyle/geometry/transfer.py", "mechstyle/geometry/resting_face.py",
    "mechstyle/geometry/region_selection.py", "mechstyle/styling/prompt.py",
)  # fmt: skip
PRODUCT = {"mechstyle": "tests", "widgets/mechstyle_widgets": "tests/widgets"}
"""Folders of all modules, and where the folders of their tests begin."""
MOST_SURVIVORS = 0.08
PATIENCE = 10.0
"""A mutant that takes this many times as long as the unchanged module hangs, and counts as killed."""
GUARD = 1e-6
"""A number so small only keeps others from being zero; it is made zero."""

OPERATORS: dict[type[ast.AST], tuple[str, tuple[str, ...]]] = {
    ast.Lt: ("<", ("<=", ">=")), ast.LtE: ("<=", ("<", ">")), ast.Gt: (">", (">=", "<=")), ast.GtE: (">=", (">", "<")),
    ast.Eq: ("==", ("!=",)), ast.NotEq: ("!=", ("==",)), ast.Is: ("is", ("is not",)), ast.IsNot: ("is not", ("is",)),
    ast.In: ("in", ("not in",)), ast.NotIn: ("not in", ("in",)), ast.And: ("and", ("or",)), ast.Or: ("or", ("and",)),
    ast.Add: ("+", ("-",)), ast.Sub: ("-", ("+",)), ast.Mult: ("*", ("/",)), ast.Div: ("/", ("*",)), ast.Pow: ("**", ("*",)),
    ast.FloorDiv: ("//", ("/",)), ast.Mod: ("%", ("*",)), ast.BitAnd: ("&", ("|",)), ast.BitOr: ("|", ("&",)), ast.BitXor: ("^", ("|",)),
}  # fmt: skip
PREFIXES: dict[type[ast.AST], str] = {ast.Not: "not", ast.USub: "-", ast.Invert: "~"}
_PAIRS = (("min", "max"), ("minimum", "maximum"), ("fmin", "fmax"), ("any", "all"), ("argmin", "argmax"), ("zeros", "ones"))
OPPOSITES = {name: other for a, b in _PAIRS for name, other in ((a, b), (b, a))}


@dataclass(frozen=True, order=True)
class Mutant:
    """One change of one module: the bytes from `start` to `end` of its source give way to `text`.

    Attributes:
        module: Path of the module from the root, with slashes.
        start: Where the change begins [bytes].
        end: Where it ends [bytes].
        text: What stands there instead.
    """

    module: str
    start: int
    end: int
    text: str

    def source(self, root: Path) -> str:
        """The changed source."""
        before = (root / self.module).read_bytes()
        return (before[: self.start] + self.text.encode() + before[self.end :]).decode()

    def key(self, root: Path) -> tuple[str, str, str]:
        """Module and the line before and after, in which the change can be recognised wherever the line has moved."""
        before = (root / self.module).read_bytes()
        first, last = before.rfind(b"\n", 0, self.start) + 1, (before.find(b"\n", self.end) + len(before)) % len(before) + 1
        changed = before[first : self.start] + self.text.encode() + before[self.end : last]
        return self.module, *(" ".join(line.decode().split()) for line in (before[first:last], changed))

    def line(self, root: Path) -> int:
        """Number of the line the change begins in, from 1."""
        return (root / self.module).read_bytes().count(b"\n", 0, self.start) + 1


class Source:
    """A module's source and the changes that can be made to it."""

    def __init__(self, module: str, text: bytes) -> None:
        self.module, self.text = module, text
        self._lines = [0, *(place + 1 for place, sign in enumerate(text) if sign == ord("\n"))]

    def mutants(self) -> list[Mutant]:
        """Every mutant, in the order of the source."""
        nodes = list(_nodes(ast.parse(self.text)))
        return sorted({mutant for kind in (self._operators, self._values, self._flow) for node in nodes for mutant in kind(node)})

    def _span(self, node: ast.expr | ast.stmt) -> tuple[int, int]:
        return self._lines[node.lineno - 1] + node.col_offset, self._lines[node.end_lineno - 1] + node.end_col_offset

    def _replaced(self, start: int, end: int, *texts: str) -> Iterator[Mutant]:
        return (Mutant(self.module, start, end, text) for text in texts)

    def _operators(self, node: ast.AST) -> Iterator[Mutant]:
        """Other operators between operands, and none before one."""
        match node:
            case ast.Compare():
                operands, operators = [node.left, *node.comparators], node.ops
            case ast.BinOp():
                operands, operators = [node.left, node.right], [node.op]
            case ast.BoolOp():
                operands, operators = node.values, [node.op] * (len(node.values) - 1)
            case _:
                operands, operators = [], []
        for (left, right), operator in zip(itertools.pairwise(operands), operators, strict=True):
            if type(operator) in OPERATORS:
                token, others = OPERATORS[type(operator)]
                place = self.text.index(token.encode(), self._span(left)[1], self._span(right)[0])
                yield from self._replaced(place, place + len(token), *others)
        if isinstance(node, ast.UnaryOp) and type(node.op) in PREFIXES:
            start, _ = self._span(node)
            yield from self._replaced(start, start + len(PREFIXES[type(node.op)]), "")

    def _values(self, node: ast.AST) -> Iterator[Mutant]:
        """Other numbers, the other boolean, the opposite function."""
        match node:
            case ast.Constant(value=bool(value)):
                yield from self._replaced(*self._span(node), str(not value))
            case ast.Constant(value=int(value)):
                yield from self._replaced(*self._span(node), str(value + 1), f"({value - 1})")
            case ast.Constant(value=float(value)):
                others = (f"{1.25 * value:.6g}", f"{0.8 * value:.6g}") if value else ("1.0", "(-1.0)")
                yield from self._replaced(*self._span(node), *(("0.0",) if 0.0 < value <= GUARD else others))
            case ast.Attribute(attr=name, ctx=ast.Load()) | ast.Name(id=name, ctx=ast.Load()) if name in OPPOSITES:
                if isinstance(node, ast.Attribute) or hasattr(builtins, name):  # a parameter may be called minimum
                    end = self._span(node)[1]
                    yield from self._replaced(end - len(name), end, OPPOSITES[name])

    def _flow(self, node: ast.AST) -> Iterator[Mutant]:
        """Opposite conditions, where no operator of their own has one; statements left out; nothing returned."""
        match node:
            case ast.If(test=test) | ast.IfExp(test=test) if not isinstance(test, ast.Compare | ast.UnaryOp):
                start, end = self._span(test)
                condition = self.text[start:end].decode()
                if condition != "TYPE_CHECKING":
                    yield from self._replaced(start, end, f"(not ({condition}))")
            case ast.Expr(value=ast.Constant()):  # a docstring
                pass
            case ast.Expr() | ast.AugAssign() | ast.Raise() | ast.Assign(targets=[ast.Subscript()]):
                yield from self._replaced(*self._span(node), "pass")
            case ast.Return(value=ast.expr()) if not isinstance(node.value, ast.Constant) or node.value.value is not None:
                yield from self._replaced(*self._span(node), "return None")


def _nodes(node: ast.AST) -> Iterator[ast.AST]:
    """A node and all within it, but for annotations, decorators, texts with fields, and `strict` of zip, which only guards its callers."""
    yield node
    for name, value in ast.iter_fields(node):
        if name not in {"annotation", "returns", "decorator_list"}:
            for child in value if isinstance(value, list) else [value]:
                guard = isinstance(child, ast.keyword) and child.arg == "strict"
                if isinstance(child, ast.AST) and not isinstance(child, ast.JoinedStr) and not guard:
                    yield from _nodes(child)


def mutants(root: Path, module: str) -> list[Mutant]:
    """Every mutant of a module, in the order of its source."""
    return Source(module, (root / module).read_bytes()).mutants()


def sample(root: Path, module: str, count: int, seed: int) -> list[Mutant]:
    """So many of them, always the same for a seed, whatever becomes of the other modules."""
    every = mutants(root, module)
    return sorted(random.Random(f"{seed} {module}").sample(every, min(count, len(every))))


def draw(root: Path, count: int, seed: int) -> list[Mutant]:
    """So many of all mutants of the product: a long module is drawn more often."""
    modules = sorted(path.relative_to(root).as_posix() for folder in PRODUCT for path in (root / folder).rglob("*.py"))
    every = [mutant for module in modules for mutant in mutants(root, module)]
    return sorted(random.Random(seed).sample(every, min(count, len(every))))


def tests_of(root: Path, module: str) -> tuple[str, ...]:
    """The files that test a module: mechstyle/loop/control.py has tests/loop/test_control.py and tests/loop/test_control_*.py.

    A module without such a file has those that import it; one that none imports has all of the nearest folder with tests.
    """
    path = root / module
    folder = next(folder for folder in PRODUCT if module.startswith(f"{folder}/"))
    tests = root / PRODUCT[folder]
    place, name = tests / path.relative_to(root / folder).parent, path.stem.strip("_")
    files = [*place.glob(f"test_{name}.py"), *place.glob(f"test_{name}_*.py")]
    if not files:
        package = ".".join(path.relative_to(root / Path(folder).parent).parent.parts)
        names = re.compile(rf"{package}\.{path.stem}\b|from {package} import [^\n]*\b{path.stem}\b")
        files = [file for file in tests.rglob("test_*.py") if names.search(file.read_text(encoding="utf-8"))]
    while not files:
        files, place = [*place.glob("test_*.py")], place.parent
    return tuple(sorted(file.relative_to(root).as_posix() for file in files))


class _MutantLoader(SourceFileLoader):
    """Loads the changed source in place of the file's."""

    def __init__(self, name: str, path: str, source: str) -> None:
        super().__init__(name, path)
        self._changed = source

    def get_code(self, fullname: str) -> CodeType:
        path = self.get_filename(fullname)
        linecache.cache[path] = (len(self._changed), None, self._changed.splitlines(keepends=True), path)  # what Warp compiles kernels from
        return compile(self._changed, path, "exec", dont_inherit=True)


class _MutantFinder:
    """Finds the changed module first, whoever imports it."""

    def __init__(self, mutant: Mutant, root: Path) -> None:
        self._name = mutant.module.removeprefix("widgets/").removesuffix(".py").removesuffix("/__init__").replace("/", ".")
        self._path, self._source = str(root / mutant.module), mutant.source(root)

    def find_spec(self, name: str, *_: object) -> ModuleSpec | None:
        if name != self._name:
            return None
        return importlib.util.spec_from_file_location(name, self._path, loader=_MutantLoader(name, self._path, self._source))


def passes(root: Path, mutant: Mutant | None, tests: Sequence[str], limit: float) -> bool:
    """Whether all tests pass, in a process of their own, within a time limit [s]."""
    order = json.dumps({"mutant": mutant and asdict(mutant), "tests": tests})
    quiet = {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL, "stdin": subprocess.DEVNULL}
    process = subprocess.Popen([sys.executable, __file__, "--order", order], cwd=root, start_new_session=True, **quiet)
    try:
        return process.wait(limit) == 0
    except subprocess.TimeoutExpired:
        return False
    finally:
        with contextlib.suppress(ProcessLookupError):  # tests may have left processes of their own
            os.killpg(process.pid, signal.SIGKILL)
        process.wait()


def obey(root: Path, order: str) -> int:
    """In the process started by `passes`: put the mutant in place, then run the tests; pytest's exit code."""
    wanted = json.loads(order)
    sys.path[0], sys.dont_write_bytecode = str(root), True
    if wanted["mutant"]:
        sys.meta_path.insert(0, _MutantFinder(Mutant(**wanted["mutant"]), root))
    return pytest.main(["-x", "-q", "-p", "no:cacheprovider", *(str(root / file) for file in wanted["tests"])])


def limits(root: Path, modules: Sequence[str], each: Callable[..., Iterator[float]]) -> dict[str, float]:
    """Time limit of each module's tests [s]; unchanged they must pass. Modules with the same tests share it."""
    tests = {module: tests_of(root, module) for module in modules}

    def measured(files: Sequence[str]) -> float:
        begun = time.perf_counter()
        if not passes(root, None, files, 1200.0):
            sys.exit(f"{', '.join(files)}: fails without any change; mend that first")
        return PATIENCE * (time.perf_counter() - begun)

    different = list(dict.fromkeys(tests.values()))
    limit = dict(zip(different, each(measured, different), strict=True))
    return {module: limit[files] for module, files in tests.items()}


def explanations() -> dict[tuple[str, str, str], str]:
    """Why survivors cannot be seen, by their keys."""
    entries = tomllib.loads(EXPLAINED.read_text(encoding="utf-8"))["survivor"]
    return {(entry["module"], entry["line"], entry["mutant"]): entry["why"] for entry in entries}


def table(root: Path, results: dict[Mutant, bool], known: dict[tuple[str, str, str], str]) -> Table:
    """Mutants, killed, and survivors of each module, with place and change."""
    made = Table(title="mutants", show_lines=True)
    for heading in ("module", "mutants", "killed", "survivors"):
        made.add_column(heading, justify="right" if heading in {"mutants", "killed"} else "left")
    for module in dict.fromkeys(mutant.module for mutant in results):
        mine = [mutant for mutant in results if mutant.module == module]
        alive = [mutant for mutant in mine if results[mutant]]
        lines = []
        for mutant in alive:
            _, before, after = mutant.key(root)
            why = known.get(mutant.key(root), "NOT EXPLAINED")
            lines.append(f"{mutant.line(root)}: {before}\n  → {after}\n  {why}")
        made.add_row(module, str(len(mine)), str(len(mine) - len(alive)), "\n".join(lines))
    return made


def main() -> int:
    """Print the table; 1 if too many survive or one is not explained."""
    parser = argparse.ArgumentParser(description="Seeded mutation run over the pure modules.")
    parser.add_argument("--seed", type=int, default=0, help="another seed, another sample")
    parser.add_argument("--per-module", type=int, default=16, help="mutants of each module")
    parser.add_argument("--drawn", type=int, default=0, help="so many of the whole product, in place of those of the pure modules")
    parser.add_argument("--module", default="", help="only modules with this in their path")
    parser.add_argument("--workers", type=int, default=2, help="processes side by side")
    parser.add_argument("--order", default="", help=argparse.SUPPRESS)
    options = parser.parse_args()
    if options.order:
        return obey(Path.cwd(), options.order)
    pure = [module for module in MODULES if options.module in module]
    chosen = [mutant for module in pure for mutant in sample(ROOT, module, options.per_module, options.seed)]
    if options.drawn:
        chosen = draw(ROOT, options.drawn, options.seed)
    begun, known = time.perf_counter(), explanations()
    with ThreadPoolExecutor(options.workers) as pool:
        limit = limits(ROOT, list(dict.fromkeys(mutant.module for mutant in chosen)), pool.map)
        alive = pool.map(lambda mutant: passes(ROOT, mutant, tests_of(ROOT, mutant.module), limit[mutant.module]), chosen)
        results = dict(zip(chosen, alive, strict=True))
    console = Console(width=160)
    console.print(table(ROOT, results, known), markup=False)
    survivors = [mutant.key(ROOT) for mutant in chosen if results[mutant]]
    share, unexplained = len(survivors) / len(chosen), len([key for key in survivors if key not in known])
    seconds = time.perf_counter() - begun
    print(f"seed {options.seed}: {len(survivors)} of {len(chosen)} survive ({share:.1%}), {unexplained} not explained; {seconds:.0f} s")
    return int(share > MOST_SURVIVORS or unexplained > 0)


if __name__ == "__main__":
    sys.exit(main())
