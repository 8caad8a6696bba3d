# The public names and where they are, read by type checkers, by editors, and by `mechstyle._lazy` when one is asked for.

from mechstyle import lab as lab
from mechstyle.errors import BadInput as BadInput, MechStyleError as MechStyleError
from mechstyle.gallery import load as load
from mechstyle.gallery.swatches import styles as styles
from mechstyle.geometry.files import save as save
from mechstyle.records import Recipe as Recipe, Verdict as Verdict
from mechstyle.records.load_cases import Load as Load, LoadCase as LoadCase, Support as Support
from mechstyle.records.material import LIBRARY as LIBRARY, Material as Material
from mechstyle.records.mesh import SurfaceMesh as SurfaceMesh
from mechstyle.records.regions import Box as Box, HalfSpace as HalfSpace, Sphere as Sphere
from mechstyle.runs.printing import Printing as Printing
from mechstyle.runs.protection import protect as protect
from mechstyle.runs.run import Run as Run, stylize as stylize
from mechstyle.runs.stylizers import register_stylizer as register_stylizer
from mechstyle.simulation.part_test import PartTest as PartTest, simulate as simulate

__version__: str
