"""The HTML file: template, style, script and data in one, nothing of which is loaded from elsewhere."""

from __future__ import annotations

import base64
import hashlib
import html
import json
import re
from collections.abc import Sequence
from functools import lru_cache
from pathlib import Path
from typing import Any

from ..bundling import bundled
from ..transfer.colour import linear_to_srgb

WEB = Path(__file__).parent / "web"


def page_text(title: str, caption: str, data: dict[str, Any], texels: bytes, still: bytes) -> str:
    """Return the page.

    Parameters
    ----------
    title, caption
        Shown as they are, whatever they hold.
    data
        What ``Carried.plain`` returned.
    texels
        The packed volume.
    still
        A JPEG file: what is seen before the first picture, and where there is no WebGPU.
    """
    style = source("page.css") + _ground(data["background"])
    script = '"use strict";\n' + bundled(WEB, "main.js")
    filled = {
        "policy": policy(style, script),
        "title": _escaped(title),
        "name": _escaped(title or "A volume"),
        "caption": _escaped(caption),
        "style": style,
        "script": script,
        "still": base64.b64encode(still).decode("ascii"),
        "data": escaped_json({**data, "present": source("present.wgsl")}),
        "texels": base64.b64encode(texels).decode("ascii"),
    }
    return re.sub(r"\{\{(\w+)\}\}", lambda match: filled[match[1]], source("page.html"))


def _escaped(text: str) -> str:
    """Text between elements; what is half a letter, of headers and command lines in other encodings, is a question mark."""
    return html.escape(text.encode("utf-8", "replace").decode("utf-8"))


def _ground(background: Sequence[float] | None) -> str:
    """Style of what lies round the still picture: linear light as sRGB."""
    if background is None:
        return ""
    return "main { background: rgb(" + " ".join(f"{100 * c:.4g}%" for c in linear_to_srgb(background)) + "); }\n"


def policy(style: str, script: str) -> str:
    """Content policy that lets nothing in but this style, this script and the pictures of the file itself."""
    rules = {
        "default-src": "'none'",
        "script-src": _hash(script),
        "style-src": _hash(style),
        "img-src": "data:",
        "base-uri": "'none'",
        "form-action": "'none'",
    }
    return "; ".join(f"{name} {allowed}" for name, allowed in rules.items())


def _hash(text: str) -> str:
    return f"'sha256-{base64.b64encode(hashlib.sha256(text.encode()).digest()).decode()}'"


def escaped_json(data: Any) -> str:
    """JSON that may stand in a script element: it holds no ``<``, no ``&``, and nothing that is not ASCII."""
    text = json.dumps(data, separators=(",", ":"), allow_nan=False)
    return text.replace("&", r"\u0026").replace("<", r"\u003c").replace(">", r"\u003e")


@lru_cache(maxsize=16)
def source(name: str) -> str:
    """Text of a file of the page."""
    return (WEB / name).read_text(encoding="utf-8")
