"""The renderer against formulas worked by hand, the picture room's camera, and differences of its own pictures."""

import math
import subprocess
import sys

import numpy as np
import pytest
import torch
from torch.nn.functional import max_pool2d

from mechstyle.errors import BadInput
from mechstyle.pictures.camera import Camera
from mechstyle.records.mesh import SurfaceMesh
from mechstyle.styling.learned.renderer import Cameras, Renderer, random_views
from support.degenerate import needled, seamed

VIEWS = Cameras(torch.tensor([0.3, -0.5, 1.2], dtype=torch.float64), torch.tensor([0.5, 2.2, -1.0], dtype=torch.float64))
SIZE = 64


@pytest.fixture(scope="module")
def faces(sphere):
    return torch.tensor(sphere.faces)


@pytest.fixture(scope="module")
def egg(sphere):
    """An ellipsoid: no part of it hides another, so its only outline is the one against the background."""
    return torch.tensor(sphere.vertices / 10.0) * torch.tensor([0.9, 0.7, 0.6], dtype=torch.float64)


@pytest.fixture(scope="module")
def paint(egg):
    return 0.4 + 0.2 * torch.sin(5.0 * egg)


def slope(function, at, direction, step):
    """Derivative of a scalar function along a direction, by central difference and by autograd."""
    with torch.no_grad():
        measured = (function(at + step * direction) - function(at - step * direction)) / (2.0 * step)
    leaf = at.clone().requires_grad_()
    function(leaf).backward()
    return float(measured), float((leaf.grad * direction).sum())


def waves(views=3, size=SIZE):
    """Smooth weights over pictures, so that a sum of pixels feels where things are."""
    along = torch.linspace(-1.0, 1.0, size, dtype=torch.float64)
    return torch.stack([torch.sin(3.0 * along + k)[None] * torch.cos(2.0 * along - k)[:, None] for k in range(3)]).expand(views, -1, -1, -1)


# --- gradients ----------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("seed", [0, 1, 2])
def test_gradients_inside_the_outline_are_those_of_the_picture(egg, faces, paint, seed):
    renderer = Renderer(faces, SIZE)
    inside = max_pool2d(1.0 - renderer(egg, paint, VIEWS).coverage, 5, stride=1, padding=2) == 0
    generator = torch.Generator().manual_seed(seed)
    weights = inside * torch.rand(3, 3, SIZE, SIZE, generator=generator, dtype=torch.float64)
    direction = torch.randn(egg.shape, generator=generator, dtype=torch.float64)
    measured, found = slope(lambda points: (renderer(points, paint, VIEWS).image * weights).sum(), egg, direction, 1e-6)
    assert found == pytest.approx(measured, rel=1e-3)


def test_a_vertex_feels_its_own_normal_and_place(egg, faces, paint):
    """One vertex in the middle of a view, each coordinate: what a sum over many vertices could hide."""
    front = Cameras(torch.zeros(1, dtype=torch.float64), torch.zeros(1, dtype=torch.float64))
    nearest = int(egg[:, 0].argmax())
    renderer, weights = Renderer(faces, SIZE), torch.rand(1, 3, SIZE, SIZE, generator=torch.Generator().manual_seed(5), dtype=torch.float64)
    for axis in range(3):
        direction = torch.zeros_like(egg)
        direction[nearest, axis] = 1.0
        measured, found = slope(lambda points: (renderer(points, paint, front).image * weights).sum(), egg, direction, 1e-6)
        assert found == pytest.approx(measured, rel=1e-3)


@pytest.mark.parametrize("flaw", [seamed, lambda mesh, apart: needled(mesh, range(0, len(mesh.faces), 3), apart)], ids=["seams", "needles"])
@pytest.mark.parametrize("apart", [0.0, 1e-9, 1e-6, 1e-5, 1e-4])
def test_triangles_without_area_get_no_gradient_that_drowns_the_others(egg, faces, apart, flaw):
    views = Cameras(VIEWS.elevation.float(), VIEWS.azimuth.float())

    def gradient(points, faces):
        leaf, paint = points.float().requires_grad_(), (0.4 + 0.2 * torch.sin(5.0 * points)).float()
        (Renderer(faces, 224)(leaf, paint, views).image * waves(size=224)).sum().backward()
        return leaf.grad

    broken = flaw(SurfaceMesh(egg.numpy(), faces.numpy()), apart)
    sound, found = gradient(egg, faces), gradient(torch.tensor(broken.vertices), torch.tensor(broken.faces))
    assert found.isfinite().all()
    assert found.abs().max() < 5.0 * sound.abs().max()


@pytest.mark.parametrize("axis", [0, 1, 2, None])
def test_the_outline_has_gradients(egg, faces, paint, axis):
    """Moving along an axis, or growing. Blending between two pixel centres is not the exact area, so the bound is a measured one."""
    direction = egg if axis is None else torch.eye(3, dtype=torch.float64)[axis].expand_as(egg)
    renderer, weights = Renderer(faces, SIZE), waves()
    measured, found = slope(lambda points: (renderer(points, paint, VIEWS).image * weights).sum(), egg, direction, 0.02)
    assert found == pytest.approx(measured, rel=0.15)


def torus(bump, around=250, along=100):
    """Vertices of a lying ring, y up, with bumps as high as that, and its faces: a ring hides parts of itself."""
    u, v = torch.meshgrid(*(torch.arange(count, dtype=torch.float64) * (2 * math.pi / count) for count in (around, along)), indexing="ij")
    tube = 0.3 + bump * torch.sin(11 * u) * torch.cos(7 * v)
    ring = 0.62 + tube * v.cos()
    number = torch.arange(around * along).view(around, along)
    a, b, c, d = number, number.roll(-1, 0), number.roll((-1, -1), (0, 1)), number.roll(-1, 1)
    faces = torch.stack([torch.stack(corners, dim=-1) for corners in ((a, b, c), (a, c, d))]).view(-1, 3)
    return torch.stack([ring * u.cos(), tube * v.sin(), -ring * u.sin()], dim=-1).view(-1, 3), faces


@pytest.mark.parametrize("shape", ["torus", "bumpy torus", "pen holder"])
def test_gradients_of_parts_that_hide_themselves_are_those_of_the_picture(shape, holder):
    """Growing, shifting and a single bump. What remains within the bound is chance: where outlines happen to pass between centres."""
    upright = torch.tensor(holder.vertices[:, [0, 2, 1]] * (1.0, 1.0, -1.0)) / 75.0 - torch.tensor([0.0, 0.65, 0.0], dtype=torch.float64)
    points, faces = (upright, torch.tensor(holder.faces)) if shape == "pen holder" else torus(0.02 if shape == "bumpy torus" else 0.0)
    paint, renderer, weights = 0.4 + 0.2 * torch.sin(5.0 * points), Renderer(faces, 224), waves(size=224)
    near = torch.tensor([0.4, 0.3, 0.5], dtype=torch.float64)
    bump = near * torch.exp(-(points - near).square().sum(dim=1, keepdim=True) / 0.25**2)
    for direction in (points, *(axis.expand_as(points) for axis in torch.eye(3, dtype=torch.float64)), bump):
        measured, found = slope(lambda at: (renderer(at, paint, VIEWS).image * weights).sum(), points, direction, 0.02)
        assert found == pytest.approx(measured, rel=0.1)


def test_covered_area_and_its_growth_are_those_of_the_cone_around_a_sphere(sphere, faces):
    radius = torch.tensor(0.8, dtype=torch.float64, requires_grad=True)
    points = radius * torch.tensor(sphere.vertices / 10.0)
    area = Renderer(faces, SIZE)(points, torch.ones_like(points), VIEWS).coverage.sum()
    area.backward()
    pixels_at_one = SIZE / 2.0 / math.tan(math.radians(30.0))
    expected = 3.0 * math.pi * pixels_at_one**2 * 0.8**2 / (2.0**2 - 0.8**2)  # tan² asin(r / d) = r² / (d² - r²)
    assert area.item() == pytest.approx(expected, rel=2e-3)
    assert radius.grad.item() == pytest.approx(expected * 2.0 / 0.8 * 2.0**2 / (2.0**2 - 0.8**2), rel=1e-2)


def test_colours_have_exact_gradients(egg, faces, paint):
    """Unclamped, a picture is an affine function of the colours, so any step gives its slope."""
    renderer, weights = Renderer(faces, SIZE), waves()
    measured, found = slope(lambda colours: (renderer(egg, colours, VIEWS).image * weights).sum(), paint, egg.roll(1, 0), 0.05)
    assert found == pytest.approx(measured, rel=1e-9)


def test_hard_outlines_have_none(egg, faces, paint):
    points = egg.clone().requires_grad_()
    coverage = Renderer(faces, SIZE, antialias=False)(points, paint, VIEWS).coverage
    assert set(coverage.unique().tolist()) == {0.0, 1.0}
    (slopes,) = torch.autograd.grad(coverage.sum(), points)
    assert (slopes == 0.0).all()


# --- what is seen -------------------------------------------------------------------------------------------------


def test_a_sphere_is_lit_as_its_radii_say(sphere, faces):
    """White light on grey 0.5 by the first spherical harmonics, with the normal where each pixel's ray meets the sphere."""
    points = torch.tensor(sphere.vertices / 10.0)
    view = Renderer(faces, SIZE)(points, torch.full_like(points, 0.5), Cameras(torch.zeros(1), torch.zeros(1)))
    along = ((2 * np.arange(SIZE) + 1) / SIZE - 1) * math.tan(math.radians(30.0))
    rays = np.stack(np.broadcast_arrays(along[None, :], -along[:, None], -1.0), axis=-1)
    rays /= np.linalg.norm(rays, axis=-1, keepdims=True)
    reach = -2.0 * rays[..., 2] - np.sqrt(np.maximum((2.0 * rays[..., 2]) ** 2 - 3.0, 0.0))
    normals = reach[..., None] * rays + (0.0, 0.0, 2.0)  # in camera axes: the sphere is at the origin, the camera at z = 2
    expected = np.clip(0.5 * (0.28209479177 + 0.48860251190 * normals.sum(axis=-1)), 0.0, 1.0)
    inside = max_pool2d(1.0 - view.coverage, 3, stride=1, padding=1)[0, 0].numpy() == 0
    assert view.image[0, 1].numpy()[inside] == pytest.approx(expected[inside], abs=0.01)  # facets of 3 degrees


def test_a_triangle_shows_the_colours_where_the_rays_of_the_pixels_meet_it():
    corners, colours = [(0.0, -0.5, 0.6), (0.3, -0.4, -0.5), (-0.4, 0.6, 0.1)], [(0.8, 0.1, 0.2), (0.1, 0.7, 0.3), (0.2, 0.3, 0.6)]
    points, paint = torch.tensor(corners, dtype=torch.float64), torch.tensor(colours, dtype=torch.float64)
    view = Renderer(torch.tensor([[0, 1, 2]]), 16)(points, paint, Cameras(torch.zeros(1), torch.zeros(1)))
    seen = np.array([(-z, y, x - 2.0) for x, y, z in corners])  # in camera axes
    normal = np.cross(seen[1] - seen[0], seen[2] - seen[0])
    light = 0.28209479177 + 0.48860251190 * normal.sum() / np.linalg.norm(normal)
    for row, column in ((8, 8), (7, 7), (9, 6)):
        x, y = (math.tan(math.radians(30.0)) * number / 16 for number in (2 * column + 1 - 16, 16 - 1 - 2 * row))
        system = np.vstack([np.column_stack([seen.T, [-x, -y, 1.0]]), [1.0, 1.0, 1.0, 0.0]])
        weights = np.linalg.solve(system, [0.0, 0.0, 0.0, 1.0])[:3]
        assert view.image[0, :, row, column].numpy() == pytest.approx(light * weights @ np.array(colours), abs=1e-6)


def test_faces_are_seen_from_outside_only():
    """Also well above the axis, where a face shows its front although its normal has a negative part along the viewing axis."""
    points = torch.tensor([(0.0, -0.9, -0.3), (0.0, -0.9, 0.3), (0.8, -0.6, 0.0)], dtype=torch.float64)
    front, eye = Cameras(torch.zeros(1), torch.zeros(1)), torch.tensor([2.0, 0.0, 0.0], dtype=torch.float64)
    for order in ([0, 1, 2], [0, 2, 1]):
        seen = Renderer(torch.tensor([order]), SIZE)(points, points.abs(), front)
        normal = torch.linalg.cross(points[order[1]] - points[order[0]], points[order[2]] - points[order[0]])
        assert bool(seen.coverage.any()) == bool(normal @ (eye - points[0]) > 0)


def test_views_at_once_are_the_views_one_by_one(egg, faces, paint):
    renderer = Renderer(faces, SIZE)
    together = renderer(egg, paint, VIEWS)
    for k in range(3):
        alone = renderer(egg, paint, Cameras(VIEWS.elevation[k : k + 1], VIEWS.azimuth[k : k + 1]))
        assert torch.allclose(together.image[k], alone.image[0], atol=1e-12)
        assert torch.allclose(together.coverage[k], alone.coverage[0], atol=1e-12)


def test_shapes_that_do_not_depend_on_what_is_seen_change_nothing(egg, faces, paint):
    views, slopes = [], []
    for static in (False, True):
        points, colours = egg.clone().requires_grad_(), paint.clone().requires_grad_()
        seen = Renderer(faces, SIZE, static=static)(points, colours, VIEWS)
        ((seen.image + seen.coverage) * waves()).sum().backward()
        views.append(torch.cat([seen.image, seen.coverage], dim=1).detach())
        slopes.append(torch.cat([points.grad, colours.grad]))
    assert torch.allclose(*views, atol=1e-12)
    assert torch.allclose(*slopes, rtol=1e-9, atol=1e-9)


def test_single_precision_is_enough(egg, faces, paint):
    pictures, slopes = [], []
    for kind in (torch.float32, torch.float64):
        points = egg.to(kind).requires_grad_()
        image = Renderer(faces, SIZE)(points, paint.to(kind), VIEWS).image
        (image * waves()).sum().backward()
        pictures.append(image.detach().double())
        slopes.append(points.grad.double())
    assert image.dtype == torch.float64
    assert (pictures[0] - pictures[1]).abs().quantile(0.999) < 1e-4  # a pixel at an edge may see the other face
    assert (slopes[0] - slopes[1]).norm() < 1e-2 * slopes[1].norm()


def test_nothing_in_view_is_white_and_has_no_gradient(faces, egg, paint):
    points = (egg + 50.0).requires_grad_()
    for static in (False, True):
        seen = Renderer(faces, 8, static=static)(points, paint, VIEWS)
        assert (seen.image == 1.0).all()
        assert (seen.coverage == 0.0).all()
        (slope,) = torch.autograd.grad(seen.image.sum(), points)
        assert (slope == 0.0).all()


# --- cameras ------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(("azimuth", "elevation"), [(0.0, 0.0), (35.0, 28.0), (200.0, -60.0), (90.0, 90.0)])
def test_cameras_are_those_of_the_pictures_with_y_up(sphere, azimuth, elevation):
    upright = sphere.vertices / 10.0 * (0.9, 0.5, 0.7) + (0.05, 0.02, -0.1)
    x, y, depth = Camera(azimuth, elevation, (0.0, 0.0, 0.0), 2.0, 60.0).project(upright).T
    turned = torch.tensor(upright[:, [0, 2, 1]] * (1.0, 1.0, -1.0))
    angles = torch.deg2rad(torch.tensor([[elevation], [90.0 - azimuth]], dtype=torch.float64))
    found = Cameras(angles[0], angles[1]).project(turned, SIZE)[0].numpy()
    assert found == pytest.approx(np.column_stack([(x + 1.0) * SIZE / 2, (1.0 - y) * SIZE / 2, 1.0 / depth]), abs=1e-9)


def test_axes_are_a_right_handed_frame_with_y_up_also_beyond_a_pole():
    around = torch.linspace(-3.0, 3.0, 13, dtype=torch.float64)
    axes = Cameras(around, 2.0 * around).axes
    assert torch.allclose(axes @ axes.transpose(1, 2), torch.eye(3, dtype=torch.float64).expand(13, 3, 3))
    assert torch.allclose(torch.linalg.det(axes), torch.ones(13, dtype=torch.float64))
    assert (axes[:, 1, 1] >= 0).all()


def test_random_views_are_spread_around_the_centre_which_comes_first():
    views = random_views(20001, (0.6, -1.0), 4.0, torch.Generator().manual_seed(1))
    assert (views.elevation[0], views.azimuth[0]) == (torch.tensor(0.6), torch.tensor(-1.0))
    assert float(views.elevation.mean()) == pytest.approx(0.6, abs=0.03)
    assert float(views.azimuth.mean()) == pytest.approx(-1.0, abs=0.05)
    assert float(views.elevation.std()) == pytest.approx(math.pi / 4, rel=0.02)
    assert float(views.azimuth.std()) == pytest.approx(math.pi / 2, rel=0.02)
    again = random_views(20001, (0.6, -1.0), 4.0, torch.Generator().manual_seed(1))
    assert torch.equal(views.azimuth, again.azimuth)


def test_views_may_differ_in_their_colours(egg, faces, paint):
    renderer, greys = Renderer(faces, SIZE), [0.2, 0.5, 0.8]
    together = renderer(egg, torch.stack([paint * grey for grey in greys]), VIEWS).image
    for number, grey in enumerate(greys):
        assert torch.allclose(together[number], renderer(egg, paint * grey, VIEWS).image[number], atol=1e-12)


# --- what cannot be rendered --------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("wrong", "words"),
    [
        (lambda: Renderer(torch.zeros(4, 2, dtype=torch.int64)), r"not torch.int64 of shape \(4, 2\)"),
        (lambda: Renderer(torch.zeros(4, 3)), "not torch.float32"),
        (lambda: Renderer(torch.zeros(4, 3, dtype=torch.int64), 0), "views of 0 x 0 pixels"),
        (lambda: Renderer(torch.tensor([[0, 1, 9]]))(torch.zeros(3, 3), torch.zeros(3, 3), VIEWS), "vertices 0 to 9, but there are 3"),
        (lambda: Renderer(torch.tensor([[0, 1, 2]]))(torch.zeros(3, 3), torch.zeros(3, 4), VIEWS), r"not \(3, 3\) and \(3, 4\)"),
        (lambda: Cameras(torch.zeros(2), torch.zeros(3)), r"not shapes \(2,\) and \(3,\)"),
        (lambda: Cameras(torch.zeros(1), torch.zeros(1), fov=180.0), "opened by 180°"),
        (lambda: random_views(0, (0.0, 0.0), 4.0, torch.Generator()), "0 views"),
    ],
)
def test_what_cannot_be_rendered_is_refused(wrong, words):
    with pytest.raises(BadInput, match=words):
        wrong()


def test_without_torch_the_command_that_installs_it_is_named():
    program = "import sys; sys.modules['torch'] = None; import mechstyle.styling.learned.renderer"
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=False)
    assert done.returncode != 0
    assert "MissingPiece: rendering with gradients needs torch: install it with `pip install 'mechstyle[clip]'`" in done.stderr
