"""The options of every command: which there are, what their help says, and what becomes of them."""

from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path

import pytest
from rich.text import Text
from typer.main import get_command
from typer.testing import CliRunner

import mechstyle
from mechstyle.cli import run, simulate
from mechstyle.cli.app import app
from mechstyle.records.recipe import CHAPTER_OF, CHAPTERS, CHOICES, DEFAULTS, OPTIONS, SETTINGS, described
from mechstyle.runs.recipes import recipe_for
from mechstyle.simulation import part_test

STYLED = (
    "--build-direction "
    "--relief --side --feature --nozzle --inside "
    "--image --image-size --image-as --image-layout --project --projection "
    "--amplitude --clip --criterion --device --field --guidance --iterations --json --load --material -m --minimum-wall --orientations "
    "--height --nearly-flat --no-nearly-flat --poses --prompt -p --protect --seed --set --standard --stylizer --tolerance --window"
)
READ = "--body --scale --size --unit --up"
RESTRAINED = "--base --control --every --normalisation --schedule --threshold"
PRINTED = "--bottom --infill --infill-pattern --layer-height --line-width --sliced --top --walls"
NAMES = {
    "": "--version",
    "run": f"model --details --help-all --out --quick --strengthen {READ} --vertices {STYLED} {RESTRAINED} {PRINTED}",
    "freestyle": f"model --details --help-all --out --quick --strengthen {READ} --vertices {STYLED} {PRINTED}",
    "branch": f"address --details --lane {STYLED} {RESTRAINED} {PRINTED}",
    "simulate": f"model --build-direction {READ} {PRINTED} "
    "--criterion --details --device --json --load --material -m --minimum-wall --orientations --original --out --poses --standard "
    "--height --nearly-flat --no-nearly-flat --tolerance --vertices --vtu --window",
    "demo": "--device --height --json --model --out --prompt --tolerance --vertices -p",
    "log": "address --json",
    "show": "address --field --json --out",
    "export": "address --bands --bodies --colours --fields --format -f --json --out --palette --slicer",
    "orient": "address --count --device --json",
    "protect": f"model --json --out --protect {READ} --vertices",
    "rerun": "address --device --json --out",
    "gc": "directory --json --remove",
    "class": "",
    "class collect": "reports --height --json --out",
    "class prepare": "models --device --height --iterations --json --material -m --nearly-flat --no-nearly-flat --out --prompt -p "
    "--schedule --set --tolerance --vertices",
    "film": "addresses --frames --json --no-plain --out --plain --size",
    "report": "address --impact --json --out",
    "materials": "--json",
    "styles": "--json",
    "gallery": "--json",
    "doctor": "--json",
    "studio": "part --browser --language --no-browser --port",
    "weights": "",
    "weights fetch": "name --json",
    "weights list": "--json",
    "weights path": "name --json",
}
"""What each command takes."""


def tree(command, path=()):
    yield " ".join(path), command
    for name, below in getattr(command, "commands", {}).items():
        yield from tree(below, (*path, name))


COMMANDS = dict(tree(get_command(app)))
GENERATED = [
    (command, parameter) for command in COMMANDS if command not in ("demo", "class collect")  # whose prompt or height is of their own
    for parameter in COMMANDS[command].params if parameter.name in OPTIONS
]  # fmt: skip


def named(command, name):
    return next(parameter for parameter in COMMANDS[command].params if parameter.name == name)


def shown(*arguments):
    """What a command prints, in one line however wide the terminal."""
    outcome = CliRunner().invoke(app, list(arguments), env={"COLUMNS": "400", "TERM": "dumb"})
    assert outcome.exit_code == 0, outcome.output
    return " ".join(outcome.output.split())


def test_every_command_takes_what_it_is_said_to_take():
    found = {name: {flag for one in command.params for flag in (*one.opts, *one.secondary_opts)} for name, command in COMMANDS.items()}
    assert found == {name: set(flags.split()) for name, flags in NAMES.items()}


def test_no_prompt_is_needed_where_a_picture_may_stand_for_it_and_the_material_is_pla():
    assert [named(command, "prompt").default for command in ("run", "freestyle", "branch")] == ["", "", None]
    assert [named(command, "material").default for command in ("run", "freestyle", "simulate", "branch")] == ["PLA"] * 3 + [None]


# --- help ---------------------------------------------------------------------------------------------------------


def test_there_is_an_option_for_some_settings_of_every_command_that_runs_something():
    assert set(OPTIONS) < set(SETTINGS)
    commands = {"run", "freestyle", "branch", "simulate", "protect", "class prepare"}
    assert {command for command, _ in GENERATED} == commands


def test_an_option_says_what_the_recipe_says_of_its_field_and_names_its_choices():
    for command, option in GENERATED:
        said = Text.from_markup(option.help).plain
        assert said.startswith(described(option.name)), (command, option.name)
        assert all(choice in said for choice in CHOICES.get(option.name, ())), (command, option.name)


def test_the_panels_of_the_help_are_the_chapters_of_the_recipe():
    panels = {command: {} for command, _ in GENERATED}
    for command, option in GENERATED:
        panels[command].setdefault(option.rich_help_panel, []).append(option.name)
    for found in panels.values():
        assert found == {
            panel: [name for name in OPTIONS if CHAPTER_OF[name].capitalize() == panel and name in names] for panel, names in found.items()
        }
    assert list(panels["run"]) == [chapter.capitalize() for chapter in CHAPTERS]
    assert [name for names in panels["run"].values() for name in names] == list(OPTIONS)


def test_every_field_of_the_recipe_is_described():
    assert [name for name in SETTINGS if not described(name)] == []
    assert described("minimum_wall") == "The thinnest wall the style may leave [mm]; 0 for no rule."
    assert described("control") == "How stress restrains the style, one of linear, exponential, frozen, none."


@pytest.mark.parametrize("command", ["run", "freestyle"])
def test_the_help_of_a_run_fits_two_screens_and_help_all_has_every_option(command):
    """It had 237 lines, which began with what is descended in."""
    brief, whole = (CliRunner().invoke(app, [command, flag], env={"COLUMNS": "80"}).stdout for flag in ("--help", "--help-all"))
    assert len(brief.splitlines()) <= 80
    assert {"--prompt", "--height", "--tolerance", "--protect", "--load", "--quick", "--out", "--help-all"} <= set(brief.split())
    assert "--normalisation" not in brief.replace("normalisation's", "")
    flags = {flag for one in COMMANDS[command].params if one.param_type_name == "option" for flag in one.opts}
    assert flags <= set(re.findall(r"--?[a-z][a-z-]*", whole))


def test_units_stand_in_the_help(mechstyle):
    told = " ".join(mechstyle.here("run", "--help-all").stdout.replace("│", " ").split())
    assert "may leave [mm]; 0" in told
    assert "schedule [iterations]" in told


@pytest.mark.parametrize("command", COMMANDS)
def test_help_shows_all_that_was_written_in_brackets(command, monkeypatch):
    """In docstrings as in options: rich takes [mm] for markup and leaves it out."""
    texts = [COMMANDS[command].help, *(getattr(one, "help", None) or "" for one in COMMANDS[command].params)]
    plain = [text.replace("\\[", "[") for text in texts]
    assert [Text.from_markup(text).plain for text in texts] == plain
    told = shown(*command.split(), "--help-all" if command in ("run", "freestyle") else "--help")
    for text in plain:
        assert all(bracketed in told for bracketed in re.findall(r"\[[^\]]*\]", text))


def test_the_default_of_a_setting_is_the_recipes():
    told = shown("run", "--help-all")
    assert f"[default: ({DEFAULTS['minimum_wall']})]" in told
    assert f"[default: ({DEFAULTS['control']})]" in told
    assert "[default: (1.5 m)]" in told
    assert "[default: (0.2 mm)]" in told
    assert "[default: (--nearly-flat)]" in told
    assert "[default: (" not in shown("branch", "--help"), "there it is what the parent has"


@pytest.mark.parametrize("command", COMMANDS)
def test_help_has_a_short_name(command):
    assert shown(*command.split(), "-h") == shown(*command.split(), "--help")


def test_the_version_is_told():
    assert shown("--version") == f"mechstyle {mechstyle.__version__}"


@pytest.mark.parametrize("arguments", [["--help"], ["run", "--help"], ["--version"]], ids=" ".join)
def test_help_loads_no_physics(arguments):
    program = f"""
import sys
from mechstyle.cli.app import app
try:
    app({arguments})
except SystemExit:
    print("\\nloaded", *sys.modules)
"""
    told = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True).stdout
    loaded = set(told.rpartition("\nloaded ")[2].split())
    assert "mechstyle.cli.run" in loaded
    assert not loaded & {"warp", "scipy", "trimesh", "matplotlib", "torch", "manifold3d"}


# --- what becomes of them -----------------------------------------------------------------------------------------


@pytest.fixture
def asked(monkeypatch):
    """The settings that reach a run when `run` or `freestyle` is given these arguments."""

    def ask(*arguments):
        caught = []
        monkeypatch.setattr(run, "carry_out", lambda _model, settings, *_rest, **_more: caught.append(settings))
        monkeypatch.setattr(run, "report", lambda *_, **__: None)
        outcome = CliRunner().invoke(app, list(arguments))
        assert outcome.exit_code == 0, outcome.output
        return caught[0]

    return ask


def test_only_what_was_given_reaches_the_recipe(asked):
    plain = {"prompt": "brick", "material": "PLA"}
    assert asked("run", "gallery:vase", "-p", "brick") == plain
    given = asked("run", "gallery:vase", "-p", "brick", "--base", "free", "--amplitude", "0", "--protect", "inside",
                  "--protect", "above 9", "--load", "a.toml", "-m", "PETG")  # fmt: skip
    assert given == plain | {
        "material": "PETG", "base": "free", "amplitude": 0.0, "protect": ["inside", "above 9"], "loads": Path("a.toml"),
    }  # fmt: skip


@pytest.mark.parametrize("command", ["run", "freestyle"])
def test_a_fall_is_given_with_its_unit_and_nearly_flat_as_a_flag(asked, command):
    given = asked(command, "gallery:vase", "-p", "brick", "--height", "4 cm", "--no-nearly-flat")
    recipe = recipe_for(**given)
    assert (recipe.test.height, recipe.test.nearly_flat) == (40.0, False)
    assert recipe_for(**asked(command, "gallery:vase", "-p", "brick", "--set", "height=1,2 m")).test.height == 1200.0


@pytest.mark.parametrize("command", ["run", "freestyle", "simulate", "demo", "branch"])
def test_a_height_without_unit_that_would_be_a_few_millimetres_is_asked_about_before_anything_else(command):
    model = {"demo": ["--model", "gallery:none"], "branch": ["nowhere"]}.get(command, ["gallery:none"])
    outcome = CliRunner().invoke(app, [command, *model, "--height", "1.5"])
    assert outcome.exit_code == 2
    assert 'a height of 1.5 would be 1.5 mm: write "1.5 m", "1.5 cm" or "1.5 mm"' in " ".join(outcome.output.split())


@pytest.mark.parametrize("command", ["run", "freestyle", "simulate", "demo", "branch"])
def test_a_tolerance_has_a_unit_and_a_bad_one_is_refused_before_anything_else(asked, command):
    assert recipe_for(**asked("run", "gallery:vase", "-p", "brick", "--tolerance", "150 µm")).test.tolerance == pytest.approx(0.15)
    model = {"demo": ["--model", "gallery:none"], "branch": ["nowhere"]}.get(command, ["gallery:none"])
    outcome = CliRunner().invoke(app, [command, *model, "--tolerance", "0.2 m"])
    assert outcome.exit_code == 2
    assert 'a tolerance is in mm or µm, not in \'m\': write "0.2 mm" or "200 µm"' in " ".join(outcome.output.split())


def test_what_is_set_by_name_comes_last(asked):
    later = ("--set", "seed=4", "--set", "travel=0.2", "--set", "prompt=moss")
    given = asked("freestyle", "gallery:vase", "-p", "brick", "--seed", "3", *later)
    assert given == {"prompt": "moss", "material": "PLA", "seed": 4, "travel": 0.2}


def test_a_drop_without_style_has_the_defaults_of_the_python_function(monkeypatch):
    caught = []

    def catch(_mesh, **given):
        caught.append(given)
        raise mechstyle.BadInput("caught")

    monkeypatch.setattr(part_test, "simulate", catch)
    monkeypatch.setattr(simulate, "read_model", lambda *_, **__: (None, "vase"))
    CliRunner().invoke(app, ["simulate", "gallery:vase", "--criterion", "paper"])
    assert {"material", "criterion"} == set(caught[0]) - {"original", "vertices", "device", "stage", "progress", "measured"}


def test_a_setting_that_does_nothing_is_said_to_before_anything_slow():
    outcome = CliRunner().invoke(app, ["run", "gallery:none", "-p", "brick", "--every", "5"])
    assert "every does nothing without the schedule every" in outcome.output
