"""What things are called, wherever people read of them, and what each is, in a sentence."""

from __future__ import annotations

WORDS: dict[str, tuple[str, str]] = {
    "relief": ("relief", "How far the style stands out of the part and goes into it, from its lowest to its highest, in millimetres."),
    "feature": ("feature", "How long one brick, scale or stitch is, in millimetres."),
    "side": ("goes", "Where the relief goes from the surface: outwards, inwards, or both ways; by itself outwards on thin walls."),
    "inside": ("inside", "What becomes of the inside of a cup, a tray or a case: it stays plain, or is styled as well."),
    "nozzle": ("nozzle", "Width of the printer's nozzle: bricks and stitches that are not given are made large enough for it."),
    "seed": ("seed", "Another number draws the same style a little differently."),
    "guidance": ("style from", "What the part takes its style from: a pattern drawn for it, or what the network CLIP makes of your words."),
    "field": (
        "described by",
        ("How the shape is written down while it changes: a value at each of its points, or a small network that gives all points theirs."),
    ),
    "vertices": ("vertices", "How many points the surface has: more draw finer and take longer."),
    "protect": ("protected", "Places that keep their shape, because you said so."),
    "stress": ("stress", "How hard the material is pulled or pressed at a place, in MPa: von Mises stress, averaged over 2 mm."),
    "yield_strength": ("yield strength", "The stress at which a material begins to yield: it is bent for good."),
    "limit": ("limit", "The greatest stress that still passes, in the test it belongs to."),
    "demand": ("demand", "How much of what a place could still bear the style has taken: 0 on the plain part, 1 at its limit."),
    "normalisation": (
        "compares",
        (
            "What stress is compared with to make demand of it: the place's own reserve, the peak of the plain part, or a share of "
            "the yield strength."
        ),
    ),
    "headroom": ("headroom", "How much more stress a place could bear than it has on the plain part."),
    "mask, restraint": ("held back", "How much of its movement a place is denied: 0 moves freely, 1 stops."),
    "threshold": ("threshold", "Demand at which a place may move no further; less is more careful."),
    "control": (
        "strategy",
        (
            "How demand becomes restraint: evenly (linear), firmly near the limit (exponential), only at the limit (frozen), "
            "not at all (none)."
        ),
    ),
    "guarantee": ("correction", "A finished part that fails is lowered where it is overloaded, step by step, until it passes."),
    "schedule": ("schedule", "At which iterations the part is dropped on the way; the last one always is."),
    "travel": ("travel", "How far the surface has moved since it was last dropped, as a share of the wall."),
    "style_loss": ("style loss", "How far the part is from the style that was asked for."),
    "kept": ("relief kept", "How much of the relief is there, of what the style alone would have made."),
    "lane": ("lane, branch", "Another way on from some iteration, with other settings, in the same run."),
    "orientations, poses": ("landings", "How the part is turned when it meets the floor."),
    "flat": ("flat", "The landing on what the part stands on, as it stands."),
    "nearly_flat": (
        "nearly flat",
        "Landings tilted by 3° onto the corners and sides of what the part stands on; the worst of them is judged.",
    ),
    "any_landing": ("any landing", "Landings in other directions, judged by their mean against the plain part; only if you ask for them."),
    "height": ("fall", "How high the fall is that the part is to survive, 1.5 m unless you say otherwise."),
    "original": ("plain part", "The part without a style, which takes the same tests."),
    "critical_height": (
        "critical drop height",
        "From how high the part may fall, in one landing, before a piece as large as a cube of 4 mm begins to yield.",
    ),
    "factor": ("load factor", "How many times its load the part may carry before a piece as large as a cube of 2 mm begins to yield."),
    "reserve": ("reserve", "What the part survives beyond what it needs to pass a test; below zero it fails."),
    "safety_factor": (
        "safety factor",
        "Yield strength over stress, σ_y/σ_V, in the test with the least of it: below 1 a piece of the part begins to yield.",
    ),
    "section": ("cut", "A plane beyond which the part is left out of the view, so that one sees inside."),
    "places": ("places", "Points whose values are kept in a list, with a number each."),
    "moment": ("stress of the moment", "Stress at one moment of an impact; its greatest moment is the peak."),
    "outcome": (
        "HOLDS · NO WORSE · FAILS · UNKNOWN",
        (
            "Survives what you asked for · does not, but nearly as much as the plain part, which does not either · survives clearly less"
            " · the test gave no answer, which is never to be read as survived."
        ),
    ),
    "doubts": (
        "doubt",
        "Why an outcome is not sure: a test closer to its limit than it repeats, or a mesh that misses some of the relief.",
    ),
    "criterion": (
        "criterion",
        "What the part is judged by: `robust`, the fall and the loads it survives; `paper`, the published rule alone.",
    ),
    "minimum_wall": ("thinnest wall", "The style may not leave a wall thinner than this."),
    "freestyle": (
        "Freestyle, MechStyle",
        "The whole style, tested at the end · the style, held back on the way where the part needs its strength.",
    ),
    "both": ("Both", "One run after the other on the same part, MechStyle and then Freestyle, shown side by side."),
    "pinned, third": ("beside, third pane", "Iterations that stay in sight, under the same camera, next to the one on show."),
    "decisive": ("✕, what decides", "The place that decides the verdict of the one, of those compared, that has least left."),
    "scrubber": (
        "iteration",
        "The slider through a run: while it is dragged the page draws by itself, where it rests the kernel is asked.",
    ),
}
"""By the names in code: the word people read, and the sentence that teaches it; `docs/glossary.md` is this as a table."""
