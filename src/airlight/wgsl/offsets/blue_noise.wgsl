// Shifts from a tile of blue noise, four pixels of a row to a texel.

import generated::driver::noise;

fn offset_of(pixel: vec2u) -> f32 {
  let place = pixel % vec2u(4u * textureDimensions(noise).x, textureDimensions(noise).y);
  return textureLoad(noise, vec3u(place.x >> 2u, place.y, 0u), 0)[place.x & 3u];
}
