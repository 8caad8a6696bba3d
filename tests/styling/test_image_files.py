"""Picture files as people have them, and as somebody may have made them to do harm."""

import io
import struct
import zlib

import numpy as np
import pytest
from PIL import Image

from mechstyle.errors import BadInput
from mechstyle.styling.drawing.raster import LONGEST, pixels_of, png_of

RAMP = np.linspace(0, 255, 12).astype(np.uint8).reshape(3, 4)


def saved(image, form="png", **options) -> bytes:
    buffer = io.BytesIO()
    image.save(buffer, form, **options)
    return buffer.getvalue()


def with_header(width: int, height: int, body: bytes = b"") -> bytes:
    """A PNG file that says it is so large, in grey of 8 bits."""
    chunks = [(b"IHDR", struct.pack(">IIBBBBB", width, height, 8, 0, 0, 0, 0)), (b"IDAT", zlib.compress(body)), (b"IEND", b"")]
    return b"\x89PNG\r\n\x1a\n" + b"".join(
        struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data)) for kind, data in chunks
    )


def test_a_grey_file_keeps_its_levels():
    assert np.array_equal(pixels_of(saved(Image.fromarray(RAMP)))[..., 0], RAMP)


def test_sixteen_bits_of_grey_are_kept():
    fine = np.arange(12, dtype=np.uint16).reshape(3, 4) * 5461 + 1
    found = pixels_of(saved(Image.fromarray(fine)))
    assert found.dtype == np.uint16
    assert np.array_equal(found[..., 0], fine)


def test_alpha_is_kept_and_left_out_where_all_is_opaque():
    clear = np.dstack([RAMP, RAMP // 2, RAMP, 255 - RAMP])
    assert np.array_equal(pixels_of(saved(Image.fromarray(clear))), clear)
    clear[..., 3] = 255
    assert pixels_of(saved(Image.fromarray(clear))).shape == (3, 4, 3)


@pytest.mark.parametrize("mode", ["1", "L", "P", "RGB", "RGBA", "LA"])
def test_one_picture_has_the_same_pixels_however_it_was_saved(mode):
    image = Image.fromarray(np.where(RAMP > 99, 255, 0).astype(np.uint8)).convert(mode)
    assert np.array_equal(pixels_of(saved(image))[..., 0] > 127, RAMP > 99)
    assert pixels_of(saved(image)).shape == (3, 4, 1)


def test_a_palette_may_be_transparent():
    image = Image.fromarray(np.where(RAMP > 99, 1, 0).astype(np.uint8), "L").convert("P")
    assert np.array_equal(pixels_of(saved(image, transparency=0))[..., -1] > 0, RAMP > 99)


def test_a_photograph_is_turned_as_its_camera_was():
    image = Image.fromarray(np.dstack([RAMP, RAMP, 255 - RAMP]))
    exif = Image.Exif()
    exif[0x0112] = 6  # held upright, to be turned by a quarter
    turned = pixels_of(saved(image, "jpeg", quality=95, subsampling=0, exif=exif))
    assert turned.shape == (4, 3, 3)
    assert np.abs(turned[..., 2].astype(int) - np.rot90(255 - RAMP, -1)).max() < 40


def test_inks_become_screen_colours():
    inks = np.dstack([np.zeros_like(RAMP), *[np.full_like(RAMP, 255)] * 2, np.zeros_like(RAMP)])
    red = pixels_of(saved(Image.fromarray(inks, "CMYK"), "jpeg", quality=95))
    assert red.shape == (3, 4, 3)
    assert red[..., 0].min() > 200
    assert red[..., 1:].max() < 60


def test_of_an_animated_picture_the_first_is_taken():
    frames = [Image.fromarray(RAMP), Image.fromarray(255 - RAMP)]
    assert np.array_equal(pixels_of(saved(frames[0], save_all=True, append_images=frames[1:]))[..., 0], RAMP)


def test_a_large_picture_is_averaged():
    square = np.tile(np.array([[0, 200], [200, 0]], np.uint8), (LONGEST // 4, LONGEST))
    found = pixels_of(saved(Image.fromarray(square)))
    assert found.shape == (LONGEST // 4, LONGEST, 1)
    assert set(np.unique(found)) == {100}


@pytest.mark.parametrize("array", [RAMP, RAMP / 255.0, RAMP.astype(np.uint16) * 257, RAMP[..., None], np.dstack([RAMP] * 3) / 255.0])
def test_an_array_is_a_picture(array):
    found = pixels_of(array)
    assert np.allclose(found[..., 0] / np.iinfo(found.dtype).max, RAMP / 255.0, atol=0.003)


@pytest.mark.parametrize("array", [np.zeros((4, 4, 5)), np.zeros(4), np.zeros((0, 4)), np.full((4, 4), np.nan)])
def test_an_array_that_is_none_is_refused(array):
    with pytest.raises(BadInput, match="picture"):
        pixels_of(array)


@pytest.mark.parametrize(
    "pixels", [RAMP[..., None], np.dstack([RAMP, RAMP]), np.dstack([RAMP, 255 - RAMP, RAMP, RAMP]), RAMP.astype(np.uint16)[..., None] * 250]
)
def test_pixels_survive_as_a_file(pixels):
    assert np.array_equal(pixels_of(png_of(pixels)), pixels)


@pytest.mark.parametrize(
    ("content", "why"),
    [
        (saved(Image.fromarray(np.zeros((64, 64), np.uint8)))[:60], "damaged or was cut off"),
        (saved(Image.effect_noise((64, 64), 90), "jpeg")[:700], "damaged or was cut off"),
        (b"GIF89a" + bytes(40), "no picture that can be read"),
        (b"brick", "no picture that can be read"),
        (with_header(100_000, 100_000), "million"),
        (with_header(9000, 9000, bytes(100)), "9000 x 9000 pixels"),
        (with_header(1, 1, bytes(2)), "at least 2 x 2"),
        (saved(Image.new("RGBA", (8, 8), (9, 9, 9, 0))), "transparent all over"),
    ],
    ids=["cut off", "cut off jpeg", "gif", "text", "bomb", "huge", "one pixel", "nothing"],
)
def test_what_is_no_picture_gets_one_sentence(tmp_path, content, why):
    file = tmp_path / "mine.png"
    file.write_bytes(content)
    with pytest.raises(BadInput, match=why) as refused:
        pixels_of(file)
    assert "mine.png" in str(refused.value)
    assert "\n" not in str(refused.value)


DRAWING = b'<?xml version="1.0"?>\n<!-- mine -->\n<svg xmlns="http://www.w3.org/2000/svg"><image href="/etc/passwd"/></svg>'


@pytest.mark.parametrize(("name", "content"), [("mine.svg", DRAWING), ("mine.png", DRAWING), ("mine.SVGZ", b"\x1f\x8b" + bytes(40))])
def test_an_svg_drawing_is_refused_with_what_to_do(tmp_path, name, content):
    (tmp_path / name).write_bytes(content)
    with pytest.raises(BadInput, match=f"^{name} is an SVG drawing, which is not read: save it as PNG from your drawing program$"):
        pixels_of(tmp_path / name)


def test_a_file_that_is_not_there_is_empty_or_is_a_folder_is_refused(tmp_path):
    (tmp_path / "empty.png").touch()
    for name, why in (("gone.png", "does not exist"), ("empty.png", "is empty"), ("", "is not a file"), ("nul\0l", "opened|exist")):
        with pytest.raises(BadInput, match=why):
            pixels_of(str(tmp_path / name))
