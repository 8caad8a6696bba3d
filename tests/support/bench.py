"""A loop without physics: a stylizer that grows a bump and a simulator whose stress is a known function of the relief."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np

from mechstyle.loop.bounds import Bounds
from mechstyle.loop.engine import Engine
from mechstyle.loop.store import Lane, Store
from mechstyle.records import Landing, Recipe, Simulation, Verdict, judge
from mechstyle.records.material import LIBRARY
from mechstyle.records.mesh import SurfaceMesh


def grid(n: int = 8, step: float = 10.0) -> SurfaceMesh:
    """A flat sheet of n × n vertices; the loop needs normals and areas only."""
    x, y = np.meshgrid(np.arange(n) * step, np.arange(n) * step, indexing="ij")
    vertices = np.stack([x.ravel(), y.ravel(), np.zeros(n * n)], axis=1)
    a = np.arange(n * n).reshape(n, n)
    lower = np.stack([a[:-1, :-1], a[1:, :-1], a[1:, 1:]], axis=-1).reshape(-1, 3)
    upper = np.stack([a[:-1, :-1], a[1:, 1:], a[:-1, 1:]], axis=-1).reshape(-1, 3)
    return SurfaceMesh(vertices, np.concatenate([lower, upper]))


class Bump(NamedTuple):
    displacement: np.ndarray
    colour: np.ndarray


class BumpStylizer:
    """Approaches a relief of `height` mm by a tenth of the way each iteration."""

    def __init__(self, count: int, height: float = 1.0) -> None:
        self.target = np.linspace(0.2, 1.0, count, dtype=np.float32) * np.float32(height)
        self.start_from(np.zeros(count, np.float32), np.full((count, 3), 0.5, np.float32))
        self.steps = 0

    def proposal(self) -> Bump:
        return Bump(self._displacement, self._colour)

    def step(self) -> Bump:
        self.steps += 1
        self._displacement = (self._displacement + np.float32(0.1) * (self.target - self._displacement)).astype(np.float32)
        self._colour = (self._colour * np.float32(0.95)).astype(np.float32)
        return self.proposal()

    def loss(self, displacement: np.ndarray, colour: np.ndarray) -> float:
        return float(((displacement - self.target) ** 2).mean() + (colour**2).mean())

    def state(self) -> dict[str, np.ndarray]:
        return {"displacement": self._displacement, "colour": self._colour}

    def restore(self, state: dict[str, np.ndarray]) -> None:
        self.start_from(state["displacement"], state["colour"])

    def start_from(self, displacement: np.ndarray, colour: np.ndarray) -> None:
        self._displacement = np.asarray(displacement, np.float32)
        self._colour = np.asarray(colour, np.float32)


@dataclass
class LeverSimulator:
    """Stress = 20 MPa + `gain` · |displacement|, everywhere, `tilt` times it nearly flat; keeps a count of what it was asked.

    Above the yield strength a place yields; .2 mm · (stress over strength)⁴ stays bent there.
    """

    count: int
    recipe: Recipe
    gain: float = 50.0
    broken_above: float = np.inf
    tilt: float = 0.8
    asked: list[tuple[float, bool]] = field(default_factory=list)

    @property
    def baseline(self) -> Simulation:
        return self._measured(np.zeros(self.count, np.float32))

    def judge(self, simulation: Simulation, *, alone: bool = False) -> Verdict:
        return judge(simulation, None if alone else self.baseline, self.recipe)

    def simulate(self, displacement: np.ndarray, *, thorough: bool) -> Simulation:
        self.asked.append((float(np.abs(displacement).max()), thorough))
        return self._measured(displacement)

    def _measured(self, displacement: np.ndarray) -> Simulation:
        test, contact = self.recipe.test, np.zeros(self.count, bool)
        if float(np.abs(displacement).max()) > self.broken_above:
            return Simulation(displacement=displacement, contact=contact, failure="the integration blew up")
        stress = (20.0 + self.gain * np.abs(displacement)).astype(np.float32)
        ways = (("flat", "flat", 1.0), ("tilted 3°", "nearly flat", self.tilt))[: 2 if test.nearly_flat else 1]
        stresses = np.stack([share * stress for _, _, share in ways])
        over = stresses / test.material.yield_strength
        strain, bend = np.where(over > 1.0, 0.0025 + 0.01 * (over - 1.0), 0.0), 0.2 * over**4
        landings = tuple(
            Landing(
                name=name, way=way, normal=(0.0, 0.0, 1.0) if way == "flat" else (0.0, 0.6, 0.8), fall=test.height,
                permanent_set=float(bend[index].max()), plastic_strain=float(strain[index].max()),
                where=(float(bend[index].argmax()), 0.0, 0.0), place="at the top", maximum=2.0 * float(stresses[index].max()),
            )
            for index, (name, way, _) in enumerate(ways)
        )  # fmt: skip
        return Simulation(
            displacement=displacement, contact=contact, landings=landings, landing_stress=stresses, landing_strain=strain,
            landing_set=bend[..., None] * np.array([0.0, 0.0, -1.0]), time_step=1e-4, steps=100,
        )  # fmt: skip


@dataclass
class Bench:
    """Everything needed to run the loop on the sheet, anew or from where a store stands."""

    root: object
    height: float = 1.0
    gain: float = 50.0
    broken_above: float = np.inf
    tilt: float = 0.8
    freedom: np.ndarray | None = None
    side: int = 8

    @property
    def surface(self) -> SurfaceMesh:
        return grid(self.side, step=80.0 / self.side)

    def recipe(self, **settings: object) -> Recipe:
        defaults = {"surface": "s", "tetrahedra": "t", "prompt": "bump", "material": LIBRARY["PLA"], "iterations": 60}
        return Recipe.of(**{**defaults, **settings})

    def engine(self, recipe: Recipe, lane: str = "main") -> Engine:
        surface = self.surface
        count = len(surface.vertices)
        store = Store(self.root)
        digest = store.put_recipe(recipe)
        if lane not in store.lanes():
            store.move(lane, Lane(recipe=digest))
        thick = np.full(count, 4.0, np.float32)
        freedom = np.ones(count, np.float32) if self.freedom is None else self.freedom
        bounds = Bounds(thickness=thick, inward=np.float32(0.25) * thick, outward=thick, freedom=freedom)
        simulator = LeverSimulator(count, recipe, self.gain, self.broken_above, self.tilt)
        return Engine(recipe, surface, bounds, BumpStylizer(count, self.height), simulator, store, lane)
