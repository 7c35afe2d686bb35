// Voxels with one of a few normals, each of which is lit once a frame (Kreylos, "Fake" Phong illumination): their numbers are
// fetched unfiltered, and the light of the eight voxels around a sample is interpolated. Slabs are lit at both ends.

import generated::lighting::{numbers, lit};
import generated::layer::layer;
import package::lighting::at_share::lit_ends;
import package::ray::Ray;
import package::sample::{Sample, Slab, Lit};

struct LitEnd { lit: Lit }

fn know_light(here: Sample, ray: Ray) -> LitEnd {
  let p = clamp(here.p_index, vec3f(0.0), layer.size - 1.0);
  let low = floor(p);
  let w = p - low;
  var light = Lit(vec3f(0.0), vec3f(0.0));
  for (var corner = 0u; corner < 8u; corner++) {
    let high = vec3f(vec3u(corner, corner >> 1u, corner >> 2u) & vec3u(1u));
    let share = mix(1.0 - w, w, high);
    let weight = share.x * share.y * share.z;
    let number = number_at(vec3u(min(low + high, layer.size - 1.0)));
    light.diffuse += weight * textureLoad(lit, vec3u(number, 0u, 0u), 0).rgb;
    light.specular += weight * textureLoad(lit, vec3u(number, 1u, 0u), 0).rgb;
  }
  return LitEnd(light);
}

// Four voxels along x lie in one texel.
fn number_at(voxel: vec3u) -> u32 { return textureLoad(numbers, vec3u(voxel.x >> 2u, voxel.yz), 0)[voxel.x & 3u]; }

fn light_known(front: Sample, front_light: LitEnd, back: Sample, back_light: LitEnd, slab: Slab, ray: Ray) -> vec3f {
  return lit_ends(slab, front_light.lit, back_light.lit);
}

fn light_slab(front: Sample, back: Sample, slab: Slab, ray: Ray) -> vec3f {
  return light_known(front, know_light(front, ray), back, know_light(back, ray), slab, ray);
}
