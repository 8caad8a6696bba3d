"""Results of a test: figures of each landing and of each load case, and the stress of each over the surface."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Literal, get_args

import msgspec
import numpy as np
from numpy.typing import NDArray

from mechstyle.records.mesh import frozen_array

Place = tuple[float, float, float]
Way = Literal["flat", "nearly flat", "any landing"]
"""How a part lands: as placed, tilted by a few degrees, or in some other direction."""
WAYS: tuple[Way, ...] = get_args(Way)

LEAST_HEIGHT, GREATEST_HEIGHT = 1.0, 1e5
"""Heights of fall that are simulated [mm]; a critical height beyond is given as the nearer of the two."""


class Landing(msgspec.Struct, frozen=True, kw_only=True):
    """One drop.

    Attributes:
        name: Name of the landing.
        way: Its kind, one of `Way`.
        normal: Floor normal in the frame of the part, out of the floor.
        stress: σ_V, the stress that more than V0 of the part exceed [MPa]; see `fea.stressed_volume`.
        maximum: Largest stress at a point of an element [MPa], which the published rule alone reads.
        where: Centre of what exceeds σ_V [mm].
        fall: Height of the fall [mm].
        critical_height: Critical drop height: from there σ_V is the yield strength [mm].
        exponent: p of σ_V ∝ height^p between the fall and the critical height; 1/2 for a flat impact, which is homogeneous in its speed.
        retried: Drops from other heights that the critical height rests on; 0 where it follows from this one.
        touches: Speed of the touching point at the start of each phase that was simulated [mm/ms = m/s].
        ended: Why it was followed no further, in words.
    """

    name: str
    way: Way
    normal: Place
    stress: float
    maximum: float
    where: Place
    fall: float
    critical_height: float
    exponent: float = 0.5
    retried: int = 0
    touches: tuple[float, ...] = ()
    ended: str = ""


class LoadResult(msgspec.Struct, frozen=True, kw_only=True):
    """Result of one load case.

    Attributes:
        name: Name of the case.
        stress: σ_V, the stress that more than V0 of the part exceed [MPa].
        maximum: Largest stress at a point of an element [MPa].
        where: Centre of what exceeds σ_V [mm].
        deflection: Largest displacement [mm].
    """

    name: str
    stress: float
    maximum: float
    where: Place
    deflection: float


LEAST_CARRIED = 0.9
"""Least share of the relief, as far as a nozzle could print it, that tetrahedra must follow to judge it without a doubt."""

VOLUME_ERROR = 0.03
"""Relative difference of volume from the surface's above which tetrahedra are not used, or leave a doubt."""


@dataclass(frozen=True, eq=False)
class Simulation:
    """One test brought to the surface.

    Attributes:
        displacement: What was simulated [mm], shape [vertex_count]: the request, less what the tetrahedra could not follow.
        landings: What each drop did, flat first; none if the test failed.
        landing_stress: Largest von Mises stress over time at the surface, a mean over 2 mm [MPa], shape [landing_count, vertex_count].
        loads: What each load case did.
        load_stress: Stress at the surface under each [MPa], shape [case_count, vertex_count].
        contact: Whether the surface there touched the floor in the flat landing, shape [vertex_count].
        backed_off: Share of the surface whose displacement the morph had to reduce.
        deviation: Largest such reduction [mm].
        time_step: Step of the explicit integration [ms].
        steps: Steps per drop.
        added_mass: Mass added by scaling slivers, over the mass of the part.
        level_share: Share of the flat faces it stands on that the relief leaves on the floor, None for a part that stands on none.
        carried: Share of the relief that the boundary of the tetrahedra follows, 1 without any.
        carried_base: The same on the flat faces it stands on, or of what is on the floor, if less; None where there is no relief on any.
        volume_error: Volume of the tetrahedra over that inside the surface, less 1; with or without relief, whichever is further off.
        volume: Volume of the tetrahedra [mm³].
        mesh: Digest of the tetrahedra as they were made.
        meshing: How the tetrahedra followed the surface: `morphed`, or what else was tried and how it went.
        failure: Why there is no usable answer, "" if there is.
    """

    displacement: NDArray[np.float32]
    contact: NDArray[np.bool_]
    landings: tuple[Landing, ...] = ()
    landing_stress: NDArray[np.float32] = field(default_factory=lambda: np.zeros((0, 0), np.float32))
    loads: tuple[LoadResult, ...] = ()
    load_stress: NDArray[np.float32] = field(default_factory=lambda: np.zeros((0, 0), np.float32))
    backed_off: float = 0.0
    deviation: float = 0.0
    time_step: float = 0.0
    steps: int = 0
    added_mass: float = 0.0
    level_share: float | None = None
    carried: float = 1.0
    carried_base: float | None = None
    volume_error: float = 0.0
    volume: float = 0.0
    mesh: str = ""
    meshing: str = "morphed"
    failure: str = ""

    def __post_init__(self) -> None:
        count = len(self.displacement)
        for name, kind in (("displacement", np.float32), ("contact", np.bool_)):
            object.__setattr__(self, name, frozen_array(getattr(self, name), kind, (count,), name))
        for name, results in (("landing_stress", self.landings), ("load_stress", self.loads)):
            values = np.asarray(getattr(self, name), np.float32).reshape(len(results), count)
            object.__setattr__(self, name, frozen_array(values, np.float32, (len(results), count), name))

    @property
    def flat(self) -> Landing | None:
        """The landing as placed, None if the test failed."""
        return self.landings[0] if self.landings else None

    def of(self, way: str) -> list[Landing]:
        """The landings of one kind."""
        return [landing for landing in self.landings if landing.way == way]

    def landing(self, name: str) -> Landing | None:
        """A landing by its name, None if there was none."""
        return next((landing for landing in self.landings if landing.name == name), None)

    def load(self, name: str) -> LoadResult | None:
        """A load case by its name, None if there was none."""
        return next((case for case in self.loads if case.name == name), None)

    def stress_of(self, *, landing: str = "", load: str = "") -> NDArray[np.float32]:
        """Stress at the surface in one landing or under one load [MPa], shape [vertex_count]; zero where there was no such test."""
        fields, results, name = (self.load_stress, self.loads, load) if load else (self.landing_stress, self.landings, landing)
        names = [one.name for one in results]
        return fields[names.index(name)] if name in names else np.zeros(len(self.displacement), np.float32)

    @property
    def stress(self) -> NDArray[np.float32]:
        """The largest stress of the flat landing and the loads [MPa], shape [vertex_count]: the part as it stands."""
        fields = [*self.landing_stress[:1], *self.load_stress]
        return np.maximum.reduce(fields) if fields else np.zeros(len(self.displacement), np.float32)

    @property
    def maximum(self) -> float:
        """Largest stress at a point of an element in the flat landing and under the loads [MPa]: what the published rule looks at."""
        return max([*(one.maximum for one in self.landings[:1]), *(one.maximum for one in self.loads)], default=0.0)

    @property
    def least_carried(self) -> float:
        """The smaller share of the relief that the tetrahedra follow, of all of it and of that on the faces it stands on."""
        return float(np.min([self.carried, 1.0 if self.carried_base is None else self.carried_base]))  # NaN if one of them is
