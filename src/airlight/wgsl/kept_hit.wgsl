// What is kept of a pixel: gradient and value; distance, which side was met, and in which layer.

import generated::pass::hits;
import generated::sizes::SURFACES_ONLY;
import package::met::Met;
import package::ray::INFINITE;

const HALF_OPAQUE = 4.0;  // the side of what is kept where no surfaces are looked for

fn side_of(met: Met, t_world: f32) -> f32 { return select(met.side, HALF_OPAQUE, !SURFACES_ONLY && t_world < INFINITE); }

fn write_hit(pixel: u32, gradient: vec3f, value: f32, t_world: f32, side: f32, number: u32) {
  hits[2u * pixel] = vec4f(gradient, value) * f32(side > 0.0);
  hits[2u * pixel + 1u] = vec4f(t_world, side, f32(number), 0.0);
}
