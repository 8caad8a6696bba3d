"""What keeps the tree in order, and that each of these gates really looks at something."""

import ast
import importlib
import importlib.metadata
import itertools
import re
import shutil
import subprocess
import sys
import tarfile
import tomllib
from pathlib import Path

import pytest
import typer
from packaging.requirements import Requirement
from packaging.specifiers import SpecifierSet
from packaging.utils import canonicalize_name

import mechstyle
from support import ROOT

PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text())
MADE = {".venv", ".git", "build", "dist", "__pycache__"}


def tracked() -> list[Path]:
    """Files under version control; of a source archive, which knows nothing of git, all that were not made here."""
    if (ROOT / ".git").exists():
        listed = subprocess.run(["git", "ls-files"], cwd=ROOT, capture_output=True, text=True, check=True)
        return [ROOT / line for line in listed.stdout.splitlines()]
    made = re.compile(r".*(_cache|\.egg-info)|\.hypothesis")
    return [
        path
        for path in ROOT.rglob("*")
        if path.is_file() and not any(part in MADE or made.fullmatch(part) for part in path.relative_to(ROOT).parts)
    ]


TRACKED = tracked()
SOURCES = [path for folder in ("mechstyle", "widgets", "benchmarks") for path in sorted((ROOT / folder).rglob("*.py"))]
IMPORTS = re.compile(r"^(?:from|import) (mechstyle[\w.]*)", re.MULTILINE)
HEAVY = {"lxml", "manifold3d", "matplotlib", "networkx", "pytetwild", "rich", "scipy", "trimesh", "typer", "warp"}
HEAVY |= {"IPython", "PIL", "distributed", "ipywidgets", "pandas", "plotly", "pythreejs", "skimage", "torch", "transformers"}


def loaded_by(program: str) -> set[str]:
    """Top-level modules in memory after a program ran in a fresh process."""
    ending = "\nimport sys; print(*{name.partition('.')[0] for name in sys.modules})"
    return set(subprocess.run([sys.executable, "-c", program + ending], capture_output=True, text=True, check=True).stdout.split())


def named(path: Path) -> str:
    return str(path.relative_to(ROOT))


# --- imports ------------------------------------------------------------------------------------------------------


def test_what_benchmarks_import_is_there():
    """`make bench` had stopped at its first line: a name had moved, and nothing else looks at these files."""
    missing, modules = [], {".".join(path.relative_to(ROOT).with_suffix("").parts) for path in (ROOT / "mechstyle").rglob("*.py")}
    for path in sorted((ROOT / "benchmarks").rglob("*.py")):
        for node in ast.walk(ast.parse(path.read_text())):
            if isinstance(node, ast.ImportFrom) and (node.module or "").startswith("mechstyle"):
                module = importlib.import_module(str(node.module))
                absent = [f"{node.module}.{alias.name}" for alias in node.names if not hasattr(module, alias.name)]
                missing += [f"{named(path)}: {name}" for name in absent if name not in modules]
    assert missing == []


LAYERS = [contract for contract in PROJECT["tool"]["importlinter"]["contracts"] if contract["type"] == "layers"]


@pytest.mark.parametrize("contract", LAYERS, ids=lambda contract: contract["containers"][0])
def test_the_layers_are_all_built_and_none_may_import_its_neighbours(contract):
    """An optional layer, in parentheses, or one joined by a colon would pass without being looked at."""
    assert contract["exhaustive"]
    for name in re.split(r" \| ", " | ".join(contract["layers"])):
        assert re.fullmatch(r"\w+", name), f"layer {name!r} is optional or not kept apart"
        assert importlib.util.find_spec(f"{contract['containers'][0]}.{name}") is not None


def test_every_room_has_its_row_on_the_map():
    """A room that nobody can say a line about is one too many; which way rooms import is the contracts' business."""
    rows = set(re.findall(r"`(\w+)`", "".join(re.findall(r"^\| (`.+?) \|", (ROOT / "docs" / "design.md").read_text(), re.MULTILINE))))
    rooms = {path.name for path in (ROOT / "mechstyle").iterdir() if (path / "__init__.py").is_file()}
    assert {"loop", "fea"} <= rooms <= rows


def test_tests_stand_where_what_they_test_stands():
    roots = {"widgets": ROOT / "widgets" / "mechstyle_widgets", "study": ROOT / "benchmarks" / "study"}
    elsewhere = {"browser", "notebooks", "support", "validation"}
    for path in sorted((ROOT / "tests").rglob("test_*.py")):
        first, *rest = path.relative_to(ROOT / "tests").parent.parts or ("",)
        if first not in elsewhere:
            folder = roots.get(first, ROOT / "mechstyle" / first).joinpath(*rest)
            assert folder.is_dir(), f"{named(path)} has no room of that name to test"


TESTED = ("fea", "loop", "simulation", "runs")
CRUMB = 45
"""Lines of a module below which what it holds may be tested where it is used."""


@pytest.mark.parametrize("room", TESTED)
def test_every_module_of_the_rooms_that_judge_has_tests_of_its_own(room):
    """In test_<module>.py, or several files whose names begin so, in the folder of the same name; one of them names the module."""
    missing = []
    for module in sorted((ROOT / "mechstyle" / room).rglob("*.py")):
        if module.stem == "__init__" or len(module.read_text().splitlines()) < CRUMB:
            continue
        place, package = ROOT / "tests" / module.relative_to(ROOT / "mechstyle").parent, ".".join(module.relative_to(ROOT).parent.parts)
        files = [*place.glob(f"test_{module.stem}.py"), *place.glob(f"test_{module.stem}_*.py")]
        names = re.compile(rf"{package}\.{module.stem}\b|from {package} import [^\n]*\b{module.stem}\b")
        if not any(names.search(file.read_text()) for file in files):
            missing.append(named(module))
    assert missing == []


def test_the_documentation_imports_public_names_only():
    imported = [(page, found) for page in sorted((ROOT / "docs").glob("*.md")) for found in IMPORTS.findall(page.read_text())]
    assert len(imported) >= 3
    for page, module in imported:
        assert module in {"mechstyle", "mechstyle_widgets"}, f"{page.name} imports {module}"


def test_the_documentation_names_modules_that_exist():
    named_in = [(page, name) for page in sorted((ROOT / "docs").glob("*.md")) for name in re.findall(r"`([\w/]+\.py)`", page.read_text())]
    assert len(named_in) >= 5
    for page, name in named_in:
        assert (ROOT / "mechstyle" / name).is_file(), f"{page.name} names {name}"


def test_importing_mechstyle_loads_nothing():
    loaded = loaded_by("import mechstyle; dir(mechstyle); mechstyle.__all__")
    assert "mechstyle" in loaded
    assert not loaded & {"numpy", "msgspec", *HEAVY}


def test_no_package_loads_anything_heavy_by_itself():
    """Rooms are imported for one function of them; the others' libraries may be missing."""
    folders = [path.parent for path in sorted((ROOT / "mechstyle").rglob("__init__.py"))]
    packages = [".".join(folder.relative_to(ROOT).parts) for folder in folders]
    assert "mechstyle.fea" in packages
    packages.remove("mechstyle.cli")  # the command line is typer
    assert not loaded_by("import " + ", ".join(packages)) & HEAVY


def test_physics_runs_without_torch():
    assert "torch" not in loaded_by("import mechstyle.simulation.simulator, mechstyle.runs.run")


# --- the public surface -------------------------------------------------------------------------------------------


ROWS = pytest.mark.parametrize("row", [mechstyle, mechstyle.lab], ids=lambda row: row.__name__)


@ROWS
def test_all_is_exactly_what_is_exported(row):
    ours = {name: value for name, value in vars(row).items() if getattr(value, "__module__", "").startswith("mechstyle.")}
    assert {name for name in ours if not name.startswith("_")} <= set(row.__all__)
    assert len(row.__all__) == len(set(row.__all__))
    assert set(dir(row)) == {*row.__all__, *(["__version__"] if row is mechstyle else [])}


def test_the_second_row_repeats_nothing_of_the_first():
    assert not set(mechstyle.__all__) & set(mechstyle.lab.__all__)
    with pytest.raises(AttributeError):
        mechstyle.Engine  # noqa: B018 — one name, one address


@pytest.mark.parametrize("name", sorted({*mechstyle.__all__, *mechstyle.lab.__all__} - {"lab"}))
def test_every_public_name_stays_itself_whatever_else_was_imported(name):
    """Importing a submodule puts it into its package under its own name, in place of a function of that name."""
    row = mechstyle if name in mechstyle.__all__ else mechstyle.lab
    assert importlib.util.find_spec(f"mechstyle.{name}") is None, f"mechstyle.{name} is a module as well"
    stub = ast.parse(Path(row.__file__).with_suffix(".pyi").read_text())  # what type checkers read
    (home,) = [node.module for node in stub.body if isinstance(node, ast.ImportFrom) for alias in node.names if alias.asname == name]
    assert getattr(row, name) is getattr(importlib.import_module(home), name)


def test_a_name_that_is_not_there_is_an_attribute_error():
    for row in (mechstyle, mechstyle.lab):
        with pytest.raises(AttributeError, match="no attribute 'styllize'"):
            row.styllize  # noqa: B018


def test_versions_agree():
    latest = re.search(r"^## \[([\d.]+)\]", (ROOT / "CHANGELOG.md").read_text(), re.MULTILINE)
    assert latest is not None
    assert mechstyle.__version__ == PROJECT["project"]["version"] == latest[1]


def test_the_command_is_where_the_package_says():
    module, function = PROJECT["project"]["scripts"]["mechstyle"].split(":")
    assert callable(getattr(importlib.import_module(module), function))


def test_the_readme_names_commands_options_and_functions_that_exist():
    readme = (ROOT / "README.md").read_text()
    commands = typer.main.get_command(importlib.import_module("mechstyle.cli.app").app).commands
    shown = re.findall(r"^mechstyle (\w+)(.*?)(?:#|$)", readme, re.MULTILINE)
    assert len(shown) >= 3
    for name, arguments in shown:
        command = commands[name]
        while getattr(command, "commands", None):  # of a family, such as `study formative`
            command = command.commands[next(word for word in arguments.split() if word in command.commands)]
        options = {option for parameter in command.params for option in parameter.opts}
        assert set(re.findall(r"--[\w-]+", arguments)) <= options, name
    assert set(re.findall(r"\bms\.(\w+)", readme)) <= set(mechstyle.__all__)
    assert all(hasattr(mechstyle.Run, name) for name in re.findall(r"\brun\.(\w+)", readme))


# --- size and habits ----------------------------------------------------------------------------------------------


def test_there_is_something_to_look_at():
    assert {ROOT / "mechstyle/loop/engine.py", ROOT / "widgets/mechstyle_widgets/__init__.py"} <= set(SOURCES)
    assert {Path(__file__), ROOT / "README.md"} <= set(TRACKED)


def test_the_source_archive_holds_all_that_is_here(tmp_path):
    """Tests read pages, notebooks, benchmarks and one another's support: an archive without them cannot run its own."""
    for path in TRACKED:
        (tmp_path / "source" / path.relative_to(ROOT)).parent.mkdir(parents=True, exist_ok=True)
        shutil.copyfile(path, tmp_path / "source" / path.relative_to(ROOT))
    build = f"from setuptools import build_meta; build_meta.build_sdist({str(tmp_path)!r})"
    subprocess.run([sys.executable, "-c", build], cwd=tmp_path / "source", capture_output=True, check=True)
    (archive,) = tmp_path.glob("*.tar.gz")
    with tarfile.open(archive) as opened:
        names = {name.partition("/")[2] for name in opened.getnames()}
    assert {named(path) for path in TRACKED} - names == set()


def test_functions_stay_readable_and_no_exception_is_swallowed_unnamed():
    for path in SOURCES:
        for node in ast.walk(ast.parse(path.read_text())):
            if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef):
                assert node.end_lineno - node.lineno < 60, f"{named(path)}: {node.name} is too long to read"
            assert not (isinstance(node, ast.ExceptHandler) and node.type is None), f"{named(path)}: bare except in line {node.lineno}"


def test_no_file_names_a_package_registry_or_a_place_on_somebodys_machine():
    """Where packages come from is the installer's business, and a path outside the repository is nobody else's."""
    hosts = r"\b(?:pypi|pythonhosted|npmjs|unpkg|jsdelivr|anaconda|debian)\.(?:org|com|net)\b"
    forbidden = re.compile(hosts + r"|(?<![\w.:/])/(?:home|root|work)/\w")
    for path in TRACKED:
        if path.is_file() and path.suffix not in {".gif", ".png", ".stl", ".npz", ".3mf", ".zip", ".xz", ".parquet"}:
            found = forbidden.search(path.read_text(encoding="utf-8"))
            assert found is None, f"{named(path)}: {found[0]}"


# --- gates look at something --------------------------------------------------------------------------------------


def test_mypy_and_pytest_are_pointed_at_folders_with_code():
    folders = PROJECT["tool"]["mypy"]["files"] + PROJECT["tool"]["pytest"]["ini_options"]["testpaths"]
    assert set(folders) == {"mechstyle", "widgets", "tests"}
    for folder in folders:
        assert any((ROOT / folder).rglob("*.py")), folder


def test_exceptions_from_the_gates_still_excuse_something():
    for pattern in PROJECT["tool"]["ruff"]["lint"]["per-file-ignores"]:
        assert any(path.match(pattern.replace("**", "*")) for path in TRACKED), pattern
    for override in PROJECT["tool"]["mypy"]["overrides"]:
        for module in override["module"] if override.get("ignore_errors") else []:
            assert list(ROOT.glob(module.replace(".", "/") + ".py")), module


PINNED = (ROOT / "constraints.txt").read_text().splitlines()[1:]
PINS = {canonicalize_name(name): version for name, version in (line.split("==") for line in PINNED)}


def test_every_dependency_is_pinned_within_what_the_package_asks_for():
    """What users install has floors and ranges; the one version of each that the tests passed with stands in constraints.txt."""
    assert sorted(PINNED) == PINNED
    for text in [*PROJECT["project"]["dependencies"], *itertools.chain(*PROJECT["project"]["optional-dependencies"].values())]:
        needed = Requirement(text)
        assert needed.specifier.contains(PINS[canonicalize_name(needed.name)]), text
        assert {">="} <= {one.operator for one in needed.specifier} <= {">=", "<"}, text


def test_what_is_pinned_installs_on_the_oldest_python_that_is_promised():
    """Debian 12 has Python 3.11.2, where a package that asks for 3.11.5 ends `make`."""
    oldest = PROJECT["project"]["requires-python"].removeprefix(">=") + ".0"
    asked = {one.name: one.metadata.get("Requires-Python") or "" for one in importlib.metadata.distributions()
             if PINS.get(canonicalize_name(one.name)) == one.version}  # fmt: skip
    assert len(asked) > 100
    assert [name for name, python in asked.items() if not SpecifierSet(python).contains(oldest)] == []


def test_installed_is_what_was_written():
    """An old install in development mode would leave new packages out."""
    assert importlib.metadata.version("mechstyle") == mechstyle.__version__
    assert set(importlib.import_module("mechstyle_widgets").__all__) >= {"RunViewer", "Timeline", "Viewer"}


BANNED = r"\b([Tt]old|borne|as it came|as it comes|no longer|physics \d+)\b"
"""Words that say less than the noun of the field: given, called, found, shown; stress over limit; original."""


def test_no_source_says_a_banned_word():
    for path in (path for path in SOURCES if {"mechstyle", "mechstyle_widgets"} & set(path.parts) and "tests" not in path.parts):
        for number, line in enumerate(path.read_text().splitlines(), 1):
            assert not re.search(BANNED, line), f"{named(path)}:{number}: {line.strip()}"
