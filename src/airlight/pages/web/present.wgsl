// A picture of linear light on the canvas: over the background, enlarged where it is smaller, encoded for sRGB displays.

struct Shown { picture_px: vec2u, canvas_px: vec2u, background: vec3f }

@group(0) @binding(0) var<uniform> shown: Shown;
@group(0) @binding(1) var<storage, read> radiance: array<vec4f>;

@vertex
fn corner(@builtin(vertex_index) number: u32) -> @builtin(position) vec4f {
  return vec4f(f32(number & 1u) * 4.0 - 1.0, f32(number >> 1u) * 4.0 - 1.0, 0.0, 1.0);
}

@fragment
fn pixel(@builtin(position) place: vec4f) -> @location(0) vec4f {
  let last = vec2f(shown.picture_px) - 1.0;
  let p = clamp(place.xy * vec2f(shown.picture_px) / vec2f(shown.canvas_px) - 0.5, vec2f(0.0), last);
  let low = vec2u(p);
  let high = vec2u(min(vec2f(low) + 1.0, last));
  let w = fract(p);
  let above = mix(at(low.x, low.y), at(high.x, low.y), w.x);
  let below = mix(at(low.x, high.y), at(high.x, high.y), w.x);
  let found = mix(above, below, w.y);
  return vec4f(encoded(found.rgb + (1.0 - found.a) * shown.background), 1.0);
}

fn at(x: u32, y: u32) -> vec4f { return radiance[y * shown.picture_px.x + x]; }

fn encoded(linear: vec3f) -> vec3f {
  let v = saturate(linear);
  return select(1.055 * pow(max(v, vec3f(0.0031308)), vec3f(1.0 / 2.4)) - 0.055, 12.92 * v, v <= vec3f(0.0031308));
}
