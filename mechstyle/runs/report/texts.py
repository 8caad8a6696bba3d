"""Fixed texts of a report: limits of the method, and where it comes from."""

from __future__ import annotations

from mechstyle.fea.stressed_volume import DROPPED, LOADED

LIMITS = (
    "The verdict compares falls and loads in a simulation. It is no certificate: do not rely on it where somebody can get hurt.",
    "The part is solid, isotropic and elastic up to yield: no layers without a build direction, no infill, fatigue, creep or fracture.",
    f"In a fall a cube of {DROPPED:.0f} mm that is bent for good counts, under a load one of {LOADED:.0f} mm; smaller dents do not.",
    "Where the plain part itself begins to yield, as most plastic parts do on an edge, the styled part is compared with it.",
    "A fall or a load closer to its limit than a mesh made anew moves it is not sure.",
    "The largest stress of an element, which the published rule looks at, depends on the mesh where the floor meets the part at a point.",
    "A drop hardly notices walls that are merely too thin to print or to handle. Look at the wall thickness too.",
    "Between simulations the stress and the mask shown are those of the last one.",
)

METHOD = "Faruqi et al., MechStyle (SCF 2025), doi 10.1145/3745778.3766655"
