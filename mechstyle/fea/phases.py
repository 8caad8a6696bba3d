"""A drop from its first touch until its impact has ended: phases of contact, which are simulated, and rigid flights between them.

A phase is over when the floor has not pushed for three quarters of the body's lowest period, or sooner where what it vibrates will not
bend it; then the body flies on as a rigid one. Where it will touch again at half the speed of its fall or more, or may do so after slower
touches, another phase begins, a new drop of the body as it is bent by then: what it still vibrates is left out, because its phase at the
next touch is a lottery, which a degree of tilt draws anew.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from mechstyle.fea.discretisation import Discretisation
from mechstyle.fea.elasticity import displacement_gradients, energy_density
from mechstyle.fea.explicit import FLOW, QUANTITIES, Batch, Body, Job, Scheme, Starts, carry, failing, total_energy
from mechstyle.fea.flight import RigidBody, Touch
from mechstyle.records.mesh import Bools, Floats

QUIET_TIME = 0.75
"""Time without contact after which a phase is over, over the lowest period. The tip of a bar comes back after 0.21 of it, but a tilted cup
in brick bears most 0.7 after it has left the floor; up to 1.5 it may bear 4 % more."""

CALM_TIME, CALM_STRESS, CALM_ENERGY = 0.25, 0.9, 0.01
"""When a body that may yield is done sooner. For so much of its lowest period it has not touched the floor or flowed, and either its stress
stayed below so much of the yield strength for twice as long, or what it vibrates is less than so much of the plastic work; and no touch is
near. A knob, a tealight holder, a phone stand and a wall hook in five landings each, flat to 30°, keep within 0.001 mm what they keep with
QUIET_TIME alone; waited for two periods, within 3 %. It saves a third of a flat landing and next to nothing where much is bent."""

MIN_IMPULSE = 1e-4
"""Impulse of the floor that counts as contact, over the momentum at first touch."""

MIN_SPEED_RATIO = 0.5
"""Speed of a next touch below which it is not followed unless a harder one may come after it, over the speed at first touch. A bar with a
foot, tilted by 22°, grazes the floor with the foot at 0.4 of it and then slaps it with its end, which bears 1.3 to 1.8 times as much."""

MIN_FLIGHT = 0.25
"""Time of flight below which simulating goes on instead, over the lowest period."""

MOST_PHASES = 4
MOST_PERIODS, MOST_BESIDES = 6.0, 1.5
"""Most time that is simulated: so many lowest periods, and so many milliseconds besides."""

CHECK_EVERY = 5
"""Samples between two looks at the rule."""

IMPULSE, CONTACT_LOSS, HEIGHT, KINETIC, STRAIN_ENERGY, PLASTIC_WORK, PEAK_SQUARED = (
    QUANTITIES.index(name) for name in ("impulse", "contact_loss", "height", "kinetic", "strain", "plastic_work", "peak_squared")
)


def longest(period: float) -> float:
    """Most time that is simulated of a body with a lowest period [ms]."""
    return MOST_PERIODS * period + MOST_BESIDES


@dataclass
class Film:
    """Moments [ms since first touch] of a drop, at most so many: if there are more, every second is merged into the one after it."""

    most: int
    times: list[float] = field(default_factory=list)
    moved: list[NDArray[np.float32]] = field(default_factory=list)
    peaks: list[NDArray[np.float32]] = field(default_factory=list)
    _in_each: int = 1
    _taken: int = 0

    def take(self, time: float, displacement: Floats, peak: NDArray[np.float32]) -> None:
        """One more."""
        if len(self.times) == self.most and self._taken % self._in_each == 0:
            last = len(self.times) - 1
            kept = [min(index + 1, last) for index in range(0, last + 1, 2)]  # half of them are left
            self.times, self.moved = [self.times[later] for later in kept], [self.moved[later] for later in kept]
            self.peaks = [np.maximum(self.peaks[later - later % 2], self.peaks[later]) for later in kept]
            self._in_each *= 2
        moved = displacement.astype(np.float32)
        if self._taken % self._in_each:
            self.times[-1], self.moved[-1], self.peaks[-1] = time, moved, np.maximum(self.peaks[-1], peak)
        else:
            self.times.append(time)
            self.moved.append(moved)
            self.peaks.append(peak)
        self._taken += 1


@dataclass(frozen=True)
class Rule:
    """When a drop ends.

    Attributes:
        speed: Speed at first touch [mm/ms].
        period: Lowest elastic period of the body [ms]; unused if there is a window.
        window: Time after first touch [ms], None for as long as the impact lasts.
        quiet: Time without contact after which a phase is over, over the lowest period.
    """

    speed: float
    period: float
    window: float | None
    quiet: float = QUIET_TIME


class Rest:
    """The shape in which a body comes to rest after it has flowed, and the energy of the stress that is locked in.

    Args:
        body: The body.
        scheme: The step, with its law.
        springback: Displacement of nodes [mm], [states, node_count, 3], that plastic flow A leaves, [states, tet_count, points, 6].

    Attributes:
        springback: The same.
    """

    def __init__(self, body: Discretisation, scheme: Scheme, springback: Callable[[NDArray[np.float32]], Floats]) -> None:
        self._body, self._scheme, self.springback = body, scheme, springback

    def __call__(self, plastic: NDArray[np.float32]) -> tuple[Floats, float]:
        """Displacement of the nodes [mm], shape [node_count, 3], and strain energy [mJ], of what has flowed, as `Track.plastic`."""
        body, flow = self._body, plastic[..., :FLOW]
        if not flow.any():
            return np.zeros((len(body.masses), 3)), 0.0
        displacement = self.springback(flow[None])[0]
        H = displacement_gradients(body.mesh, displacement[body.place])[body.tet_order]
        shares = np.broadcast_to(self._scheme.shares, len(body.volumes))[:, None]
        density = energy_density(self._scheme.law, H, flow.astype(np.float64), shares)
        stiffness = 1.0 if body.relative is None else body.relative.stiffness
        return displacement, float(body.volumes @ (stiffness * density).mean(axis=1))


class Track:
    """One orientation on its way through its phases.

    Args:
        normal: Floor normal in the frame of the body, shape [3].
        body: The body.
        scheme: The step.
        rule: Of the attribute.
        rest: The shape in which it flies on.

    Attributes:
        rule: When it ends.
        rest: The shape in which it flies on.
        begun: When each phase began [ms since first touch].
        speeds: Speed of the touching point at the start of each phase [mm/ms].
        normals: Floor normals of the phases in the frame of the body.
        samples: Samples of each phase, the one at its start first, shape [samples, QUANTITIES].
        sunk: How far the centre of mass has sunk when each phase begins, along the first normal, times the mass [g mm].
        peak: Largest stress so far at the Gauss points [MPa], shape [tet_count, points].
        plastic: What has flowed so far, as `Batch.plastic`, shape [tet_count, points, STATE or 0].
        touched: Whether each node has met the floor, shape [node_count].
        ended: Why it ended, in words; "" while it goes on.
        failed: Whether it broke down.
    """

    def __init__(self, normal: Floats, body: RigidBody, scheme: Scheme, rule: Rule, rest: Rest) -> None:
        self._body, self._scheme, self.rule, self.rest = body, scheme, rule, rest
        self.begun, self.speeds, self.normals, self.sunk = [0.0], [rule.speed], [normal], [0.0]
        self.samples: list[Floats] = []
        self.peak: NDArray[np.float32] | None = None
        self.plastic: NDArray[np.float32] | None = None
        self.touched: Bools | None = None
        self.ended, self.failed = "", False
        self._rotation, self._place = np.eye(3), np.zeros(3)  # of the undeformed body as this phase began
        self._next: Touch | None = None
        self._pushed, self._quiet_since = 0.0, 0.0
        self._bent, self._locked = np.zeros_like(body.arms), 0.0
        self._begin(np.broadcast_to(-rule.speed * normal, body.arms.shape))

    @property
    def interval(self) -> float:
        """Time between samples [ms]."""
        return self._scheme.stride * self._scheme.time_step

    @property
    def taken(self) -> int:
        """Samples taken of all phases."""
        return sum(len(rows) - 1 for rows in self.samples)

    @property
    def left(self) -> int:
        """Samples that may still be taken."""
        return self._scheme.samples - self.taken

    @property
    def time(self) -> float:
        """Time since first touch [ms]."""
        return self.begun[-1] + self.interval * (len(self.samples[-1]) - 1)

    @property
    def fraction(self) -> float:
        """About how much is done; of a drop that ends by the rule nobody knows."""
        if self.ended:
            return 1.0
        if self.rule.window is not None:
            return self.taken / self._scheme.samples
        periods = self.taken * self.interval / self.rule.period
        return periods / (1.0 + periods)

    def starts(self) -> Starts:
        """The phase that begins, from the body as it is bent."""
        normal, arms, bent = self.normals[-1], self._body.arms, self._bent
        heights = arms @ normal - ((arms + bent) @ normal).min()
        plastic = None if self.plastic is None else self.plastic[None]
        return Starts(normal[None], heights[None], bent[None], self._velocities[None], plastic)

    def look(self, rows: Floats) -> bool:
        """Take samples in, [samples, QUANTITIES]; whether the phase, and perhaps the drop, is over with them."""
        here = self.samples[-1] = np.concatenate([self.samples[-1], rows])
        bad = np.flatnonzero(failing(here[:, :, None], self._scheme))
        if len(bad):
            self.samples[-1], broken = here[: bad[0] + 1], here[bad[0]]
            self.ended, self.failed = "its state is not finite", True
            if np.isfinite(broken).all():
                before, after = total_energy(np.stack([here[0], broken]), self._scheme)
                rise = float(after / before)
                self.ended = f"its energy rose to {rise:.3g} of what it was at the touch"
            return True
        if here[-1, IMPULSE] - self._pushed >= MIN_IMPULSE * self._body.mass * self.rule.speed:
            self._pushed, self._quiet_since = float(here[-1, IMPULSE]), self.time
        self.ended = self._over()
        return bool(self.ended) or self._next is not None

    def fly(self) -> None:
        """On to the next touch, where a phase begins."""
        touch, body, normal = self._next, self._body, self.normals[-1]
        if touch is None:
            raise RuntimeError("there is no next touch to fly to")
        self.begun.append(float(self.time + touch.after))
        self._place = self._place + self._rotation @ touch.motion.shift
        self._rotation = self._rotation @ touch.motion.rotation
        self.normals.append(touch.motion.rotation.T @ normal)
        self.speeds.append(touch.speed)
        self.sunk.append(float(body.mass * self._place @ self.normals[0]))
        if self.plastic is not None:
            self._bent, self._locked = self.rest(self.plastic)
        self._begin(replace(body, arms=body.arms + self._bent).velocities(touch.motion))

    def keep(self, peak: NDArray[np.float32], plastic: NDArray[np.float32], touched: Bools) -> None:
        """Take in the largest stress of a phase, what has flowed and the nodes that met the floor, in the shapes of the attributes."""
        self.peak = peak.copy() if self.peak is None else np.maximum(self.peak, peak)
        self.touched = touched.copy() if self.touched is None else self.touched | touched
        self.plastic = plastic.copy()

    def displacement(self, since: NDArray[np.float32]) -> Floats:
        """How far each node has moved since first touch, from its displacement since the phase began [mm], shape [node_count, 3]."""
        return np.asarray(self._place + (self._body.arms + since) @ self._rotation.T - self._body.arms)

    def _begin(self, velocities: Floats) -> None:
        masses, normal = self._body.masses[:, None], self.normals[-1]
        sample = np.zeros(len(QUANTITIES))
        sample[KINETIC], sample[STRAIN_ENERGY] = 0.5 * float((masses * velocities**2).sum()), self._locked
        sample[HEIGHT] = float((masses * self._bent).sum(axis=0) @ normal)
        sample[PLASTIC_WORK] = self.samples[-1][-1, PLASTIC_WORK] if self.samples else 0.0
        sample[QUANTITIES.index("momentum")] = float((masses * velocities).sum(axis=0) @ normal)
        self.samples.append(sample[None])
        self._velocities, self._pushed, self._quiet_since, self._next = velocities, 0.0, self.begun[-1], None

    def _over(self) -> str:
        """Why the drop is over, "" if it is not; `_next` if a phase is over but the drop is not."""
        rule, simulated = self.rule, self.taken * self.interval
        if rule.window is not None:
            return f"the window of {rule.window:g} ms was over" if self.left <= 0 else ""
        if self.left <= 0:
            return f"{simulated:.3g} ms were simulated, the most for a part whose lowest period is {rule.period:.2g} ms"
        quiet = self.time - self._quiet_since
        waiting = rule.quiet * rule.period - quiet
        return self._out_of_contact(waiting) if waiting <= 0.0 or self._calm(quiet) else ""

    def _calm(self, quiet: float) -> bool:
        """Whether what it vibrates bends it no further, after so long without contact [ms]."""
        here, strength, period = self.samples[-1], self._scheme.yield_strength, self.rule.period
        quarter = math.ceil(CALM_TIME * period / self.interval)
        if not self._scheme.yields or quiet < CALM_TIME * period or len(here) <= 2 * quarter:
            return False
        work = here[-1, PLASTIC_WORK]
        if work > (1.0 + 0.1 * CALM_ENERGY) * here[-1 - quarter, PLASTIC_WORK]:
            return False
        moving = here[-1, KINETIC] - self._body.kinetic_energy(self._body.motion(here[-1]))
        stress = math.sqrt(here[-1 - 2 * quarter :, PEAK_SQUARED].max())
        return stress < CALM_STRESS * strength or here[-1, STRAIN_ENERGY] + moving < CALM_ENERGY * work

    def _out_of_contact(self, waiting: float) -> str:
        """As `_over` of a body that the floor has not pushed for long; a touch while it would still be waited for [ms] is simulated."""
        rule = self.rule
        motion, normal, least = self._body.motion(self.samples[-1][-1]), self.normals[-1], MIN_SPEED_RATIO * rule.speed
        touch = self._body.next_touch(motion, normal)
        if touch is None:
            return "it leaves the floor, no next touch"
        if touch.after < waiting:
            return ""
        if touch.speed < least and not self._body.harder_behind(touch, normal, least):
            return f"the next touch, at {touch.speed:.1f} m/s, is slower than {MIN_SPEED_RATIO:g} of the first"
        if touch.after < MIN_FLIGHT * rule.period:
            return ""
        if len(self.begun) == MOST_PHASES:
            return f"a further touch, at {touch.speed:.1f} m/s, comes after {MOST_PHASES} phases, the most that are simulated"
        self._next = touch
        return ""


def follow(body: Body, scheme: Scheme, tracks: Sequence[Track], progress: Callable[[float], None], camera: Film | None = None) -> None:
    """Carry drops through all their phases: all first ones, then all second ones, and so on; a camera looks at the first drop.

    Args:
        body: Where they are computed.
        scheme: The step.
        tracks: The drops at first touch; they say afterwards what happened.
        progress: Called in this thread with the fraction done; what it raises cancels the rest.
        camera: Looks on, if there is one drop.
    """

    def tell() -> None:
        progress(sum(track.fraction for track in tracks) / len(tracks))

    going = list(tracks)
    while going:
        starts = Starts.together([track.starts() for track in going])
        carry(_jobs(body, scheme, starts, going, camera), tell)
        if any(track.failed for track in going):
            return
        going = [track for track in going if not track.ended]
        for track in going:
            track.fly()


def _jobs(body: Body, scheme: Scheme, starts: Starts, tracks: Sequence[Track], camera: Film | None) -> list[Job]:
    """Jobs for as many tracks as starts."""
    jobs: list[Job] = []
    first = 0
    for batch in body.batches(scheme, starts):
        jobs.append(_Phase(body, scheme, batch, tracks[first : first + batch.count], camera))
        first += batch.count
    return jobs


class _Phase:
    """A phase of some drops side by side, a `Job`; a drop is closed when its rule fires, and the others go on."""

    def __init__(self, body: Body, scheme: Scheme, batch: Batch, tracks: Sequence[Track], camera: Film | None) -> None:
        self._body, self._scheme, self._batch, self._tracks, self._camera = body, scheme, batch, tracks, camera
        self._open, self._done, self._ahead = list(range(len(tracks))), 0, 0
        self._before = [track.samples[-1][-1].copy() for track in tracks]

    def advance(self) -> None:
        """Some samples on."""
        self._ahead = min(CHECK_EVERY, max(self._tracks[lane].left for lane in self._open))
        self._batch.advance(self._ahead)

    def look(self) -> Sequence[Job]:
        """Close the drops whose phase is over."""
        first, self._done = self._done, self._done + self._ahead
        rows = self._batch.history(first, self._done)
        closed = []
        for lane in self._open:
            track = self._tracks[lane]
            since = rows[: track.left, :, lane]
            since[:, [IMPULSE, CONTACT_LOSS]] += self._before[lane][[IMPULSE, CONTACT_LOSS]]
            if track.look(since):
                closed.append(lane)
        if self._camera is not None:
            self._picture(self._camera)
        if not closed:
            return [self]
        self._keep(closed)
        self._open = [lane for lane in self._open if lane not in closed]
        if not self._open:
            return []
        return [self] if self._batch.pays(len(self._open)) else self._packed()

    def _keep(self, lanes: Sequence[int]) -> None:
        peak, plastic, touched = self._batch.peak(), self._batch.plastic(), self._batch.touched()
        for lane in lanes:
            self._tracks[lane].keep(peak[lane], plastic[lane], touched[lane])

    def _packed(self) -> Sequence[Job]:
        """The open drops on their own: lanes that are closed cost as much as open ones."""
        self._keep(self._open)
        tracks = [self._tracks[lane] for lane in self._open]
        starts, (u, v) = Starts.together([track.starts() for track in tracks]), self._batch.motion()
        starts = Starts(starts.normals, starts.heights, u[self._open], v[self._open], self._batch.plastic()[self._open])
        return _jobs(self._body, self._scheme, starts, tracks, self._camera)

    def _picture(self, camera: Film) -> None:
        """What the first drop looks like; the maximum of its stress begins anew."""
        track, peak = self._tracks[0], self._batch.peak()[0]
        camera.take(track.time, track.displacement(self._batch.motion()[0][0]), peak)
        track.keep(peak, self._batch.plastic()[0], self._batch.touched()[0])
        self._batch.forget_peak()
