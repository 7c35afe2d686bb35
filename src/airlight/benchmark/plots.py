"""Time against error, a panel for each scene: what costs what (Pareto)."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from ..errors import MissingExtraError
from ..files import written

COLUMNS = 3
COLOURS = ("#08519c", "#6baed6", "#d95f0e", "#8c6bb1")
MARKS = "os^v"
LEAST_LEVEL = 1e-3  # of an error that is drawn, in levels of 255: what is less is nothing


def load_matplotlib() -> Any:
    """Import what draws figures to files.

    Raises
    ------
    MissingExtraError
        Where matplotlib is not installed.
    """
    try:
        from matplotlib.figure import Figure
    except ImportError as error:
        raise MissingExtraError("plots", "need matplotlib", 'pip install "airlight[plots]"') from error
    return Figure


def write_plots(results: dict[str, Any], path: Path) -> None:
    """Write the figure of what ``airlight bench`` measured: medians of whole frames, root mean square errors.

    Each line is a renderer, each point a step, named beside the line of airlight's own way. The nearer to the lower left, the
    better; what lies above and to the right of another point is never worth its time.

    Raises
    ------
    MissingExtraError
        Where matplotlib is not installed.
    FileError
        When it cannot be written.
    """
    figure_class = load_matplotlib()
    from matplotlib.ticker import LogLocator, NullLocator, StrMethodFormatter

    rows = [row for row in results["rows"] if "failed" not in row]
    scenes, renderers = (list(dict.fromkeys(row[key] for row in rows)) for key in ("scene", "renderer"))
    lines = max(1, -(-len(scenes) // COLUMNS))
    figure = figure_class(figsize=(4 * COLUMNS, 3.4 * lines + 0.6), layout="constrained")
    panels = figure.subplots(lines, COLUMNS, squeeze=False).ravel()
    for panel, scene in zip(panels, scenes, strict=False):
        for number, renderer in enumerate(renderers):
            points = [row for row in rows if (row["scene"], row["renderer"]) == (scene, renderer)]
            if points:
                _draw_line(panel, points, renderer, COLOURS[number % len(COLOURS)], MARKS[number % len(MARKS)], number == 0)
        panel.set(xscale="log", yscale="log", title=scene, xlabel="frame [ms]", ylabel="error, rms [1/255]")
        panel.grid(True, color="0.9", linewidth=0.6)
        panel.margins(0.15)
        for axis in (panel.xaxis, panel.yaxis):
            axis.set_major_locator(LogLocator(subs=(1, 2, 5)))
            axis.set_major_formatter(StrMethodFormatter("{x:g}"))
            axis.set_minor_locator(NullLocator())
    for panel in panels[len(scenes) :]:
        panel.set_axis_off()
    named = {name: line for panel in panels for line, name in zip(*panel.get_legend_handles_labels(), strict=True)}
    figure.legend(list(named.values()), list(named), loc="outside lower center", ncols=4, frameon=False)
    plan, adapter = results["plan"], results["adapter"]
    width, height = plan["size_px"]
    about = f"{adapter.get('name', 'no adapter')}, {results['cores']} cores, {width}x{height}, {plan['voxels']}^3 voxels"
    figure.suptitle(f"{about}; steps in voxels", fontsize="medium")
    with written(path) as temporary:
        figure.savefig(temporary, format=path.suffix.removeprefix(".").lower(), dpi=110)


def _draw_line(panel: Any, points: list[dict[str, Any]], name: str, colour: str, mark: str, names_steps: bool) -> None:
    """Points of one renderer, from the largest step to the smallest."""
    milliseconds = [row["milliseconds"]["total"]["median"] for row in points]
    levels = [max(255 * row["error"]["rmse"], LEAST_LEVEL) for row in points]
    panel.plot(milliseconds, levels, color=colour, marker=mark, markersize=5, linewidth=1.2, label=name)
    for row, *place in zip(points, milliseconds, levels, strict=True):
        if names_steps:
            step = f"{row['step']:g}"
            panel.annotate(step, place, xytext=(4, 4), textcoords="offset points", fontsize="small", color=colour)
