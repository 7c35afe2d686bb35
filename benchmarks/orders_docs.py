"""Plots and pictures of docs/guide/classification-orders.md, and the numbers beneath them, out of one run of ``orders.py``."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import numpy as np
from common import errors, table
from orders import ORDERS, at, in_order, orbital, random_green, scene_of
from PIL import Image

import airlight as al
from airlight import reference

COLOURS = dict(zip(ORDERS, ("#8c6bb1", "#d95f0e", "#7fcdbb", "#1d91c0", "#08306b"), strict=True))
PICTURE_STEPS = (4.0, 2.0, 1.0)  # voxels of the orbital
PICTURE_PX = 240
MADE = re.compile(r"(<!-- made by orders\.py: (\w+) -->\n).*?(<!-- end -->)", re.DOTALL)


def write_docs(renderer: al.Renderer, found: list[dict[str, Any]], clock: str, folder: Path) -> None:
    """Write plots and pictures into a folder, and tables into the page beside it."""
    folder.mkdir(parents=True, exist_ok=True)
    for case in found:
        draw_plots(case, clock, folder / f"{re.sub('[^a-z]+', '-', case['case'].lower())}.png")
    parts = {"pictures": pictures(renderer, folder), "errors": error_table(found, clock), "steps": step_table(found)}
    page = folder.parent / "classification-orders.md"
    text = page.read_text(encoding="utf-8")
    page.write_text(MADE.sub(lambda match: f"{match[1]}{parts[match[2]]}\n{match[3]}", text), encoding="utf-8")


def draw_plots(case: dict[str, Any], clock: str, target: Path) -> None:
    """Error beside samples, error beside time, and change of the mean colour beside the step."""
    import matplotlib as mpl

    mpl.use("Agg")
    from matplotlib import pyplot as plt
    from matplotlib.ticker import LogLocator, NullFormatter, StrMethodFormatter

    figure, axes = plt.subplots(1, 3, figsize=(11, 3.4), layout="constrained")
    figure.suptitle(case["case"])
    axes[0].set(xlabel="samples a voxel", ylabel="RMSE")
    axes[1].set(xlabel=f"time of a frame ({clock}) [ms]", ylabel="RMSE")
    axes[2].set(xlabel="step [voxel]", ylabel="change of mean colour [%]")
    for order, rows in case["orders"].items():
        style = {"color": COLOURS[order], "marker": ".", "label": order}
        rmse = [row["rmse"] for row in rows]
        axes[0].loglog([1 / row["step"] for row in rows], rmse, **style)
        axes[1].loglog([row[f"{clock}_ms"]["median"] for row in rows], rmse, **style)
        axes[2].loglog([row["step"] for row in rows[:-1]], [max(100 * row["change"], 1e-4) for row in rows[:-1]], **style)
    for axis in axes:
        axis.xaxis.set_major_locator(LogLocator(subs=(1, 2, 5)))
        axis.xaxis.set_major_formatter(StrMethodFormatter("{x:g}"))
        axis.xaxis.set_minor_formatter(NullFormatter())
    for axis in (axes[0], axes[2]):
        axis.set_xticks([0.25, 0.5, 1, 2, 4])
    axes[0].legend(fontsize=7)
    figure.savefig(target, dpi=80)
    plt.close(figure)
    with Image.open(target) as image:
        packed = image.convert("RGB").quantize(32, dither=Image.Dither.NONE)
    packed.save(target, optimize=True)


def pictures(renderer: al.Renderer, folder: Path) -> str:
    """Draw the orbital in all orders with few steps, and return a table of pictures with their errors."""
    scene, size = scene_of(orbital(), random_green(orbital())), (PICTURE_PX, PICTURE_PX)
    truth = reference.converged(scene, size, step=1 / 16)
    save(truth.rgba, folder / "orbital-converged.png")
    lines = ["| order | " + " | ".join(f"step of {step:g} voxels" for step in PICTURE_STEPS) + " |"]
    lines += ["| --- |" + " --- |" * len(PICTURE_STEPS)]
    for order in ORDERS:
        staged, driver = in_order(scene, order)
        cells = []
        for step in PICTURE_STEPS:
            image = renderer.render(staged, size, step=step, driver=driver)
            name = f"orbital-{re.sub('[^a-z]+', '-', order)}-{step:g}.png"
            save(image.rgba, folder / name)
            cells.append(f"![{order}, {step:g}](orders/{name})<br>RMSE {errors(image.rgba, truth.rgba)['rmse']:.4f}")
        lines.append(f"| {order} | " + " | ".join(cells) + " |")
    return "\n".join([*lines, "", "![converged](orders/orbital-converged.png)", "", "The converged reference."])


def save(rgba: Any, target: Path) -> None:
    """Write a picture over black with few colours."""
    linear = np.clip(np.asarray(rgba, dtype=np.float64)[..., :3], 0, 1)
    srgb = np.where(linear <= 0.0031308, 12.92 * linear, 1.055 * np.maximum(linear, 1e-9) ** (1 / 2.4) - 0.055)
    image = Image.fromarray(np.round(255 * srgb).astype(np.uint8))
    image.quantize(96, method=Image.Quantize.MEDIANCUT, dither=Image.Dither.FLOYDSTEINBERG).save(target, optimize=True)


def error_table(found: list[dict[str, Any]], clock: str) -> str:
    """Table of errors at one sample a voxel and at two, with times."""
    rows = []
    for case in found:
        for order, order_rows in case["orders"].items():
            one, two = at(order_rows, 1.0), at(order_rows, 0.5)
            rows.append(
                {
                    "case": case["case"],
                    "order": order,
                    "RMSE, 1 a voxel": f"{one['rmse']:.4f}",
                    f"{clock} [ms]": round(one[f"{clock}_ms"]["median"]),
                    "RMSE, 2 a voxel": f"{two['rmse']:.4f}",
                    f"{clock} [ms], 2": round(two[f"{clock}_ms"]["median"]),
                }
            )
    return table(rows)


def step_table(found: list[dict[str, Any]]) -> str:
    """Table of how much the mean colour changes from the step of 1/4 voxel."""
    rows = []
    for case in found:
        for order, order_rows in case["orders"].items():
            changes = {f"step {row['step']:g}": f"{100 * row['change']:.2f} %" for row in order_rows if row["step"] > 0.25}
            rows.append({"case": case["case"], "order": order} | changes)
    return table(rows)
