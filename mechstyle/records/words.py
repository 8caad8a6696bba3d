"""What things are called, wherever people read of them, and what each is, in a sentence."""

from __future__ import annotations

WORDS: dict[str, tuple[str, str]] = {
    "relief": ("relief", "Depth of the style, from its lowest to its highest place, in millimetres."),
    "feature": ("feature", "Size of one brick, scale or stitch, in millimetres."),
    "side": ("goes", "Direction of the relief: outwards, inwards, or both; by default outwards on thin walls."),
    "inside": ("inside", "The inside of a cup, a tray or a case: it stays plain, or is styled as well."),
    "nozzle": ("nozzle", "Width of the printer's nozzle: by default bricks and stitches are large enough for it."),
    "seed": ("seed", "Another number draws the same style a little differently."),
    "guidance": ("style from", "Source of the style: a pattern drawn offline, or the network CLIP, which takes any prompt."),
    "field": ("described by", "What CLIP optimises: one offset for each vertex, or a small network that gives all vertices theirs."),
    "vertices": ("vertices", "Number of points of the surface: more of them draw finer and take longer."),
    "protect": ("protected", "Places that the style leaves plain."),
    "stress": ("stress", "Force per area inside the material, in MPa: von Mises stress, averaged over 2 mm."),
    "yield_strength": ("yield strength", "The stress at which a material begins to yield: what goes on from there is bent for good."),
    "hatched": ("hatched", "In a picture of stress, what has yielded; in any other, what is beyond the limit on its colour bar."),
    "permanent_set": ("what stays bent", "How far the part is off its shape when all is at rest, in millimetres: a caliper reads it."),
    "tolerance": ("tolerance", "The most that may stay bent after a fall or a load, 0.2 mm by default: half a line of plastic."),
    "plastic_strain": ("strain", "Share by which the material was stretched for good where it was stretched most."),
    "elongation": ("elongation at break", "The strain at which a material cracks: some 2 to 6 % for printed plastics."),
    "limit": ("allowed", "What may stay bent in a test: the tolerance, or a little more than stays bent of the plain part."),
    "demand": ("demand", "Share of a place's reserve that the style has used: 0 on the plain part, 1 where it yields."),
    "normalisation": (
        "compares",
        "What stress is compared with: the reserve of that place, the peak of the plain part, or a share of the yield strength.",
    ),
    "headroom": ("headroom", "Reserve of a place: what its material bears before it yields, less what the plain part needs of it."),
    "restraint": ("held back", "Share of its movement that a place is denied: 0 moves freely, 1 stops. The mask is 1 less that."),
    "threshold": ("threshold", "Demand at which a place may move no further; less is more careful."),
    "control": (
        "strategy",
        "How demand slows the style: evenly (linear), faster than that (exponential), only at the limit (frozen), not at all (none).",
    ),
    "guarantee": (
        "correction",
        "A finished part that fails is lowered where it yields, or as a whole; what passes and keeps most is taken.",
    ),
    "schedule": ("schedule", "At which iterations the part is dropped on the way; the last one always is."),
    "travel": ("travel", "Movement of the surface since its last drop, as a share of the wall."),
    "style_loss": ("style loss", "Distance of the part from the style that was asked for."),
    "kept": ("relief kept", "Share of the style's relief that is on the part."),
    "lane": ("lane, branch", "A course of a run; a new one begins at any iteration, with other settings."),
    "orientations, poses": ("landings", "Ways in which the part is turned when it meets the floor."),
    "flat": ("flat", "The landing on what the part stands on, as it stands."),
    "nearly_flat": (
        "nearly flat",
        "Landings tilted by 3° onto the corners and sides of what the part stands on; each of them is judged.",
    ),
    "any_landing": ("any landing", "Landings in other directions, if you ask for them; each of them is judged."),
    "height": ("fall", "Height from which the part is to survive a fall, 1.5 m by default."),
    "original": ("plain part", "The part without a style, which takes the same tests."),
    "section": ("cut", "A plane that opens the view: the part beyond it is hidden."),
    "places": ("places", "Points of the surface in a numbered list, with their values."),
    "moment": ("stress of the moment", "Stress at one moment of an impact; its greatest moment is the peak."),
    "outcome": (
        "HOLDS · NO WORSE · FAILS · UNKNOWN",
        (
            "In no test more than the tolerance stays bent, and nothing cracks · more stays, but hardly more than of the plain part · more"
            " stays, or it cracks · the test gave no answer, which is never to be read as survived."
        ),
    ),
    "doubts": (
        "doubt",
        "Why an outcome is not sure: a test closer to what is allowed than it repeats, or a mesh that misses some of the relief.",
    ),
    "criterion": (
        "criterion",
        "Rule of the verdict: `robust`, what stays bent; `paper`, the published rule, the largest stress against the yield strength.",
    ),
    "loads": ("load", "Forces of its use that the part must carry: put on, held and taken off."),
    "strengthen": ("thicken", "A plain part that fails is first made thicker where it yields."),
    "tetrahedra": ("mesh", "The small tetrahedra that fill the part, on which the simulation computes."),
    "minimum_wall": ("thinnest wall", "Least thickness of a wall that the style may leave."),
    "freestyle": (
        "Freestyle, MechStyle",
        "The whole style, tested at the end · the style, kept away from where the part needs its strength.",
    ),
    "both": ("Both", "One run after the other on the same part, MechStyle and then Freestyle, shown side by side."),
    "pinned, third": ("beside, third pane", "Iterations that stay in sight next to the one that is shown, under the same camera."),
    "decisive": ("✕, the worst place", "The place that stays bent most, of the version that is worse off."),
    "iteration": ("iteration", "A step of the style; the slider shows any of them."),
}
"""by the names in code: the word people read, and the sentence that teaches it; `docs/glossary.md` lists them."""
