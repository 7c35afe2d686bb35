"""What regions of labels cost: pictures with labels beside the same pictures without, shaded, in turns on one device.

116 labels of a human brain, 724 of a macaque's, and 300,000 made ids, each over its image; all regions are tinted, so that rays
end where they end without labels. Two functions of each: an opaque one, whose rays end in the first regions that they meet,
and a haze, whose rays go through all of them. What counts is the quotient of the least times. Then what a change of a set of
labels costs a renderer.
"""

from __future__ import annotations

import sys
from collections.abc import Iterator
from typing import Any

import numpy as np
from common import arguments, by_both_clocks, described, parsed, side_by_side, table, write_json
from volumes import cropped, data_folder, haze, noisy_cloud, real_volume

import airlight as al

MOST = {"few": 1.5, "many": 3.0}
MANY = 300_000


def main(argv: list[str] | None = None) -> int:
    """Measure, print, write; 1 when a picture costs more than it may."""
    parser = arguments(__doc__, "labels", repeats=7, size=512, step=1.0, clock="what decides: cpu where others are busy")
    options = parsed(parser, argv, size=48, repeats=1)
    with al.Renderer(options.device) as renderer:
        renderer.render(al.Scene(noisy_cloud(8)), (8, 8))
        about = described(renderer._device, options)
        costs = [cost(renderer, *case, options) for case in cases(options.quick)]
        print(table([shown(row, options.clock) for row in costs]))
        changes = [change(renderer, name, volume, labels, options) for name, volume, labels, _ in images(options.quick)]
        print("\n" + table(changes))
    passed = all(row["least"][options.clock] <= row["most"] for row in costs)
    verdict = "PASS" if passed else "FAIL"
    print(f"\n{verdict}: at most {MOST['few']} times the picture without labels, {MOST['many']} with {MANY:,}")
    write_json(options.out, about | {"costs": costs, "changes": changes, "passes": passed})
    return 0 if passed or options.quick else 1


def images(quick: bool) -> Iterator[tuple[str, al.Volume, al.Labels, float]]:
    """Images with their labels, and how many times the cost without them these may have."""
    folder = data_folder() / "labels"
    head = real_volume("ch2")
    if quick:
        head = cropped(head, 24)
    pairs = [("brain", head, folder / "aal.nii.gz")]
    if (folder / "inia19-t1-brain.nii.gz").is_file():
        pairs.append(("macaque", al.open(folder / "inia19-t1-brain.nii.gz"), folder / "inia19-NeuroMaps.nii.gz"))
    for name, volume, path in pairs:
        if path.is_file():
            labels = al.open(path)
            if quick:
                volume, labels = cropped(volume, 24), cropped(labels, 24)
            yield name, volume, al.Labels(labels), MOST["few"]
        else:
            print(f"{path.name} is not there (AIRLIGHT_DATA names the folder of real volumes): left out", file=sys.stderr)
    yield "made", head, al.Labels(al.Volume(made_ids(head.size), world_from_index=head.world_from_index)), MOST["many"]


def made_ids(size: tuple[int, int, int], count: int = MANY, seed: int = 1) -> np.ndarray[Any, Any]:
    """Blocks of about as many ids as asked for, spread over 32 bits, each shifted against its neighbours."""
    rng = np.random.default_rng(seed)
    side = max(1.0, (np.prod(size) / count) ** (1 / 3))
    z, y, x = np.indices(size[::-1], dtype=np.int32)
    k = np.int64(z / side)
    j = np.int64((y + side * 0.5 * (k % 2)) / side)
    i = np.int64((x + side * 0.37 * (j % 3)) / side)
    number = (k * (j.max() + 1) + j) * (i.max() + 1) + i
    ids = rng.permutation(np.linspace(1, 2**32 - 1, int(number.max()) + 1).astype(np.uint32))
    return ids[number]


def cases(quick: bool) -> Iterator[tuple[str, str, al.Volume, al.TransferFunction, al.Labels, float]]:
    """Images and functions."""
    for name, volume, labels, most in images(quick):
        opaque = al.first_picture(volume).layers[0].transfer
        assert isinstance(opaque, al.TransferFunction)
        for what, function in (("opaque", opaque), ("haze", haze(volume))):
            yield name, what, volume, function, labels, most


def scene(volume: al.Volume, function: al.TransferFunction, labels: al.Labels | None) -> al.Scene:
    """A shaded view from the side."""
    return al.Scene(layers=[al.Layer(volume, function, al.Look(), labels)], camera="left")


def cost(
    renderer: al.Renderer,
    name: str,
    what: str,
    volume: al.Volume,
    function: al.TransferFunction,
    labels: al.Labels,
    most: float,
    options: Any,
) -> dict[str, Any]:
    """Draw with labels and without, in turns."""
    size = (options.size, options.size)
    scenes = {"plain": scene(volume, function, None), "labelled": scene(volume, function, labels)}
    measured = side_by_side(
        {key: lambda made=made: renderer.render(made, size, step=options.step) for key, made in scenes.items()},
        options.repeats,
        2,
    )
    plain, labelled = measured["plain"], measured["labelled"]
    samples = {key: one.result.stats["samples"] for key, one in measured.items()}
    alike = float(np.abs(plain.result.rgba[..., 3] - labelled.result.rgba[..., 3]).max())
    return {
        "image": name,
        "function": what,
        "labels": len(labels.ids()),
        "plain": plain.summary(),
        "labelled": labelled.summary(),
        "samples": samples,
        "opacities differ by": alike,
        **by_both_clocks(labelled, plain),
        # The least times of both: what else the machine does counts for neither.
        "least": {"wall": min(labelled.wall) / min(plain.wall), "cpu": min(labelled.cpu) / min(plain.cpu)},
        "most": most,
    }


def shown(row: dict[str, Any], clock: str) -> dict[str, Any]:
    """Columns of the table that is printed."""
    return {
        "image": row["image"],
        "function": row["function"],
        "labels": row["labels"],
        "million samples": row["samples"]["labelled"] / 1e6,
        "plain, ms": row["plain"][f"{clock}_ms"]["min"],
        "labelled, ms": row["labelled"][f"{clock}_ms"]["min"],
        f"times as long ({clock})": row["least"][clock],
        "median of turns": row[clock]["median"],
        "at most": row["most"],
    }


def change(renderer: al.Renderer, name: str, volume: al.Volume, labels: al.Labels, options: Any) -> dict[str, Any]:
    """Hide the background, then every other region: milliseconds beside those of the same picture drawn again."""
    function = al.first_picture(volume).layers[0].transfer
    assert isinstance(function, al.TransferFunction)
    size = (options.size, options.size)
    every_other = labels.ids()[::2].tolist()
    jobs = {
        "drawn again": lambda: renderer.render(scene(volume, function, shown_before), size, step=options.step),
        "changed": lambda: renderer.render(scene(volume, function, labels.hide(every_other)), size, step=options.step),
    }
    shown_before = labels.hide(every_other)
    measured = side_by_side(jobs, options.repeats)
    summary = {key: one.summary()["wall_ms"]["median"] for key, one in measured.items()}
    upload = measured["changed"].result.stats["milliseconds"].get("upload", 0.0)
    return {
        "image": name,
        "labels": len(labels.ids()),
        **{f"{key}, ms": ms for key, ms in summary.items()},
        "of it upload, ms": upload,
    }


if __name__ == "__main__":
    sys.exit(main())
