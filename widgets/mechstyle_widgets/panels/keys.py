"""What single keys do in a Studio; `jupyter/static/frame.js` hears them and lists them for its users."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

LAYERS = {"1": "style", "2": "stress", "3": "stays_bent", "4": "restraint", "5": "demand", "6": "displacement"}
"""Layers by the keys that show them."""


class Keys:
    """The keys of a Studio: call it with one. What it does not know is a matter of the view."""

    def __init__(self, studio: Any) -> None:
        """Work a Studio."""
        self._studio, controller, branches, picker = studio, studio.controller, studio.branches, studio.regions_picker
        self._acts: dict[str, Callable[[], object]] = {
            "r": controller.run,
            ".": controller.step,
            ">": controller.step_to_simulation,
            " ": controller.pause,
            "n": branches.branch,
            "c": lambda: branches.pin() if studio.state.checkpoint is not None else None,
            "i": self._impact,
            "w": studio.show_mask,
            "z": studio.step_back,
            "y": lambda: studio.step_back(forward=True),
            "p": lambda: setattr(picker, "paint", not picker.paint),
        }

    def __call__(self, key: str) -> None:
        """Carry out what a key stands for."""
        viewer = self._studio.viewer
        if key == "Escape" and self._studio.regions_picker.paint:
            self._studio.regions_picker.paint = False
        elif key == "Escape" and self._studio.close_page():
            pass
        elif key in self._acts:
            self._acts[key]()
        elif viewer is not None and key not in LAYERS:
            viewer.key(key)
        elif viewer is not None and (key == "1" or viewer.subject.layer(LAYERS[key]) is not None):
            viewer.layer = LAYERS[key]

    def _impact(self) -> None:
        """Show the impact, or the undeformed part again, also while it is being worked out."""
        player = getattr(self._studio.viewer, "player", None)
        if player is not None:
            (player.put_away if player.working or player.impact is not None else player.play)()
