"""A camera that orbits a part, fits it into view and gives the length of a millimetre on screen."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pythreejs
from numpy.typing import ArrayLike

from mechstyle.pictures.camera import OPENING, Camera
from mechstyle.records.mesh import SurfaceMesh
from mechstyle_widgets.viewer.scene import floor_corners

STEEPEST = 85.0
"""Elevation up to which keys and flights go [degrees]: straight from above there is no upright."""
LOWEST = 8.0
"""Elevation from which a whole part is looked at at least, unless somebody goes lower [degrees]: from below the floor hides what falls."""
STEP = 0.2
"""How far a key moves what is looked at, as a share of half the height of the view."""
CLOSE = 0.7
"""Distance a flight ends at, as a share of that from which the whole part is seen."""
PARALLEL = 1.0
"""Opening angle of a parallel view [degrees]: from so far away that across a part nothing is drawn smaller by more than 2 %."""
NEAREST, FARTHEST = {False: 100.0, True: 30.0}, 20.0
"""Where what is seen begins and ends, as a divisor and a factor of the distance from which the whole part is seen; by `parallel`."""
FLAT = 0.2
"""A normal that points sideways less than this share of upwards does not tell from which side to look."""


class Orbit:
    """A camera about the origin of a scene that a mouse turns, moves and brings nearer.

    Attributes:
        three: The camera of pythreejs; several views may share it and then move together.
        controls: The mouse controls of the views that share it.
        home: Where the part lies in view when fitted: its `target` [mm] is the origin of the scene.
    """

    def __init__(self, mesh: SurfaceMesh, aspect: float) -> None:
        """Look at a part through a window of `aspect` = width over height."""
        self._floor = floor_corners(mesh)
        self.follow(mesh)
        self.home = Camera.named("three_quarter", self._points, aspect=aspect)
        place = np.subtract(self.home.eye, self.home.target).tolist()
        self.three = pythreejs.PerspectiveCamera(position=place, up=[0.0, 0.0, 1.0], aspect=aspect, **self._lens())
        self.controls: list[Any] = []
        self.share()

    def share(self) -> Any:
        """The mouse control of one more view of the camera."""
        self.controls.append(pythreejs.OrbitControls(controlling=self.three))
        return self.controls[-1]

    def follow(self, mesh: SurfaceMesh, above: float = 0.0) -> None:
        """Take it that the part looks so now, and goes so far up [mm]: that is what is fitted into view."""
        self._points = np.concatenate([mesh.vertices, mesh.vertices + np.array([0.0, 0.0, above]), self._floor])

    def fit(self, view: str = "") -> None:
        """Bring the whole part into view, from one of `VIEWS` or from where one looks now."""
        now, aspect = self.seen, self.three.aspect
        if view:
            seen = Camera.named(view, self._points, aspect=aspect, field_of_view=now.field_of_view)
        else:
            seen = Camera.fitted(self._points, now.azimuth, now.elevation, aspect=aspect, field_of_view=now.field_of_view)
        self._take(seen)

    @property
    def parallel(self) -> bool:
        """Whether lines that are parallel on the part are so in the view."""
        return self.home.field_of_view == PARALLEL

    def project(self, *, parallel: bool) -> None:
        """Look in parallel, or in perspective, with what is in the middle as large as it is."""
        if parallel == self.parallel:
            return
        now, opening = self.seen, PARALLEL if parallel else OPENING
        away = math.tan(math.radians(now.field_of_view / 2)) / math.tan(math.radians(opening / 2))
        self.home = replace(self.home, field_of_view=opening, distance=away * self.home.distance)
        with self.three.hold_sync():
            self._take(replace(now, field_of_view=opening, distance=away * now.distance))
            for name, value in self._lens().items():
                setattr(self.three, name, value)

    def turn(self, azimuth: float, elevation: float) -> None:
        """Go round what is in the middle of the view [degrees]."""
        now = self.seen
        self._take(replace(now, azimuth=now.azimuth + azimuth, elevation=_upright(now.elevation + elevation)))

    def move(self, across: int, up: int) -> None:
        """Move what is looked at by so many steps across the view and up it."""
        now = self.seen
        right, above, _ = now.axes
        step = STEP * now.distance * math.tan(math.radians(now.field_of_view / 2))
        x, y, z = (np.asarray(now.target) - step * (across * right + up * above)).tolist()
        self._take(replace(now, target=(x, y, z)))

    def near(self, factor: float) -> None:
        """Come nearer by a factor, or go farther by one below 1."""
        self._take(replace(self.seen, distance=self.seen.distance / factor))

    def look_at(self, place: ArrayLike, outwards: ArrayLike) -> None:
        """Look at a place [mm] from where its outward normal points, near enough to see what is around it."""
        x, y, z = np.asarray(place, np.float64).tolist()
        away = np.asarray(outwards, np.float64)
        elevation = _upright(math.degrees(math.atan2(away[2], math.hypot(away[0], away[1]))))
        level = math.hypot(away[0], away[1]) > FLAT * abs(away[2])
        azimuth = math.degrees(math.atan2(away[0], -away[1])) if level else self.seen.azimuth
        self._take(replace(self.seen, azimuth=azimuth, elevation=elevation, target=(x, y, z), distance=CLOSE * self.home.distance))

    def look_from(self, direction: ArrayLike) -> None:
        """Bring the whole part into view from a direction, or from as near to it as is above the floor."""
        x, y, z = np.asarray(direction, np.float64).tolist()
        azimuth, elevation = math.degrees(math.atan2(x, -y)), _upright(max(math.degrees(math.atan2(z, math.hypot(x, y))), LOWEST))
        self._take(Camera.fitted(self._points, azimuth, elevation, aspect=self.three.aspect, field_of_view=self.seen.field_of_view))

    def look_like(self, other: Orbit) -> None:
        """Stand where another camera stands."""
        self.project(parallel=other.parallel)
        self._take(other.seen)

    def _take(self, seen: Camera) -> None:
        target = np.subtract(seen.target, self.home.target).tolist()
        self.three.position = np.subtract(seen.eye, self.home.target).tolist()
        for control in self.controls:
            control.target = target
            control.exec_three_obj_method("update")

    def resize(self, aspect: float) -> None:
        """Look through a window of another shape."""
        self.three.aspect = aspect
        self.fit()

    @property
    def seen(self) -> Camera:
        """The camera as it stands now, in the part's own coordinates."""
        target = np.asarray(self.controls[0].target, dtype=np.float64)
        away = np.asarray(self.three.position, dtype=np.float64) - target
        distance = float(np.linalg.norm(away))
        elevation = math.degrees(math.asin(np.clip(away[2] / distance, -1.0, 1.0)))
        azimuth = math.degrees(math.atan2(away[0], -away[1]))
        at = target + self.home.target
        return Camera(azimuth, elevation, tuple(at.tolist()), distance, self.home.field_of_view, self.three.aspect)

    def pixels_per_mm(self, height: int) -> float:
        """Pixels a millimetre takes at the point one orbits about, in a view of `height` pixels."""
        seen = self.seen
        return height / (2.0 * seen.distance * math.tan(math.radians(seen.field_of_view / 2)))

    def _lens(self) -> dict[str, float]:
        """Opening, and where what is seen begins and ends."""
        distance = self.home.distance
        return {"fov": self.home.field_of_view, "near": distance / NEAREST[self.parallel], "far": distance * FARTHEST}


def _upright(elevation: float) -> float:
    """An elevation from which up stays up [degrees]."""
    return min(max(elevation, -STEEPEST), STEEPEST)
