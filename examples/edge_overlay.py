"""A pass of one's own: dark lines where the picture's depth bends or jumps. You should see a drawing of a flow in ink."""

from dataclasses import dataclass
from typing import ClassVar

import airlight as al


@al.register
@dataclass(frozen=True)
class EdgeOverlay(al.Pass):
    """Lines where depth bends or jumps, over the finished picture."""

    name: ClassVar[str] = "edge_overlay"
    bend: al.F32 = al.param(0.02, above=0, help="share of the depth by which it must bend from pixel to pixel")
    wgsl: ClassVar[str] = """
import generated::edge_overlay::params;
import generated::pass::{radiance, depth};
import package::picture::place;

// Changes evenly along a plane, and is zero where nothing is.
fn nearness(p_px: vec2i) -> f32 { return 1.0 / depth[place(p_px)].x; }

fn pixel(p_px: vec2i) -> vec4f {
  let here = nearness(p_px);
  let sides = vec4f(nearness(p_px + vec2i(1, 0)), nearness(p_px - vec2i(1, 0)),
                    nearness(p_px + vec2i(0, 1)), nearness(p_px - vec2i(0, 1)));
  let bend = abs(dot(sides, vec4f(1.0)) - 4.0 * here) / max(max(max(sides.x, sides.y), max(sides.z, sides.w)), here + 1e-30);
  let line = smoothstep(params.bend, 2.0 * params.bend, bend);
  return mix(radiance[place(p_px)], vec4f(0.0, 0.0, 0.0, 1.0), line);
}
"""

    def reach_px(self):
        return 1


if __name__ == "__main__":
    scene = al.Scene(al.samples.load("vortex"), camera="iso", background="white")
    al.render(scene, passes=["edge_overlay"]).save("edges.png")
