"""The second row of public names, for studies, plug-ins and teaching: `ms.lab.plan`, `ms.lab.Draft` and others.

Example:
    >>> ms.lab.material_named("PETG").density > ms.LIBRARY["PLA"].density
    True
"""

from mechstyle._lazy import attached as _attached

__getattr__, __dir__, __all__ = _attached(__name__, __file__)
