"""Results of a test: figures of each landing and of each load case, and the stress of each over the surface."""

from __future__ import annotations

import math
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


class Landing(msgspec.Struct, frozen=True, kw_only=True):
    """One drop; NaN stands for figures that an older measure did not know.

    Attributes:
        name: Name of the landing.
        way: Its kind, one of `Way`.
        normal: Floor normal in the frame of the part, out of the floor.
        fall: Height of the fall [mm].
        permanent_set: What stays bent [mm]: the displacement that a small volume exceeds in the end; see `fea.permanent_set`.
        plastic_strain: Plastic strain in tension that such a volume exceeds, beside the material's elongation at break.
        where: Centre of the largest piece that stays bent by that much [mm].
        place: The same in words, such as "at the top on the right"; "" where nothing stays bent.
        maximum: Largest stress at a point of an element [MPa], which the published rule alone reads.
        touches: Speed of the touching point at the start of each phase that was simulated [mm/ms = m/s].
        ended: Why it was followed no further, in words.
    """

    name: str
    way: Way
    normal: Place
    fall: float
    permanent_set: float = math.nan
    plastic_strain: float = math.nan
    where: Place
    place: str = ""
    maximum: float
    touches: tuple[float, ...] = ()
    ended: str = ""


class LoadResult(msgspec.Struct, frozen=True, kw_only=True):
    """One load case: put on, held and taken off; NaN as in `Landing`.

    Attributes:
        name: Name of the case.
        permanent_set, plastic_strain, where, place: As those of a landing.
        maximum: Largest stress at a point of an element [MPa].
        deflection: Largest displacement under the load [mm].
        factor: Times the load up to which no more than the tolerance stays bent.
        reached: Whether the part gave way there; if not, it was loaded no further.
        collapses: Whether it comes to no rest under the load: it buckles, or a hinge forms.
    """

    name: str
    permanent_set: float = math.nan
    plastic_strain: float = math.nan
    where: Place
    place: str = ""
    maximum: float
    deflection: float
    factor: float = math.nan
    reached: bool = True
    collapses: bool = False


LEVELS = ((0.15, "at the foot"), (0.4, "low"), (0.6, "halfway up"), (0.85, "high up"), (1.0, "at the top"))
"""How high a place is, by its share of the height."""
ASIDE = 0.35
"""Share of the half width from which a place is on a side."""


def place_in_words(where: Place, low: Place, high: Place) -> str:
    """A place of a part in words: how high, and on which side, the front at -y; all in mm, the part from `low` to `high`."""
    size = [max(top - bottom, 1e-9) for bottom, top in zip(low, high, strict=True)]
    x, y, z = ((at - bottom) / length for at, bottom, length in zip(where, low, size, strict=True))
    level = next((words for share, words in LEVELS if z <= share), LEVELS[-1][1])
    sides = [names[value > 0.5] for value, names in ((y, ("front", "back")), (x, ("left", "right"))) if abs(2.0 * value - 1.0) > ASIDE]
    return f"{level} {'on' if len(sides) == 1 and sides[0] in ('left', 'right') else 'at'} the {' '.join(sides)}" if sides else level


THICKER = 0.1
"""Share of what a relief leaves of a wall by which tetrahedra may be thicker to judge it without a doubt: what a section bears before it
bends for good goes with the square of its thickness."""

LEAST_GROUNDED = 0.9
"""Least share of what a styled surface has on the floor that tetrahedra must have there, too."""

LIKE_ASKED = 1.1
"""Times larger up to which a pattern counts as asked: meshes of one vertex count differ a little in the length of their edges."""

VOLUME_ERROR = 0.03
"""Relative difference of volume from the surface's above which tetrahedra are not used, or leave a doubt."""


def _none() -> NDArray[np.float32]:
    """The field of no test."""
    return np.zeros((0, 0), np.float32)


@dataclass(frozen=True, eq=False)
class Simulation:
    """One test brought to the surface.

    Attributes:
        displacement: What was simulated [mm], shape [vertex_count]: the request, less what the tetrahedra could not follow.
        landings: What each drop did, flat first; none if the test failed.
        landing_stress: Largest von Mises stress over time at the surface, a mean over 2 mm [MPa], shape [landing_count, vertex_count].
        landing_strain: Plastic strain there in the end, shape [landing_count, vertex_count].
        landing_set: What stays bent [mm], shape [landing_count, vertex_count, 3]: displacement of the surface, motion as a whole taken out.
        loads: What each load case did.
        load_stress, load_strain, load_set: The same of each load case.
        contact: Whether the surface there touched the floor in the flat landing, shape [vertex_count].
        backed_off: Share of the surface whose displacement the morph had to reduce.
        deviation: Largest such reduction [mm].
        time_step: Step of the explicit integration [ms].
        steps: Steps per drop.
        added_mass: Mass added by scaling slivers, over the mass of the part.
        level_share: Share of the flat faces it stands on that the relief leaves on the floor, None for a part that stands on none.
        carried: Share of the relief that the boundary of the tetrahedra follows, 1 without any.
        thicker: Share of what the relief leaves of a wall by which the tetrahedra are thicker; see `simulation.meshes`.
        grounded: Share of what the surface has on the floor that the tetrahedra have there, too.
        volume_error: Volume of the tetrahedra over that inside the surface, less 1; with or without relief, whichever is further off.
        enlarged: Times larger than asked the pattern of its relief is, as the surface carries none so fine; 1 without any.
        volume: Volume of the tetrahedra [mm³].
        plastic_share: Share of it that is plastic, 1 for a solid part.
        mesh: Digest of the tetrahedra as they were made.
        meshing: How the tetrahedra followed the surface: `morphed`, or what else was tried and how it went.
        failure: Why there is no usable answer, "" if there is.
    """

    displacement: NDArray[np.float32]
    contact: NDArray[np.bool_]
    landings: tuple[Landing, ...] = ()
    landing_stress: NDArray[np.float32] = field(default_factory=_none)
    landing_strain: NDArray[np.float32] = field(default_factory=_none)
    landing_set: NDArray[np.float32] = field(default_factory=_none)
    loads: tuple[LoadResult, ...] = ()
    load_stress: NDArray[np.float32] = field(default_factory=_none)
    load_strain: NDArray[np.float32] = field(default_factory=_none)
    load_set: NDArray[np.float32] = field(default_factory=_none)
    backed_off: float = 0.0
    deviation: float = 0.0
    time_step: float = 0.0
    steps: int = 0
    added_mass: float = 0.0
    level_share: float | None = None
    carried: float = 1.0
    thicker: float = 0.0
    grounded: float = 1.0
    volume_error: float = 0.0
    enlarged: float = 1.0
    volume: float = 0.0
    plastic_share: float = 1.0
    mesh: str = ""
    meshing: str = "morphed"
    failure: str = ""

    def __post_init__(self) -> None:
        count = len(self.displacement)
        for name, kind in (("displacement", np.float32), ("contact", np.bool_)):
            object.__setattr__(self, name, frozen_array(getattr(self, name), kind, (count,), name))
        for test, results in (("landing", self.landings), ("load", self.loads)):
            for what, more in (("stress", ()), ("strain", ()), ("set", (3,))):
                name, shape = f"{test}_{what}", (len(results), count, *more)
                given = np.asarray(getattr(self, name), np.float32)
                values = np.zeros(shape, np.float32) if given.size == 0 else given.reshape(shape)
                object.__setattr__(self, name, frozen_array(values, np.float32, shape, name))

    @property
    def flat(self) -> Landing | None:
        """The landing as placed, None if the test failed."""
        return self.landings[0] if self.landings else None

    def landed(self, way: str) -> list[Landing]:
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
        return self._field("stress", landing, load)

    def strain_of(self, *, landing: str = "", load: str = "") -> NDArray[np.float32]:
        """Plastic strain at the surface after one landing or load, shape [vertex_count]; zero where there was no such test."""
        return self._field("strain", landing, load)

    def set_of(self, *, landing: str = "", load: str = "") -> NDArray[np.float32]:
        """What stays bent of the surface after one landing or load [mm], shape [vertex_count, 3]; zero where there was no such test."""
        return self._field("set", landing, load)

    def _field(self, what: str, landing: str, load: str) -> NDArray[np.float32]:
        results, name = (self.loads, load) if load else (self.landings, landing)
        fields: NDArray[np.float32] = getattr(self, f"{'load' if load else 'landing'}_{what}")
        names = [one.name for one in results]
        return fields[names.index(name)] if name in names else np.zeros(fields.shape[1:], np.float32)

    @property
    def stress(self) -> NDArray[np.float32]:
        """The largest stress of the flat landing and the loads [MPa], shape [vertex_count]: the part as it stands."""
        fields = [*self.landing_stress[:1], *self.load_stress]
        return np.maximum.reduce(fields) if fields else np.zeros(len(self.displacement), np.float32)

    @property
    def maximum(self) -> float:
        """Largest stress at a point of an element in the flat landing and under the loads [MPa]: what the published rule looks at."""
        return max([*(one.maximum for one in self.landings[:1]), *(one.maximum for one in self.loads)], default=0.0)
