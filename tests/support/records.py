"""Records with values a careless format would lose."""

import numpy as np

from mechstyle.records import Checkpoint, Landing, LoadResult, Recipe, Row, Simulation, Verdict
from mechstyle.records.material import LIBRARY
from mechstyle.records.verdict import MEASURE

COUNT = 7
STRENGTH, FALL, TOLERANCE = 45.6, 1500.0, 0.2
"""Yield strength [MPa], height of the fall [mm] and tolerance [mm] of `recipe`."""


def recipe(**changes):
    return Recipe.of(**{"surface": "5" * 64, "tetrahedra": "7" * 64, "prompt": "brick", "material": LIBRARY["PLA"], **changes})


def row(permanent_set=0.06, **changes):
    """A flat landing after which so much stays bent [mm], beside a plain part of which nothing does."""
    allowed = changes.get("allowed", TOLERANCE)
    fields = {"test": "flat", "landing": "flat", "allowed": allowed, "plain_permanent_set": 0.0, "elongation": 0.05}
    figures = {"outcome": "HOLDS" if permanent_set <= allowed else "FAILS", "permanent_set": permanent_set, "place": "at the top"}
    return Row(**{**fields, **figures, **changes})


def load_row(permanent_set=0.02, **changes):
    """A load after which so much stays bent [mm]."""
    return row(permanent_set, **{"test": "load", "landing": "", "load": "coat", "carries": 1.5, **changes})


def published_row(stress=60.0, **changes):
    """The literal maximum [MPa]."""
    fields = {"test": "published rule", "landing": "flat", "stress": stress, "limit": STRENGTH, "decides": True}
    return Row(**{"outcome": "HOLDS" if stress <= STRENGTH else "FAILS", **fields, **changes})


def verdict(*rows, **changes):
    """A verdict of these rows, by default one that holds."""
    rows = rows or (row(), row(0.1, test="nearly flat", landing="tilted left"))
    worst = max((one.outcome for one in rows if one.decides), key=("HOLDS", "NO WORSE", "UNKNOWN", "FAILS").index)
    fields = {"criterion": "robust", "fall": FALL, "tolerance": TOLERANCE, "strength": STRENGTH, "material": "PLA", "style": "brick"}
    return Verdict(**{"outcome": worst, "rows": rows, "measure": MEASURE, **fields, **changes})


VERDICT = verdict()
UNKNOWN = Verdict(
    outcome="UNKNOWN", criterion="robust", fall=FALL, tolerance=TOLERANCE, strength=STRENGTH, material="PLA",
    failure="the integration blew up", measure=MEASURE,
)  # fmt: skip
# Values a careless format would lose: the sign of zero, subnormals, the last bit, what is not a number.
AWKWARD = np.array([-0.0, 1e-45, np.nextafter(np.float32(1), np.float32(2)), np.pi, -3.4e38, np.inf, np.nan], np.float32)


def checkpoint(iteration=3, **changes):
    flat = {name: np.full(COUNT, 0.5) for name in ("mask", "share", "anchor", "stress", "demand")}
    rest = {"parent": "", "recipe": "", "simulated_at": 0, "style_loss": 0.1 + 0.2}
    colour = np.linspace(0, 1, 3 * COUNT).reshape(COUNT, 3)
    return Checkpoint(**{"iteration": iteration, "displacement": AWKWARD, "colour": colour, **flat, **rest, **changes})


def landing(name="flat", **changes):
    fields = {
        "way": "flat", "normal": (0.0, 0.0, 1.0), "fall": FALL, "permanent_set": 0.1 + 0.2, "plastic_strain": 0.01,
        "where": (0.1, -0.0, 1e-300), "place": "at the top", "maximum": 30.0,
    }  # fmt: skip
    return Landing(**{"name": name, **fields, **changes})


def load_result(name="coat", **changes):
    fields = {"permanent_set": 0.02, "plastic_strain": 0.0, "where": (0.0, 0.0, 0.0), "maximum": 40.0, "deflection": 0.1, "factor": 1.5}
    return LoadResult(**{"name": name, **fields, **changes})


def simulation(**changes):
    """A test with a flat landing, two that are nearly flat, and a load; the fields differ everywhere."""
    nearly = [landing(name, way="nearly flat", normal=(0.1, 0.0, 0.99)) for name in ("tilted left", "tilted right")]
    fields = {
        "displacement": AWKWARD, "contact": np.arange(COUNT) % 2 == 0, "landings": (landing(), *nearly), "loads": (load_result(),),
        "landing_stress": np.arange(3 * COUNT).reshape(3, COUNT) / 3, "load_stress": np.arange(COUNT)[None] / 7,
        "landing_strain": np.arange(3 * COUNT).reshape(3, COUNT) / 1e4, "landing_set": np.arange(9 * COUNT).reshape(3, COUNT, 3) / 1e3,
        "backed_off": 0.25, "deviation": 0.1, "time_step": 1e-4, "steps": 2752, "added_mass": 0.002, "meshing": "fresh",
        "failure": "the integration blew up",
    }  # fmt: skip
    return Simulation(**{**fields, **changes})
