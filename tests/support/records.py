"""Records with values a careless format would lose."""

import numpy as np

from mechstyle.records import Checkpoint, Judgement, Measures, Recipe, Simulation, Verdict
from mechstyle.records.material import LIBRARY

COUNT = 7


def recipe(**changes):
    return Recipe(**{"surface": "5" * 64, "tetrahedra": "7" * 64, "prompt": "brick", "material": LIBRARY["PLA"], **changes})


def judgement(value):
    return Judgement(rule="peak ≤ yield strength", outcome="VIABLE", value=value, limit=45.6, unit="MPa", marginal=False)


VERDICT = Verdict(
    outcome="VIABLE", criterion="robust", as_placed=judgement(0.1 + 0.2), all_orientations=None, literal=judgement(60.0), words="It holds."
)
# Values a careless format would lose: the sign of zero, subnormals, the last bit, what is not a number.
AWKWARD = np.array([-0.0, 1e-45, np.nextafter(np.float32(1), np.float32(2)), np.pi, -3.4e38, np.inf, np.nan], np.float32)


def checkpoint(iteration=3, **changes):
    flat = {name: np.full(COUNT, 0.5) for name in ("mask", "share", "anchor", "stress", "demand")}
    rest = {"parent": "", "recipe": "", "simulated_at": 0, "style_loss": 0.1 + 0.2}
    colour = np.linspace(0, 1, 3 * COUNT).reshape(COUNT, 3)
    return Checkpoint(**{"iteration": iteration, "displacement": AWKWARD, "colour": colour, **flat, **rest, **changes})


def simulation(**changes):
    measures = Measures(peak=0.1 + 0.2, p999=18.0, p99=12.0, maximum=30.0, where=(0.1, -0.0, 1e-300), volume=1000.0)
    contact = np.arange(COUNT) % 2 == 0
    fields = {
        "displacement": AWKWARD, "stress": np.arange(COUNT) / 3, "envelope": np.arange(COUNT) / 7, "probability": np.arange(COUNT) / 9,
        "contact": contact,
        "as_placed": measures, "overall": None, "backed_off": 0.25, "deviation": 0.1, "time_step": 1e-4, "steps": 2752,
        "added_mass": 0.002, "meshing": "fresh", "failure": "the integration blew up",
    }  # fmt: skip
    return Simulation(**{**fields, **changes})
