"""Documentation is tested: blocks run, links lead somewhere, commands parse and run, tables follow from the code."""

from __future__ import annotations

import importlib.util
import inspect
import re
import runpy
import shlex
import shutil
import sys
from collections.abc import Iterator
from pathlib import Path
from types import ModuleType
from typing import Any, NamedTuple

import numpy as np
import pytest

import airlight as al
from airlight import reference
from airlight.app import cli
from airlight.stage import SLOTS, STAGES

ROOT = Path(__file__).resolve().parents[1]
DOCS = ROOT / "docs"
WRITTEN = [
    ROOT / "README.md",
    DOCS / "README.md",
    *(page for folder in ("guide", "slots", "decisions") for page in sorted((DOCS / folder).glob("*.md"))),
]
EXAMPLES = sorted((ROOT / "examples").glob("*.py"))
BLOCK = re.compile(r"^```(?P<kind>[^\n]*)\n(?P<text>.*?)^```$", re.MULTILINE | re.DOTALL)
LINK = re.compile(r"\]\((?P<target>[^)\s]+)\)")
FILE = re.compile(r"`(?P<path>[\w.-]+/[\w./-]+\.(?:py|wgsl|md|toml|png))(?::\d+)?`")
# Files of stages from outside the package: slot and name of the stage, and the page that has the text.
OWN = {
    "own_stage": ("shade", "rim", "your-own-stage.md"),
    "edge_overlay": ("passes", "edge_overlay", "own-passes.md"),
    "depth_of_field": ("passes", "depth_of_field", ""),
}
PARSED_ONLY = ("demo", "bench")  # these take the network, or time
SIZE = "96x64"  # of what commands draw
DECISION = ("Status", "Why", "Choice", "Rejected", "How tested")


class Block(NamedTuple):
    """A fenced block of a page, and the line on which its text begins."""

    kind: str
    text: str
    line: int


def named(page: Path) -> str:
    return str(page.relative_to(ROOT))


def blocks(page: Path) -> list[Block]:
    text = page.read_text(encoding="utf-8")
    return [Block(m["kind"].strip(), m["text"], text.count("\n", 0, m.start("text")) + 1) for m in BLOCK.finditer(text)]


def commands(block: Block) -> list[list[str]]:
    """Words of the lines that begin with ``airlight``, without what the shell would take away."""
    lines = block.text.replace("\\\n", " ").splitlines()
    words = [shlex.split(line, comments=True) for line in lines if line.startswith("airlight ")]
    return [line[1 : next((n for n, word in enumerate(line) if word in ("|", ">")), None)] for line in words]


def smaller(words: list[str]) -> list[str]:
    """The same command for a small picture, or for a movie of few of them."""
    if words[0] not in ("render", "movie"):
        return words
    place = words.index("--size") if "--size" in words else len(words)
    slow = ["--fps", "5"] if words[0] == "movie" and "--fps" not in words else []
    return [*words[:place], "--size", SIZE, *words[place + 2 :], *slow]


@pytest.fixture(scope="module")
def files(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Small files by the names that the pages use."""
    import h5py
    import tifffile

    folder = tmp_path_factory.mktemp("files")
    axis = np.linspace(-1, 1, 32, dtype=np.float32)
    ball = np.maximum(0, 1 - (axis[:, None, None] ** 2 + axis[None, :, None] ** 2 + axis[None, None, :] ** 2))
    head = al.Volume((ball * 900).astype(np.int16), spacing=(2, 2, 2), units="mm", anatomical=True, modality="MR")
    al.save(head, folder / "head.nii.gz")
    ct = al.Volume((ball * 2400 - 1000).astype(np.int16), spacing=(2, 2, 2), units="mm", value_unit="HU")
    al.save(ct, folder / "ct.nrrd")
    (ball * 255).astype(np.uint8).tofile(folder / "foot.raw")
    cells = np.stack([ball, ball[::-1] ** 2], axis=1)
    tifffile.imwrite(folder / "cells.ome.tif", (cells * 255).astype(np.uint8), metadata={"axes": "ZCYX"})
    with h5py.File(folder / "simulation.h5", "w") as file:
        file["fields/density"] = ball
    for name in OWN:
        shutil.copy(ROOT / "examples" / f"{name}.py", folder)
    return folder


@pytest.fixture
def here(files: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Folder of its own with the files, as the current one."""
    folder = tmp_path / "page"
    shutil.copytree(files, folder)
    monkeypatch.chdir(folder)
    return folder


@pytest.fixture
def plain_stages() -> Iterator[None]:
    """Forget what pages and examples register."""
    tables = [*STAGES.values(), *reference.TABLES.values()]
    before, modules = [dict(table) for table in tables], set(sys.modules)
    yield
    for table, old in zip(tables, before, strict=True):
        table.clear()
        table.update(old)
    for name in set(sys.modules) - modules:
        if name.startswith(("airlight_plugin_", "docs_page", "example_")):
            del sys.modules[name]


@pytest.mark.parametrize("page", WRITTEN, ids=named)
def test_blocks_run_in_order(page: Path, here: Path, plain_stages: None, capsysbinary: pytest.CaptureFixture[bytes]) -> None:
    module = ModuleType("docs_page")
    sys.modules["docs_page"] = module  # dataclasses look their module up
    for block in blocks(page):
        if block.kind in ("python", "python no-run"):
            code = compile("\n" * (block.line - 1) + block.text, str(page), "exec")
            if block.kind == "python":
                exec(code, module.__dict__)
        elif block.kind == "toml":
            (here / "scene.toml").write_text(block.text)
            assert cli.main(["render", "scene.toml", "-o", "scene.png"]) == 0, capsysbinary.readouterr().err
        elif block.kind == "sh":
            for words in commands(block):
                if words[0] in PARSED_ONLY:
                    cli.make_app(words[0]).parse_args(words, exit_on_error=False, print_error=False)
                    continue
                for name, (slot, stage, _) in OWN.items():  # a process of its own would not know them yet
                    STAGES[slot].pop(stage, None)
                    sys.modules.pop(f"airlight_plugin_{name}", None)
                assert cli.main(smaller(words)) == 0, f"{shlex.join(words)}: {capsysbinary.readouterr().err!r}"


@pytest.mark.parametrize("page", WRITTEN, ids=named)
def test_links_and_files_exist(page: Path) -> None:
    text = BLOCK.sub("", page.read_text(encoding="utf-8"))
    for target in (m["target"] for m in LINK.finditer(text)):
        if target.startswith(("https://", "http://")):
            continue
        path, _, anchor = target.partition("#")
        place = (page.parent / path).resolve() if path else page
        assert place.exists(), f"{named(page)} links to {target}"
        if anchor:
            headings = re.findall(r"^#+ (.*)$", place.read_text(encoding="utf-8"), re.MULTILINE)
            assert anchor in [re.sub(r"[^\w -]", "", h.lower()).replace(" ", "-") for h in headings], f"{named(page)}: {target}"
    for path in (m["path"] for m in FILE.finditer(text)):
        homes = (ROOT, ROOT / "src" / "airlight", page.parent)
        assert any((home / path).exists() for home in homes), f"{named(page)} names {path}"


def options_of(command: str) -> set[str]:
    arguments = cli.make_app(command)[command].assemble_argument_collection()
    return {name for argument in arguments for name in argument.names if name.startswith("-")}


def test_options_that_pages_name_exist_and_all_of_render_are_told() -> None:
    known = {"--help", "--version", "--debug", "--check"}.union(*(options_of(command) for command in cli.COMMANDS))
    for page in WRITTEN:
        text = re.sub(r"^(?:pip|git|python|apt-get) .*$|`pip [^`]*`", "", page.read_text(encoding="utf-8"), flags=re.MULTILINE)
        told = set(re.findall(r"(?<![\w-])--[a-z][a-z-]*", re.sub(r"<!--.*?-->", "", text, flags=re.DOTALL)))
        assert told <= known, f"{named(page)} names {told - known}"
    text = (DOCS / "guide" / "command-line.md").read_text(encoding="utf-8")
    missing = {option for option in options_of("render") if f"`{option}" not in text}
    assert not missing


def test_slot_pages_follow_from_the_classes() -> None:
    spec = importlib.util.spec_from_file_location("build_slots", DOCS / "slots" / "build.py")
    assert spec is not None
    assert spec.loader is not None
    build = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(build)
    assert build.main(["--check"]) == 0, "run python docs/slots/build.py"
    pages = {page.stem for page in (DOCS / "slots").glob("*.md")}
    assert pages == set(SLOTS)
    for slot in SLOTS:
        page = (DOCS / "slots" / f"{slot}.md").read_text(encoding="utf-8")
        assert page.count("<!-- made by build.py") == 2
        for heading in ("## Contract", "## Laws", "## Stages", "## Example"):
            assert heading in page, f"{slot} has no {heading}"


def test_every_stage_is_told_in_the_guide() -> None:
    text = (DOCS / "guide" / "scenes-and-looks.md").read_text(encoding="utf-8")
    for slot in al.Look.__dataclass_fields__:
        row = next(line for line in text.splitlines() if line.startswith(f"| [{slot}]"))
        own = {name for name, cls in STAGES[slot].items() if cls.__module__.startswith("airlight.")}
        told = set(re.findall(r"`(\w+)`", row))
        assert told == own - {"zero", "unlit"}, slot


def test_formats_are_those_of_the_readers() -> None:
    from airlight.io.formats import FAMILIES

    table = (DOCS / "guide" / "reading-files.md").read_text(encoding="utf-8").partition("## Orientation")[0]
    for family in FAMILIES.values():
        assert family.extensions[0] in table or family.title in table, family.title
        for extension in family.writes:
            assert f"`{extension}`" in table or f"`.ome{extension}`" in table
        assert not family.extra or f"airlight[{family.extra}]" in table


def test_extras_that_pages_name_exist() -> None:
    import tomllib

    extras = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]["optional-dependencies"]
    for page in WRITTEN:
        for named_extras in re.findall(r"airlight\[([\w,]+)\]", page.read_text(encoding="utf-8")):
            assert set(named_extras.split(",")) <= set(extras), named(page)


def test_make_targets_that_pages_name_exist() -> None:
    targets = set(re.findall(r"^([\w-]+):", (ROOT / "Makefile").read_text(), re.MULTILINE))
    for page in WRITTEN:
        told = re.findall(r"^make (\w+)|`make (\w+)`", page.read_text(encoding="utf-8"), re.MULTILINE)
        assert {a or b for a, b in told} <= targets, named(page)


def test_decisions_have_their_parts() -> None:
    pages = sorted((DOCS / "decisions").glob("[0-9]*.md"))
    assert [int(page.name[:4]) for page in pages] == list(range(1, len(pages) + 1))
    listed = (DOCS / "README.md").read_text(encoding="utf-8")
    for page in pages:
        text = page.read_text(encoding="utf-8")
        for part in DECISION:
            assert f"**{part}" in text or f"## {part}" in text, f"{page.name} has no {part}"
        assert f"decisions/{page.name}" in listed, f"docs/README.md does not list {page.name}"


@pytest.mark.parametrize("name", al.__all__)
def test_public_names_have_docstrings(name: str) -> None:
    thing: Any = getattr(al, name)
    assert (thing.__doc__ or "").strip()
    if inspect.isclass(thing):
        for member, value in vars(thing).items():
            if not member.startswith("_") and (inspect.isfunction(value) or isinstance(value, property)):
                assert (inspect.getdoc(value) or "").strip(), f"{name}.{member}"


# -- examples


def example(path: Path) -> ModuleType:
    spec = importlib.util.spec_from_file_location(f"example_{path.stem}", path)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    sys.modules[spec.name] = module
    spec.loader.exec_module(module)
    return module


@pytest.mark.parametrize("path", EXAMPLES, ids=lambda path: path.stem)
def test_examples_say_what_you_should_see(path: Path, plain_stages: None) -> None:
    assert "You should see" in (example(path).__doc__ or "")


@pytest.mark.parametrize("name", OWN)
def test_stages_of_ones_own_are_short_and_the_text_of_the_guide(name: str) -> None:
    text = (ROOT / "examples" / f"{name}.py").read_text(encoding="utf-8")
    assert len(text.splitlines()) <= 40
    page = OWN[name][2]
    if page:
        first = next(b for b in blocks(DOCS / "guide" / page) if b.kind == "python")
        assert first.text == text, f"copy examples/{name}.py into docs/guide/{page}"


def test_fly(tmp_path: Path, plain_stages: None) -> None:
    fly = example(ROOT / "examples" / "fly.py")
    try:
        al.samples.fetch(fly.VOLUME)
    except al.FileError as error:
        pytest.skip(f"the sample is not cached and could not be fetched: {error}")
    image = fly.main(str(tmp_path / "fly.png"), 80, 60)
    assert (tmp_path / "fly.png").stat().st_size > 1000
    covered = float((image.rgba[..., 3] > 0.5).mean())
    assert 0.1 < covered < 0.6


def test_turntable(tmp_path: Path, plain_stages: None) -> None:
    images = example(ROOT / "examples" / "turntable.py").main(str(tmp_path), 48, 36)
    assert len(list(tmp_path.glob("turn-*.png"))) == len(images) == 8
    assert all((image.rgba[..., 3] > 0.1).any() for image in images)


def test_own_stage_draws(tmp_path: Path, plain_stages: None, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    runpy.run_path(str(ROOT / "examples" / "own_stage.py"), run_name="__main__")
    assert (tmp_path / "rim.png").stat().st_size > 1000
