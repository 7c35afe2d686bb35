"""Documents as plain data, and back: what a scene file holds, with ids instead of files.

Clients never see a path, and what they send names nothing that was not given to them.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from ..errors import ValueRangeError
from ..scene_file.held import Held
from ..scene_file.options import checked_options
from ..scene_file.table import Table
from ..scene_file.writing import plain_stage
from ..stage import make_stage
from .document import Document


def plain_document(document: Document, held: Held) -> dict[str, Any]:
    """Return a document as plain data: ``{"scene": ..., "render": ...}``."""
    render: dict[str, Any] = {"driver": plain_stage(document.driver), "step": document.step, "skip": document.skip}
    if document.tolerance is not None:
        render["tolerance"] = document.tolerance
    if document.passes:
        render["passes"] = [plain_stage(stage) for stage in document.passes]
    return {"scene": held.plain(document.scene), "render": render}


def read_document(
    plain: Mapping[str, Any], held: Held, known: Mapping[str, Any] | None = None, of: Document | None = None
) -> Document:
    """Return the document of plain data; what they share with those of a known document is that one's very values.

    Parameters
    ----------
    plain
        What is read.
    held
        What it names by ids.
    known, of
        Plain data of a document, and the document.

    Raises
    ------
    AirlightError
        When something in them is unknown or wrong; the message names it.
    """
    if not isinstance(plain.get("scene"), Mapping) or not isinstance(plain.get("render"), Mapping):
        raise ValueRangeError("document", "must hold a scene and render")
    before = None if known is None else known["scene"]
    scene = held.scene(plain["scene"], before, None if of is None else of.scene)
    options: dict[str, Any] = {**checked_options(Table(plain["render"], ("render",), ""), held.picture)}
    driver = make_stage("driver", options.pop("driver", "march"), "render.driver")
    options.pop("size", None)
    return Document(scene, driver, **{"tolerance": None, **options})
