"""Functions of several variables as Python text. In TOML files (see ``saving``) they look like this::

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

from typing import TYPE_CHECKING

from .joint_axes import Ramp

if TYPE_CHECKING:
    from .joint import JointFunction
    from .joint_shapes import Shape


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


def _shape_code(shape: Shape) -> str:
    fields = {n: f"al.joint.{v!r}" if isinstance(v, Ramp) else repr(v) for n, v in shape.chosen().items()}
    return f"al.joint.{type(shape).__name__}({', '.join(f'{name}={value}' for name, value in fields.items())})"
