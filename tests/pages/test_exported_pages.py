"""What goes into a page and what does not, how the volume is stored, and what is refused before anything is written."""

from __future__ import annotations

import base64
import hashlib
import html.parser
import json
import re
import zlib
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import airlight as al
from airlight import api
from airlight.pages.carried import plain_struct
from airlight.pages.exporting import Exported
from airlight.pages.page import escaped_json
from airlight.pages.stored import decoded, store
from airlight.reconstruction.levels import averaged
from airlight.rendering.image import Image
from airlight.shader.layout import Struct

EVIL = "</title></script><script>alert('x')</script><!-- \u2028 & \"<img src=x onerror=alert(1)>"
WHITE = (1.0, 1.0, 1.0)
FUNCTION = al.TransferFunction([(100, WHITE, 0.0), (900, (1, 0.5, 0.2), 0.8)])


def source(name: str) -> str:
    return (Path(al.__file__).parent / "wgsl" / name).read_text(encoding="utf-8")


class Read(html.parser.HTMLParser):
    """Elements of a page with their attributes and texts, as a browser reads them."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.is_open = False
        self.elements: list[tuple[str, dict[str, str | None], list[str]]] = []
        self.feed(text)
        self.close()

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.elements.append((tag, dict(attrs), []))
        self.is_open = True

    def handle_endtag(self, tag: str) -> None:
        self.is_open = False

    def handle_data(self, data: str) -> None:
        if self.is_open:
            self.elements[-1][2].append(data)

    def all(self, tag: str) -> list[tuple[dict[str, str | None], str]]:
        return [(attributes, "".join(texts)) for name, attributes, texts in self.elements if name == tag]


@pytest.fixture
def undrawn(monkeypatch: pytest.MonkeyPatch) -> list[Any]:
    """Still pictures are grey, and nothing is drawn."""
    asked: list[Any] = []

    def render(scene: al.Scene, size: tuple[int, int], **arguments: Any) -> Image:
        asked.append((scene, size, arguments))
        return Image(np.full((size[1], size[0], 4), 0.5, np.float32), np.zeros((size[1], size[0]), np.float32), (0, 0, 0))

    monkeypatch.setattr(api, "render", render)
    return asked


def blob(n: int = 24, dtype: Any = np.int16, **told: Any) -> al.Volume:
    axis = np.linspace(-1, 1, n)
    values = 1000 * np.exp(-2 * (axis[:, None, None] ** 2 + axis[:, None] ** 2 + axis**2))
    return al.Volume(values.astype(dtype), **told)


def scene_of(volume: al.Volume, function: Any = FUNCTION, **given: Any) -> al.Scene:
    look = given.pop("look", al.Look())
    return al.Scene(volume, transfer=function, camera=given.pop("camera", "iso"), look=look, **given)


def written(tmp_path: Path, what: Any, **options: Any) -> tuple[Exported, str, Read]:
    told = al.export(what, tmp_path / "page.html", size=(32, 24), **options)
    text = told.path.read_text(encoding="utf-8")
    assert len(text.encode()) == told.bytes
    return told, text, Read(text)


# -- the file


def test_titles_are_texts_and_data_cannot_end_their_element(tmp_path: Path, undrawn: list[Any]) -> None:
    volume = blob(units=EVIL[:60], value_unit=EVIL[:60])
    _, text, page = written(tmp_path, scene_of(volume), title=EVIL)
    assert len(page.all("script")) == text.count("<script") == text.count("</script>") == 3
    assert len(page.all("img")) == 1
    assert page.all("title")[0][1] == page.all("h1")[0][1] == EVIL
    data = json.loads(page.all("script")[0][1])
    assert data["units"] == EVIL[:60]
    assert EVIL[:60] in page.all("p")[-1][1]


def test_half_letters_are_question_marks(tmp_path: Path, undrawn: list[Any]) -> None:
    _, _, page = written(tmp_path, scene_of(blob(units="\udcb5m")), title="\ud800 head")
    assert page.all("h1")[0][1] == "? head"
    assert "?m; values" in page.all("p")[-1][1]


@given(
    st.recursive(st.text() | st.floats(allow_nan=False, allow_infinity=False), lambda more: st.dictionaries(st.text(), more))
)
def test_json_in_an_element_holds_no_marks(data: Any) -> None:
    text = escaped_json(data)
    assert text.isascii()
    assert not set("<>&") & set(text)
    assert json.loads(text) == data


def test_the_policy_lets_in_this_script_and_this_style_alone(tmp_path: Path, undrawn: list[Any]) -> None:
    _, text, page = written(tmp_path, scene_of(blob()))
    (policy,) = (a["content"] for a, _ in page.all("meta") if a.get("http-equiv") == "Content-Security-Policy")
    rules = dict(rule.split(" ", 1) for rule in str(policy).split("; "))
    for rule, element in (("script-src", page.all("script")[1][1]), ("style-src", page.all("style")[0][1])):
        digest = base64.b64encode(hashlib.sha256(element.encode()).digest()).decode()
        assert rules[rule] == f"'sha256-{digest}'"
    assert rules["default-src"] == rules["base-uri"] == rules["form-action"] == "'none'"
    assert not re.search(r"https?://(?!www\.w3\.org/2000/svg)|\bimport\b *[({\"']|innerHTML|\bon\w+ *=\"", text)
    assert all(str(a[name]).startswith("data:image/jpeg;base64,") for a, _ in page.all("img") for name in a if name == "src")


def test_nothing_of_a_header_is_in_the_file(tmp_path: Path, undrawn: list[Any]) -> None:
    source = tmp_path / "Jane-Doe-1970.nrrd"
    al.save(blob(name="Jane Doe", channel_names=("Doe-left",), modality="CT", units="mm", value_unit="HU"), source)
    _, text, page = written(tmp_path, scene_of(al.open(source)))
    assert not re.search(r"jane|doe-|1970|nrrd", text, re.IGNORECASE)
    assert str(tmp_path) not in text
    assert "mm; values" in page.all("p")[-1][1]


def test_a_page_holds_programs_layout_volume_and_picture(tmp_path: Path, undrawn: list[Any]) -> None:
    told, _, page = written(tmp_path, scene_of(blob()), title="A blob")
    data = json.loads(page.all("script")[0][1])
    assert told.is_editable
    assert not list(told.notes)
    assert data["transfer"]["points"][1] == [900, [1, 0.5, 0.2], 0.8]
    march = data["programs"]["march"]
    assert "fn main(" in march["wgsl"]
    assert "fn pitch() -> u32 { return params.diagonals + 1u; }" in source("passes/slab_table.wgsl")
    assert "{ return uniforms.slab_table.diagonals + 1u; }" in data["programs"]["table"]["wgsl"]
    assert not any("//" in program["wgsl"] or ".wgsl" in program["wgsl"] for program in data["programs"].values())
    assert {one["holds"]["kind"] for one in march["bindings"]} >= {
        "volume",
        "function",
        "slabs",
        "sampler",
        "uniforms",
        "bytes",
    }
    texels = zlib.decompress(base64.b64decode(page.all("script")[2][1]), -15)
    assert len(texels) == 24**3 * data["volume"]["bits"] // 8
    (scene, size, arguments) = undrawn[0]
    assert size == (32, 24)
    assert scene.layers[0].volume.size == (24, 24, 24)
    assert arguments["driver"].name == "march"


def test_a_page_of_128_voxels_in_8_bits_is_at_most_3_megabytes(tmp_path: Path, undrawn: list[Any]) -> None:
    # As noisy as scanners are: four of eight bits.
    noisy = blob(128, np.float32).array + np.random.default_rng(3).normal(0, 20, (128,) * 3)
    told, _, _ = written(tmp_path, scene_of(al.Volume(noisy)), bits=8)
    assert (told.bits, told.size) == (8, (128, 128, 128))
    assert told.bytes <= 3e6


@given(data=st.data())
def test_layouts_tell_the_places_of_dtypes(data: st.DataObject) -> None:
    from airlight.shader.layout import LEAF_TYPES, make_struct

    kinds = st.lists(st.sampled_from(sorted(LEAF_TYPES)), min_size=1, max_size=5)
    inner = make_struct("Inner", [(f"i{n}", kind, "") for n, kind in enumerate(data.draw(kinds))])
    members: list[tuple[str, str | Struct, str]] = [(f"m{n}", kind, "") for n, kind in enumerate(data.draw(kinds))]
    struct = make_struct("Outer", [*members, ("inner", inner, "")])
    plain = plain_struct(struct)
    assert plain["size"] == struct.dtype.itemsize
    for told, fields in ((plain, struct.dtype.fields), (plain["members"][-1]["struct"], inner.dtype.fields)):
        assert fields is not None
        assert {m["name"]: m["offset"] for m in told["members"]} == {name: field[1] for name, field in fields.items()}


# -- the volume


@given(
    shape=st.tuples(*[st.integers(1, 9)] * 3),
    boxes=st.tuples(*[st.integers(1, 9)] * 3),
)
def test_means_over_boxes_keep_the_mean(shape: tuple[int, int, int], boxes: tuple[int, int, int]) -> None:
    boxes = tuple(min(m, n) for m, n in zip(boxes, shape, strict=True))  # type: ignore[assignment]
    grid = np.random.default_rng(1).integers(0, 200, shape)
    made = averaged(grid, boxes)
    assert made.shape == boxes
    np.testing.assert_allclose(made.mean(dtype=np.float64), grid.mean(), rtol=1e-5)
    if all(n % m == 0 for n, m in zip(shape, boxes, strict=True)):
        split = [x for n, m in zip(shape, boxes, strict=True) for x in (m, n // m)]
        np.testing.assert_allclose(made, grid.reshape(split).mean(axis=(1, 3, 5)), rtol=1e-5)


@pytest.mark.parametrize(
    ("dtype", "bits", "format", "error"),
    [
        (np.uint8, None, "r8unorm", 0.0),
        (np.int8, None, "r8unorm", 0.0),
        (bool, None, "r8unorm", 0.0),
        (np.int16, None, "r16float", 0.0),
        (np.int16, 8, "r8unorm", 1000 / 510),
        (np.float32, None, "r16float", 500 * 2.0**-12),
        (np.uint8, 16, "r16float", 0.0),
    ],
)
def test_what_bits_cost_is_told(dtype: Any, bits: int | None, format: str, error: float) -> None:
    values = (blob(9, np.float64).array / (1 if np.dtype(dtype).itemsize > 1 else 8)).astype(dtype)
    stored = store(scene_of(al.Volume(values)).layers[0], None, bits, lambda *_: None)
    assert stored.encoding.format == format
    assert stored.error == pytest.approx(error, rel=0.02)
    off = np.abs(stored.volume.array - values.astype(np.float64)).max()
    assert off <= stored.error * 1.001 + 1e-4
    assert (stored.volume.array == decoded(stored.texels, stored.encoding)).all()


def test_a_smaller_volume_lies_where_the_larger_one_did() -> None:
    rng = np.random.default_rng(2)
    affine = np.eye(4)
    affine[:3] = rng.normal(size=(3, 4))
    volume = al.Volume(rng.normal(size=(10, 31, 40)), world_from_index=affine, units="mm")
    stored = store(scene_of(volume).layers[0], 16, None, lambda *_: None)
    assert max(stored.volume.size) == 16
    np.testing.assert_allclose(stored.volume.corners_world(cells=True), volume.corners_world(cells=True), atol=1e-9)
    told = Exported(Path("x"), 0, stored.volume.size, volume.size, 16, stored.error, "HU", True)
    assert [note.split()[0] for note in told.notes] == ["the", "values"]


# -- what is refused


def deep(**look: Any) -> al.Scene:
    return scene_of(blob(8), look=al.Look(**look))


REFUSED = {
    "two layers": (al.Scene(layers=[al.Layer(blob(8)), al.Layer(blob(8))]), {}, "scene.layers"),
    "channels": (al.Scene(al.Volume(np.zeros((2, 4, 4, 4), np.uint8)), transfer=[FUNCTION, FUNCTION]), {}, "2 channels"),
    "labels": (al.Scene(layers=[al.Layer(blob(8), labels=np.ones((8, 8, 8), np.uint8))]), {}, "labels"),
    "meshes": (scene_of(blob(8), meshes=[al.Mesh([(0, 0, 0), (1, 0, 0), (0, 1, 0)], [(0, 1, 2)])]), {}, "scene.meshes"),
    "environment": (scene_of(blob(8), background=al.Environment.sky()), {}, "scene.background"),
    "camera": (scene_of(blob(8), camera=al.Camera.dome(eye=(0, -9, 0), target=(0, 0, 0))), {}, "camera 'dome'"),
    "openness": (deep(visibility="ambient_occlusion"), {}, "look.visibility 'ambient_occlusion'"),
    "gradients": (deep(gradient="precomputed"), {}, "look.gradient 'precomputed'"),
    "levels": (deep(field="levels"), {}, "look.field 'levels'"),
    "tones": (deep(tone="reinhard"), {}, "look.tone 'reinhard'"),
    "camera's place": (deep(integrate="depth_shaded_mip"), {}, "follows the camera"),
    "slices": (deep(), {"driver": "slices"}, "driver 'slices'"),
    "nothing left": (scene_of(blob(8), clips=[al.Clip.sphere(center=(99, 99, 99), radius=1)]), {}, "shows nothing"),
    "gaps": (al.Scene(al.Volume(np.where(np.eye(6, dtype=bool), np.nan, np.ones((6, 6, 6))))), {}, "empty samples"),
    "bits": (deep(), {"bits": 12}, "bits is 12"),
    "voxels": (deep(), {"voxels": 1}, "voxels is 1"),
    "half voxels": (deep(), {"voxels": 64.5}, "voxels is 64.5, must be a whole number"),
    "title": (deep(), {"title": "x" * 999}, "title"),
}


@pytest.mark.parametrize("case", REFUSED)
def test_what_a_page_cannot_draw_is_refused_before_anything_is_written(case: str, tmp_path: Path, undrawn: list[Any]) -> None:
    what, options, words = REFUSED[case]
    target = tmp_path / "page.html"
    target.write_text("before")
    with pytest.raises(al.AirlightError, match=re.escape(words)):
        al.export(what, target, size=(16, 16), **options)
    assert target.read_text() == "before"
    assert [file.name for file in tmp_path.iterdir()] == ["page.html"]
    assert not undrawn


@pytest.mark.parametrize(("name", "words"), [("page.txt", ".html"), ("none/page.html", "folder is not there"), ("", ".html")])
def test_only_pages_where_there_is_a_folder(name: str, words: str, tmp_path: Path) -> None:
    with pytest.raises(al.FileError, match=re.escape(words)):
        al.export(deep(), tmp_path / name)


@pytest.mark.parametrize(
    ("look", "function", "is_editable"),
    [
        ({}, FUNCTION, True),
        ({"integrate": "mip"}, FUNCTION, True),
        ({"integrate": al.integrate.FirstHit(iso=300)}, FUNCTION, True),
        ({"integrate": "first_hit"}, FUNCTION, False),  # its value is that of the function
        ({}, al.TransferFunction.from_surfaces([al.Surface(300, "white")]), False),
    ],
)
def test_functions_are_edited_where_nothing_else_follows_them(
    look: dict[str, Any], function: Any, is_editable: bool, tmp_path: Path, undrawn: list[Any]
) -> None:
    told, _, page = written(tmp_path, scene_of(blob(8), function, look=al.Look(**look)))
    assert told.is_editable == is_editable
    assert (json.loads(page.all("script")[0][1])["transfer"] is not None) == is_editable
    assert bool(list(told.notes)) == (not is_editable)
