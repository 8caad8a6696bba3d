"""Fixed texts of a report: method, limits, meaning of the outcomes."""

from __future__ import annotations

OUTCOMES = {
    "VIABLE": "In the simulated drop the part stayed within every limit that counts under the criterion.",
    "FAILS": "In the simulated drop the part exceeded a limit. Do not use it as it is: restrain the style more, or thicken the part.",
    "UNKNOWN": "The simulation gave no usable answer. Never read this as survived.",
}

MARGINAL = "Marginal: within the uncertainty of the method, so take it as undecided."

LIMITS = (
    "The verdict compares the styled part with the original. It is no certificate: do not rely on it where somebody can get hurt.",
    "The material is isotropic and elastic up to yield: no layers without a build direction, no infill, fatigue, creep or fracture.",
    "Where the floor meets the part at a point, the literal peak stress depends on the mesh.",
    "The default rule therefore uses a mean over 2 mm, along the surface or beside contact in a ball; the published one is shown too.",
    "Landings on edges and corners are judged by how much they differ from the original, not against yield: any plastic part yields there.",
    "Figures within 5 % of a limit, or 15 % where the stress around a contact decides, are marginal: meshing anew moves them that far.",
    "A drop hardly notices walls that are merely too thin to print or to handle. Look at the wall thickness too.",
    "Between simulations the stress and the mask shown are those of the last one.",
)

METHOD = "Faruqi et al., MechStyle (SCF 2025), doi 10.1145/3745778.3766655"
