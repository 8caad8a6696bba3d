"""The command in a report makes the same recipe again, whatever was set."""

import shlex

import msgspec
import pytest
from typer.main import get_command

import mechstyle
from mechstyle.cli import run
from mechstyle.records.load_cases import Load, LoadCase, Support
from mechstyle.records.material import LIBRARY, Material
from mechstyle.records.regions import Box
from mechstyle.runs.recipes import recipe_for
from mechstyle.runs.report.reproduce import OF_FREESTYLE, OPTIONS, cell_for, command_for
from mechstyle.simulation.part import Origin

PARSER = get_command(run.app)
OWN = Material(name="my own", youngs_modulus=1000.0, poisson_ratio=0.3, density=1e-3, yield_strength=20.0)
HELD = LoadCase(name="heavy coat", supports=(Support(at="resting face"),), loads=(Load(gravity=1.0),))
CASES = [
    {},
    {"prompt": "brick; rm -rf ~ 'quoted' \"and\" $HOME"},
    {"material": LIBRARY["PETG"], "iterations": 30, "amplitude": 0.2},
    {"material": OWN},
    {"material": msgspec.structs.replace(LIBRARY["PLA"], yield_strength=40.0)},
    {"control": "frozen"},
    {"control": "linear", "normalisation": "own_max", "threshold": 0.5},
    {"criterion": "paper"},
    {"criterion": "paper", "nearly_flat": True, "control": "frozen"},
    {"protect": (Box(low=(0.0, 0.0, 0.0), high=(1.0, 2.0, 3.0)),), "minimum_wall": 1.2},
    {"standard": "ista-1a"},
    {"build_direction": (0.0, 1.0, 0.5)},
    {"standard": "astm-f963", "poses": "resting", "height": 500.0},
    {"relief": 0.6, "feature": 5.0, "side": "outwards"},
    {"amplitude": 0.15, "side": "both", "nozzle": 0.0, "inside": "styled"},
    {"nearly_flat": False},
    {"height": "4 cm"},
    {"height": 1234.5678901},
    {"base": "free", "height": 800.0, "window": 2.5, "guarantee": False},
]


def typed(steps, monkeypatch):
    """What the command line makes of a command: the settings of its draft, and the rest of what it was given."""
    caught = []

    def catch(*given, freestyle, as_json, **_):
        caught.append((given, freestyle))
        raise SystemExit(0)

    monkeypatch.setattr(run, "carry_out", catch)
    with pytest.raises(SystemExit):
        PARSER(shlex.split(steps)[1:])
    given, freestyle = caught[0]
    return recipe_for(**given[1], freestyle=freestyle), given


@pytest.mark.parametrize("freestyle", [False, True], ids=["mechstyle", "freestyle"])
@pytest.mark.parametrize("settings", CASES, ids=lambda settings: ",".join(settings) or "defaults")
def test_the_command_makes_the_same_recipe(lane, monkeypatch, settings, freestyle):
    wanted = recipe_for(**{"prompt": "brick", **settings}, freestyle=freestyle)
    made, _ = typed(command_for(FakeLane(lane, wanted), []), monkeypatch)
    assert made.digest == wanted.digest


class FakeLane:
    """A lane of another recipe."""

    def __init__(self, lane, recipe):
        self.store, self.lane, self.record, self.recipe = lane.store, "main", lane.record, recipe


class Notebook:
    """Stands for `mechstyle` in a cell: notes what a run is asked for, and branches."""

    def __init__(self):
        self.asked, self.branches = None, []

    def __getattr__(self, name):
        return getattr(mechstyle, name)

    def load(self, *address, **scale):
        return (address, scale)

    def stylize(self, part, prompt, material="PLA", vertices=None, **settings):
        self.asked = (part, recipe_for(prompt, material, **settings), vertices)
        return self

    def branch(self, at, **changes):
        self.branches.append((at, changes))
        return self

    def go(self):
        return self


def typed_in(cell):
    ms = Notebook()
    exec(cell.removeprefix("import mechstyle as ms\n"), {"ms": ms})
    return ms


@pytest.mark.parametrize("settings", [*CASES, {"loads": [HELD]}], ids=lambda settings: ",".join(settings) or "defaults")
def test_the_cell_makes_the_same_recipe(lane, settings):
    wanted = recipe_for(**{"prompt": "brick", **settings})
    part, made, _ = typed_in(cell_for(FakeLane(lane, wanted), [])).asked
    assert made.differences(wanted) == ()
    assert part == (("gallery:pen_holder",), {})


def test_the_cell_of_a_branch_branches(sheet):
    run = sheet(iterations=20, origin=Origin(model="my cup.stl", vertices=4000, scale=25.4))
    branch = run.branch(10, lane="other", control="frozen", material="PETG")
    ms = typed_in(cell_for(branch, branch.history))
    assert (ms.asked[0], ms.asked[2]) == ((("my cup.stl",), {"scale": 25.4}), 4000)
    assert ms.branches == [(10, {"material": "PETG", "control": "frozen"})]


def test_the_command_of_a_plain_run_is_short(lane):
    plain = FakeLane(lane, recipe_for("brick"))
    assert command_for(plain, []) == "mechstyle run gallery:pen_holder --prompt brick --out again-sheet"


def test_freestyle_is_called_by_its_name(lane):
    command = command_for(FakeLane(lane, recipe_for("brick", freestyle=True)), [])
    assert command == "mechstyle freestyle gallery:pen_holder --prompt brick --out again-sheet"


def test_a_style_that_needs_weights_is_named_without_having_them(lane):
    wanted = recipe_for("brick").with_settings(prompt="a mossy ruin", guidance="clip", field="network", clip="b32@0123", crops=2)
    command = command_for(FakeLane(lane, wanted), [])
    assert "--prompt 'a mossy ruin' --guidance clip --field network --clip b32@0123 --set crops=2" in command


@pytest.mark.parametrize(
    "reading", [{"scale": 25.4}, {"unit": "cm", "up": "-y", "body": "a lid"}, {"size": 120.0, "body": "2"}], ids=["scale", "unit", "size"]
)
def test_how_a_file_was_read_is_given_so_that_it_is_read_the_same(sheet, monkeypatch, reading):
    run = sheet(iterations=2, origin=Origin(model="my cup.stl", vertices=4000, **reading))
    _, given = typed(command_for(run, run.history), monkeypatch)
    assert (given[0], given[2], given[3]) == ("my cup.stl", 4000, reading)
    assert typed_in(cell_for(run, run.history)).asked[0] == (("my cup.stl",), reading)


def test_every_option_it_writes_exists():
    never = {"loads", "protect", "build_direction"}  # whose values are written with --set
    for verb, settings in (("run", set(OPTIONS)), ("branch", set(OPTIONS) - {"strengthen"}), ("freestyle", OF_FREESTYLE)):
        known = {option for parameter in PARSER.commands[verb].params for option in parameter.opts}
        assert {f"--{setting.replace('_', '-')}" for setting in settings - never} | {"--set"} <= known


def test_a_branch_is_made_again_by_a_second_step(sheet):
    run = sheet(iterations=20)
    branch = run.branch(10, lane="other", control="frozen", material="PETG")
    command = command_for(branch, branch.history)
    first, second = command.split(" && ")
    assert first.startswith("mechstyle run ")
    assert second.startswith("mechstyle branch again-sheet@main:10 --lane other ")
    assert set(shlex.split(second)[5:]) == {"--control", "frozen", "--material", "PETG"}


def test_a_branch_from_a_relief_in_millimetres_to_a_share_is_made_again(sheet):
    run = sheet(iterations=20, relief=0.6)
    branch = run.branch(10, lane="other", amplitude=0.3)
    second = command_for(branch, branch.history).split(" && ")[1]
    assert shlex.split(second)[5:] == ["--amplitude", "0.3"]
