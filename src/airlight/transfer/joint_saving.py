"""Functions of several variables as Python text and in TOML files::

# A transfer function of several variables: axes, and shapes on them; colours of linear light, extinctions per world unit.
axes = [
  { variable = "value", low = 0.0, high = 255.0 },
  { variable = "gradient", low = 0.0, high = 40.0 },
]

[[shapes]]
kind = "box"
low = [100.0, 5.0]
high = [160.0, 30.0]
colour = [1.0, 1.0, 1.0]
extinction = 2.0
"""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING, Any

from .joint_axes import Ramp
from .saving import write_whole

if TYPE_CHECKING:
    from .joint import JointFunction
    from .joint_shapes import Shape

HEADER = (
    "# A transfer function of several variables: axes, and shapes on them; colours of linear light, extinctions per world unit."
)


def as_code(function: JointFunction) -> str:
    """Return Python text that makes an equal function, where airlight is imported as ``al``.

    Examples
    --------
    >>> import airlight as al
    >>> axes = al.joint.Axis("value", 0, 255), al.joint.Axis("gradient", 0, 40)
    >>> print(al.JointFunction(axes, [al.joint.Box((100, 5), (160, 30), colour="white")]).as_code())
    al.JointFunction(
        axes=[
            al.joint.Axis('value', 0.0, 255.0),
            al.joint.Axis('gradient', 0.0, 40.0),
        ],
        shapes=[
            al.joint.Box(low=(100.0, 5.0), high=(160.0, 30.0), colour=(1.0, 1.0, 1.0), extinction=1.0),
        ],
    )
    """
    axes = [f"al.joint.Axis({a.variable!r}, {a.low!r}, {a.high!r})" for a in function.axes]
    lines = ["al.JointFunction(", "    axes=[", *(f"        {axis}," for axis in axes), "    ],"]
    lines += ["    shapes=[", *(f"        {_shape_code(shape)}," for shape in function.shapes), "    ],"]
    return "\n".join([*lines, *(["    associated=True,"] if function.associated else []), ")"])


def save(function: JointFunction, path: str | Path) -> None:
    """Write the function to a TOML file, which appears whole or not at all; ``JointFunction.load`` reads an equal one.

    Scene files hold the same text under ``[layers.transfer]``, and ``airlight render --tf FILE`` draws with it.

    Raises
    ------
    FileError
        When the file cannot be written.
    """
    lines = [HEADER, "axes = ["]
    lines += [f"  {{ variable = {_text(a.variable)}, low = {a.low!r}, high = {a.high!r} }}," for a in function.axes]
    lines += ["]", *(["associated = true"] if function.associated else [])]
    if not function.shapes:
        lines.append("shapes = []")
    for shape in function.shapes:
        lines += ["", "[[shapes]]", *(f"{name} = {_text(value)}" for name, value in shape.to_dict().items())]
    write_whole(Path(path), "\n".join([*lines, ""]))


def _shape_code(shape: Shape) -> str:
    fields = {n: f"al.joint.{v!r}" if isinstance(v, Ramp) else repr(v) for n, v in shape.chosen().items()}
    return f"al.joint.{type(shape).__name__}({', '.join(f'{name}={value}' for name, value in fields.items())})"


def _text(value: Any) -> str:
    """Numbers, words, lists and tables in TOML, on one line."""
    if isinstance(value, dict):
        return f"{{ {', '.join(f'{name} = {_text(part)}' for name, part in value.items())} }}"
    if isinstance(value, (list, tuple)):
        return f"[{', '.join(_text(part) for part in value)}]"
    if isinstance(value, str):  # as in JSON, whose pairs of escapes TOML does not have
        return json.dumps(value, ensure_ascii=False).replace("\x7f", "\\u007f")
    return repr(value)
