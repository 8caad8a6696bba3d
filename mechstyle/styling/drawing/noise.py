"""Solid noise: smooth random fields in space and random numbers per identity, both decided by a seed alone."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from mechstyle.records.mesh import Floats

# The twelve edge directions of a cube and four repeats, so that four bits of a hash choose one (Perlin 2002).
_GRADIENTS = np.array(
    [
        [1, 1, 0],
        [-1, 1, 0],
        [1, -1, 0],
        [-1, -1, 0],
        [1, 0, 1],
        [-1, 0, 1],
        [1, 0, -1],
        [-1, 0, -1],
        [0, 1, 1],
        [0, -1, 1],
        [0, 1, -1],
        [0, -1, -1],
        [1, 1, 0],
        [-1, 1, 0],
        [0, -1, 1],
        [0, -1, -1],
    ],
    dtype=np.float64,
)
_PERLIN_DEVIATION = 0.27  # standard deviation of `perlin` over space
_TYPICAL_PEAK = 3.0  # `fbm` is scaled so that this many standard deviations are 1


def mixed(values: NDArray[np.uint64]) -> NDArray[np.uint64]:
    """The 64-bit finaliser of SplitMix64 (Steele, Lea and Flood 2014): every input bit sways every output bit."""
    z = values + np.uint64(0x9E3779B97F4A7C15)
    z = (z ^ (z >> np.uint64(30))) * np.uint64(0xBF58476D1CE4E5B9)
    z = (z ^ (z >> np.uint64(27))) * np.uint64(0x94D049BB133111EB)
    return z ^ (z >> np.uint64(31))


def random_of(identities: NDArray[np.integer], seed: int) -> Floats:
    """Uniform random numbers in [0, 1), one per identity, equal for equal identities, any shape."""
    key = mixed(np.array([seed * 1_000_003], dtype=np.uint64))
    bits = mixed(identities.astype(np.uint64) ^ key)
    return (bits >> np.uint64(11)).astype(np.float64) / 2.0**53


def perlin(points: Floats, seed: int) -> Floats:
    """Gradient noise of unit wavelength (Perlin 2002), in about [-1, 1], shape [n] for points [n, 3]."""
    floor = np.floor(points)
    inside = points - floor
    fade = inside**3 * (inside * (inside * 6.0 - 15.0) + 10.0)
    # By axis and side, each in one piece of memory: a finer drawing asks for millions of points.
    cells, away, weight = (
        np.ascontiguousarray(np.stack(sides).transpose(2, 0, 1))
        for sides in ((floor, floor + 1.0), (inside, inside - 1.0), (1.0 - fade, fade))
    )
    bits = cells.astype(np.int64).astype(np.uint64)
    total, start = np.zeros(len(points)), mixed(np.array([seed], dtype=np.uint64))
    for x in range(2):
        by_x = mixed(start ^ bits[0, x])
        for y in range(2):
            by_y, weight_xy = mixed(by_x ^ bits[1, y]), weight[0, x] * weight[1, y]
            for z in range(2):
                gradient = (mixed(by_y ^ bits[2, z]) & np.uint64(15)).astype(np.intp)
                slope = sum(_GRADIENTS[:, axis][gradient] * away[axis, side] for axis, side in enumerate((x, y, z)))
                total += weight_xy * weight[2, z] * slope
    return total


def fbm(points: Floats, wavelength: float, octaves: int, seed: int, *, finest: float = 0.0) -> Floats:
    """Fractal sum of noise, each octave twice as fine and half as strong (Musgrave 1998), three deviations scaled to 1, at points [n, 3].

    The coarsest octave has the wavelength [mm]; those finer than `finest` [mm] are left out, because the mesh would alias them.
    """
    total, power, strength = np.zeros(len(points)), 0.0, 1.0
    for octave in range(octaves):
        if octave and wavelength < finest:
            break
        shift = 37.0 * octave + 0.5  # octaves must not share the lattice, where the noise is zero
        total += strength * perlin(points / wavelength + shift, seed + octave)
        power += strength**2
        wavelength, strength = wavelength / 2.03, strength * 0.5
    return np.asarray(total / (_TYPICAL_PEAK * _PERLIN_DEVIATION * power**0.5))
