"""A part before its run: plain, or with the style that is asked for on it."""

from __future__ import annotations

from typing import Any

from mechstyle.records.mesh import SurfaceMesh
from mechstyle_widgets.viewer.badge import untested
from mechstyle_widgets.viewer.layers import Subject
from mechstyle_widgets.viewer.viewer import Viewer


class PartViewer(Viewer):
    """The part, to which the places of clicks belong whatever style is shown on it."""

    def __init__(self, mesh: SurfaceMesh, **look: Any) -> None:
        """Show a plain part; `look` as for `Viewer`."""
        self._rest = mesh
        super().__init__(mesh, **look)

    @property
    def at_rest(self) -> SurfaceMesh:
        """The plain part."""
        return self._rest

    def put_on(self, styled: SurfaceMesh, more: str) -> None:
        """Show a style on it that was not tested; `more` is said below that."""
        self.subject, self.original = Subject(styled), Subject(self._rest)
        self.badge.say(untested("Preview", more))

    def wait(self) -> None:
        """Say that a style is being drawn, unless another is on show until then."""
        if self.original is None:
            self.badge.say(untested("Preview", "The style is being drawn on the part …"))

    def take_off(self, why: str = "") -> None:
        """Show the plain part, and say why if there is a reason."""
        self.subject, self.original = Subject(self._rest), None
        self.badge.say(untested("No preview", why) if why else "")
