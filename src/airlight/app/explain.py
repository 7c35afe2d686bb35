"""``airlight explain``: the program that draws a volume or a scene."""

from typing import Annotated

from cyclopts import Parameter

from .build import make_job
from .inputs import SCENE_INPUT
from .labels import LabelOptions
from .options import DrawOptions, LookOptions, ReadOptions, ViewOptions
from .progress import ProgressBar


def explain(
    input: Annotated[str, Parameter(help=SCENE_INPUT)],
    /,
    *,
    look: LookOptions | None = None,
    view: ViewOptions | None = None,
    draw: DrawOptions | None = None,
    read: ReadOptions | None = None,
    labels: LabelOptions | None = None,
) -> None:
    """Print the linked WGSL program of a scene: where each part comes from, the layout of its structs, its key in the cache.

    For instance:

        airlight explain head.nii.gz
        airlight explain scene.toml --transfer postclassified --shade none
    """
    from .. import api

    with ProgressBar() as progress:
        options = look or LookOptions(), view or ViewOptions(), draw or DrawOptions(), read or ReadOptions()
        job = make_job(input, *options, progress, labels)
    print(api.explain(job.scene, job.size, driver=job.arguments.get("driver", "march"), device=job.arguments.get("device")))
