"""MechStyle: stylize a 3D-printable model from a prompt while a drop test watches its strength.

    import mechstyle as ms
    run = ms.stylize(ms.load("part.stl"), "brick", material="PLA")
    run.verdict
    run.show()

Units everywhere: mm, g, ms, N, MPa. Importing this package loads nothing; everything comes when asked for. What studies, plug-ins and
teaching need besides is in `mechstyle.lab`.
"""

from mechstyle._lazy import attached as _attached

__version__ = "0.1.0"
__getattr__, __dir__, __all__ = _attached(__name__, __file__)
