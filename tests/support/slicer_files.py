"""3MF packages as slicers write them: boxes as objects in several model parts, and settings that say what each of them is."""

import io
import zipfile

CORE = "http://schemas.microsoft.com/3dmanufacturing"
PACKAGE = "http://schemas.openxmlformats.org/package/2006"
CORNERS = [(x, y, z) for x in (0, 1) for y in (0, 1) for z in (0, 1)]
SIDES = [(0, 1, 3), (0, 3, 2), (4, 6, 7), (4, 7, 5), (0, 4, 5), (0, 5, 1), (2, 3, 7), (2, 7, 6), (0, 2, 6), (0, 6, 4), (1, 5, 7), (1, 7, 3)]
PLATE, TOWER, BESIDE = ((40, 40, 10), (0, 0, 0)), ((10, 10, 30), (15, 15, 0)), ((10, 10, 30), (60, 0, 0))


def mesh(*boxes, attributes=""):
    """One mesh of boxes, each of a size and a lowest corner."""
    points = [[s * c + p for s, c, p in zip(size, corner, place, strict=True)] for size, place in boxes for corner in CORNERS]
    faces = [[8 * number + corner for corner in side] for number in range(len(boxes)) for side in SIDES]
    vertices = "".join(f'<vertex x="{x}" y="{y}" z="{z}"/>' for x, y, z in points)
    triangles = "".join(f'<triangle {attributes} v1="{a}" v2="{b}" v3="{c}"/>' for a, b, c in faces)
    return f"<mesh><vertices>{vertices}</vertices><triangles>{triangles}</triangles></mesh>"


def thing(number, content, attributes='type="model"'):
    return f'<object id="{number}" {attributes}>{content}</object>'


def components(number, *uses, attributes='type="model"'):
    return thing(number, "<components>" + "".join(f"<component {use}/>" for use in uses) + "</components>", attributes)


def model(resources="", build="", unit="millimeter"):
    spaces = f'xmlns="{CORE}/core/2015/02" xmlns:p="{CORE}/production/2015/06" xmlns:b="{CORE}/beamlattice/2017/02"'
    return f'<?xml version="1.0"?><model unit="{unit}" {spaces}><resources>{resources}</resources><build>{build}</build></model>'


def package(main, *, start="/3D/3dmodel.model", **others):
    """The bytes of a 3MF; `objects` are models in 3D/Objects, others settings in Metadata."""
    relation = f'<Relationship Target="{start}" Id="r" Type="{CORE}/2013/01/3dmodel"/>'
    members = {"_rels/.rels": f'<Relationships xmlns="{PACKAGE}/relationships">{relation}</Relationships>', start.lstrip("/"): main}
    members |= {f"3D/Objects/{name}.model": content for name, content in others.pop("objects", {}).items()}
    members |= {f"Metadata/{name}.config": content for name, content in others.items()}
    held = io.BytesIO()
    with zipfile.ZipFile(held, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, content in members.items():
            archive.writestr(zipfile.ZipInfo(name), content)
    return held.getvalue()


def orca(kind, *, name="tower"):
    """A plate of 40 × 40 × 10 mm with a second part, a tower of 10 × 10 × 30 mm, which the settings call `kind`."""
    resources = thing(1, mesh(PLATE)) + thing(2, mesh(TOWER)) + components(3, 'objectid="1"', 'objectid="2"')
    part = '<part id="{}" subtype="{}"><metadata key="name" value="{}"/></part>'
    both = part.format(1, "normal_part", "plate") + part.format(2, kind, name)
    settings = f'<config><object id="3"><metadata key="name" value="thing"/>{both}</object><plate/></config>'
    return package(model(resources, '<item objectid="3"/>'), model_settings=settings)


def orca_apart(kind):
    """The same as newer ones write it: both parts in an object file each, and both of the number 1."""
    uses = (f'p:path="/3D/Objects/{name}.model" objectid="1"' for name in "ab")
    parts = {"a": model(thing(1, mesh(PLATE))), "b": model(thing(1, mesh(TOWER), 'type="other"'))}
    settings = f'<config><object id="2"><part id="1" subtype="normal_part"/><part id="1" subtype="{kind}"/></object></config>'
    return package(model(components(2, *uses), '<item objectid="2"/>'), objects=parts, model_settings=settings)


def prusa(kind, *, key="volume_type"):
    """The same in one mesh, triangles 12 to 23 of which the settings call `kind`."""
    fact = '<metadata type="volume" key="{}" value="{}"/>'
    volume = '<volume firstid="{}" lastid="{}">' + fact.format("name", "{}") + fact + "</volume>"
    both = volume.format(0, 11, "plate", "volume_type", "ModelPart") + volume.format(12, 23, "tower", key, kind)
    settings = f'<config><object id="1" instances_count="1"><metadata type="object" key="name" value="thing"/>{both}</object></config>'
    return package(model(thing(1, mesh(PLATE, TOWER)), '<item objectid="1"/>'), Slic3r_PE_model=settings)


def cura(key, value="True"):
    """The same as Cura writes it, with words within the object of the tower."""
    said = f'<metadatagroup><metadata name="cura:{key}">{value}</metadata></metadatagroup>'
    tower = thing(2, said + mesh(TOWER), 'type="model" name="tower"')
    return package(model(thing(1, mesh(PLATE)) + tower, '<item objectid="1"/><item objectid="2"/>'))


def assembly(kind):
    """The same in an assembly: the plate with its second part turned within another object, the tower in a file in centimetres."""
    top = 'p:path="/3D/Objects/b.model" objectid="1"'
    turned = components(4, 'objectid="3" transform="0 1 0 -1 0 0 0 0 1 100 50 0"')
    settings = f'<config><object id="3"><part id="1" subtype="normal_part"/><part id="1" subtype="{kind}"/></object></config>'
    tower = model(thing(1, mesh(((1, 1, 3), (1.5, 1.5, 0)))), unit="centimeter")
    resources = thing(1, mesh(PLATE)) + components(3, 'objectid="1"', top) + turned
    return package(model(resources, '<item objectid="4"/>'), objects={"b": tower}, model_settings=settings)


def named_obj(word, boxes):
    """Boxes by name in an OBJ, each below a line of this word, o or g."""
    lines = []
    for number, (name, (size, place)) in enumerate(boxes):
        corners = [[s * c + p for s, c, p in zip(size, corner, place, strict=True)] for corner in CORNERS]
        lines += [f"{word} {name}", *("v {} {} {}".format(*corner) for corner in corners)]
        lines += ["f {} {} {}".format(*(8 * number + 1 + corner for corner in side)) for side in SIDES]
    return "\n".join(lines).encode()


def named_stl(boxes):
    """Boxes by name as solids of an ASCII STL."""
    text = ""
    for name, (size, place) in boxes:
        corners = [[s * c + p for s, c, p in zip(size, corner, place, strict=True)] for corner in CORNERS]
        rows = ("".join("vertex {} {} {}\n".format(*corners[corner]) for corner in side) for side in SIDES)
        text += f"solid {name}\n" + "".join(f"facet normal 0 0 0\nouter loop\n{row}endloop\nendfacet\n" for row in rows) + "endsolid\n"
    return text.encode()
