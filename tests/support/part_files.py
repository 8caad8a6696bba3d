"""Files of one small part in every format, written as others write them, and the sentence that refuses a file."""

import io
import math
import zipfile

import manifold3d
import numpy as np
import trimesh

from mechstyle.errors import BadInput
from mechstyle.geometry.files import read
from mechstyle.records.mesh import SurfaceMesh

CORE = "http://schemas.microsoft.com/3dmanufacturing/core/2015/02"


def stepped():
    """A block of 10 x 20 x 30 mm with one corner cut out: no rotation or reflection maps it onto itself."""
    body = manifold3d.Manifold.cube((10, 20, 30)) - manifold3d.Manifold.cube((4, 7, 11))
    mesh = body.to_mesh64()
    return SurfaceMesh(mesh.vert_properties, mesh.tri_verts)


PART = stepped()
VOLUME = 6000.0 - 4 * 7 * 11


def sorted_rows(points):
    return np.array(sorted(np.round(points, 3).tolist()))


def assert_is_part(mesh, *, scale=1.0):
    """The same corners in the same places, and the same volume."""
    assert mesh.is_closed
    assert math.isclose(mesh.volume, VOLUME * scale**3, rel_tol=1e-6)
    assert np.allclose(sorted_rows(mesh.vertices), sorted_rows(PART.vertices * scale), atol=2e-3)  # of rounding before sorting


def exported(kind, vertices=PART.vertices, faces=PART.faces):
    content = trimesh.Trimesh(vertices, faces, process=False).export(file_type=kind)
    return content.encode() if isinstance(content, str) else content


def ascii_ply(vertices=PART.vertices, faces=PART.faces):
    head = f"ply\nformat ascii 1.0\nelement vertex {len(vertices)}\nproperty float x\nproperty float y\nproperty float z\n"
    head += f"element face {len(faces)}\nproperty list uchar int vertex_indices\nend_header\n"
    rows = [" ".join(map(str, vertex)) for vertex in vertices] + [" ".join(map(str, (3, *face))) for face in faces]
    return (head + "\n".join(rows) + "\n").encode()


def glb_with_node():
    """In metres and y up, moved and turned by the transformation of its node; PART once that is applied."""
    y_up = PART.vertices[:, [0, 2, 1]] * (1, 1, -1) / 1000
    node = trimesh.transformations.euler_matrix(0.3, 0.5, 0.7)
    node[:3, 3] = 0.1, 0.2, 0.3
    local = (y_up - node[:3, 3]) @ node[:3, :3]
    scene = trimesh.Scene()
    scene.add_geometry(trimesh.Trimesh(local, PART.faces, process=False), transform=node)
    return scene.export(file_type="glb")


def threemf(resources, build, unit='unit="millimeter"'):
    model = f'<?xml version="1.0"?><model {unit} xmlns="{CORE}"><resources>{resources}</resources><build>{build}</build></model>'
    buffer = io.BytesIO()
    with zipfile.ZipFile(buffer, "w") as package:
        package.writestr("3D/3dmodel.model", model)
    return buffer.getvalue()


def xml_object(number, vertices=PART.vertices, faces=PART.faces):
    points = "".join(f'<vertex x="{x}" y="{y}" z="{z}"/>' for x, y, z in vertices)
    triangles = "".join(f'<triangle v1="{a}" v2="{b}" v3="{c}"/>' for a, b, c in faces)
    return f'<object id="{number}" type="model"><mesh><vertices>{points}</vertices><triangles>{triangles}</triangles></mesh></object>'


def threemf_in(unit, millimetres):
    attribute = f'unit="{unit}"' if unit else ""
    return threemf(xml_object(1, PART.vertices / millimetres), '<item objectid="1"/>', attribute)


def put(folder, name, content):
    path = folder / name
    path.write_bytes(content)
    return path


def refusal(path, **options):
    """The one sentence in which a file is refused."""
    try:
        read(path, **options)
    except BadInput as refused:
        message = str(refused)
    else:
        raise AssertionError(f"{path.name} was read")
    assert path.name in message
    assert "\n" not in message
    return message
