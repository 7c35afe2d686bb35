"""A pass of one's own: what lies off the focus is blurred. You should see a flow of which the nearest part alone is sharp."""

from dataclasses import dataclass
from typing import ClassVar

import airlight as al


@al.register
@dataclass(frozen=True)
class DepthOfField(al.Pass):
    """Blur as of a lens, over the scene's own light, before its tones are mapped."""

    name: ClassVar[str] = "depth_of_field"
    over: ClassVar[str] = "scene"
    focus: al.F32 = al.param(20.0, above=0, unit="world", help="distance from the eye that is sharp")
    aperture: al.F32 = al.param(40.0, at_least=0, unit="px", help="radius of the blur of what is far away, at most 10")
    wgsl: ClassVar[str] = """
import generated::depth_of_field::params;
import generated::pass::{radiance, depth};
import package::picture::place;
fn blur(z: f32) -> f32 { return clamp(params.aperture * abs(1.0 - params.focus / z), 0.5, 10.0); }
fn pixel(p_px: vec2i) -> vec4f {
  let z = depth[place(p_px)].x;
  var sum = vec4f(0.0);
  var weights = 0.0;
  for (var i = 0; i < 64; i++) {  // a spiral; what is nearer spreads by its own blur, what is farther by this one's at most
    let r = 10.0 * sqrt(f32(i) / 64.0);
    let there = place(p_px + vec2i(round(r * vec2f(cos(2.4 * f32(i)), sin(2.4 * f32(i))))));
    let spread = min(blur(depth[there].x), select(10.0, blur(z), depth[there].x > z));
    let weight = saturate(spread - r + 0.5) / (spread * spread);
    sum += weight * radiance[there];
    weights += weight;
  }
  return sum / weights;
}
"""

    def reach_px(self):
        return 11
