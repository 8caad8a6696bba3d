"""A box as a STEP file (ISO 10303-21, AP214), written by hand: its corners, edges and faces."""

FACES = (
    ((0, 1, 3, 2), (-1, 0, 0), (0, 1, 0)),
    ((4, 6, 7, 5), (1, 0, 0), (0, 1, 0)),
    ((0, 4, 5, 1), (0, -1, 0), (1, 0, 0)),
    ((2, 3, 7, 6), (0, 1, 0), (1, 0, 0)),
    ((0, 2, 6, 4), (0, 0, -1), (1, 0, 0)),
    ((1, 5, 7, 3), (0, 0, 1), (1, 0, 0)),
)
"""Corners of each face in turn, its normal, and a direction in it."""
MILLIMETRE = "(LENGTH_UNIT()NAMED_UNIT(*)SI_UNIT(.MILLI.,.METRE.))"


class Lines:
    """Entities by number."""

    def __init__(self):
        self.lines = []

    def add(self, entity):
        self.lines.append(f"#{len(self.lines) + 1}={entity};")
        return f"#{len(self.lines)}"

    def point(self, of):
        return self.add(f"CARTESIAN_POINT('',({','.join(repr(float(x)) for x in of)}))")

    def way(self, of):
        return self.add(f"DIRECTION('',({','.join(repr(float(x)) for x in of)}))")


def box_step(sides, unit="mm"):
    """The text of a box from the origin to `sides`, in mm or inches."""
    file = Lines()
    corners = [(a * sides[0], b * sides[1], c * sides[2]) for a in (0, 1) for b in (0, 1) for c in (0, 1)]
    points = [file.add(f"VERTEX_POINT('',{file.point(corner)})") for corner in corners]
    curves = {}

    def edge(a, b):
        low, high = min(a, b), max(a, b)
        if (low, high) not in curves:
            along = [float(q != p) for p, q in zip(corners[low], corners[high], strict=True)]
            vector = file.add(f"VECTOR('',{file.way(along)},1.)")
            line = file.add(f"LINE('',{file.point(corners[low])},{vector})")
            curves[low, high] = file.add(f"EDGE_CURVE('',{points[low]},{points[high]},{line},.T.)")
        return file.add(f"ORIENTED_EDGE('',*,*,{curves[low, high]},{'.T.' if a < b else '.F.'})")

    faces = []
    for loop, normal, tangent in FACES:
        edges = ",".join(edge(a, b) for a, b in zip(loop, loop[1:] + loop[:1], strict=True))
        loop_of_edges = file.add(f"EDGE_LOOP('',({edges}))")
        bound = file.add(f"FACE_OUTER_BOUND('',{loop_of_edges},.T.)")
        place = file.add(f"AXIS2_PLACEMENT_3D('',{file.point(corners[loop[0]])},{file.way(normal)},{file.way(tangent)})")
        plane = file.add(f"PLANE('',{place})")
        faces.append(file.add(f"ADVANCED_FACE('',({bound}),{plane},.T.)"))
    shell = file.add(f"CLOSED_SHELL('',({','.join(faces)}))")
    solid = file.add(f"MANIFOLD_SOLID_BREP('box',{shell})")
    origin = file.add(f"AXIS2_PLACEMENT_3D('',{file.point((0, 0, 0))},{file.way((0, 0, 1))},{file.way((1, 0, 0))})")
    _product(file, origin, solid, _length(file, unit))
    head = "FILE_DESCRIPTION((''),'2;1');\nFILE_NAME('box','',(''),(''),'','','');\nFILE_SCHEMA(('AUTOMOTIVE_DESIGN'));"
    return "\n".join(["ISO-10303-21;", "HEADER;", head, "ENDSEC;", "DATA;", *file.lines, "ENDSEC;", "END-ISO-10303-21;", ""])


def _length(file, unit):
    if unit == "mm":
        return file.add(MILLIMETRE)
    size = file.add("DIMENSIONAL_EXPONENTS(1.,0.,0.,0.,0.,0.,0.)")
    measure = file.add(f"LENGTH_MEASURE_WITH_UNIT(LENGTH_MEASURE(25.4),{file.add(MILLIMETRE)})")
    return file.add(f"(CONVERSION_BASED_UNIT('INCH',{measure})LENGTH_UNIT()NAMED_UNIT({size}))")


def _product(file, origin, solid, length):
    """What stands around a solid before a program takes it for a part."""
    angle = file.add("(NAMED_UNIT(*)PLANE_ANGLE_UNIT()SI_UNIT($,.RADIAN.))")
    solid_angle = file.add("(NAMED_UNIT(*)SI_UNIT($,.STERADIAN.)SOLID_ANGLE_UNIT())")
    accuracy = file.add(f"UNCERTAINTY_MEASURE_WITH_UNIT(LENGTH_MEASURE(1.E-5),{length},'','')")
    units = f"GLOBAL_UNCERTAINTY_ASSIGNED_CONTEXT(({accuracy}))GLOBAL_UNIT_ASSIGNED_CONTEXT(({length},{angle},{solid_angle}))"
    context = file.add(f"(GEOMETRIC_REPRESENTATION_CONTEXT(3){units}REPRESENTATION_CONTEXT('',''))")
    shape = file.add(f"ADVANCED_BREP_SHAPE_REPRESENTATION('box',({origin},{solid}),{context})")
    application = file.add("APPLICATION_CONTEXT('core data for automotive mechanical design processes')")
    around = file.add(f"PRODUCT_CONTEXT('',{application},'mechanical')")
    product = file.add(f"PRODUCT('box','box','',({around}))")
    formation = file.add(f"PRODUCT_DEFINITION_FORMATION('','',{product})")
    design = file.add(f"PRODUCT_DEFINITION_CONTEXT('part definition',{application},'design')")
    definition = file.add(f"PRODUCT_DEFINITION('design','',{formation},{design})")
    defined = file.add(f"PRODUCT_DEFINITION_SHAPE('','',{definition})")
    file.add(f"SHAPE_DEFINITION_REPRESENTATION({defined},{shape})")
