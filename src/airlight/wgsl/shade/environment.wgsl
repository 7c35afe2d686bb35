// Light from all directions: scattered in the medium's colour under a coat that reflects.

import generated::environment::{params, maps, maps_sampler, reflection, reflection_sampler};
import package::lights::surfaceness;
import package::octahedral::octahedral_place;
import package::sample::{Sample, Lit};
import slot::lookup::table_at;
import slot::visibility::ambient_visibility;

fn light(here: Sample, normal: vec3f, to_eye: vec3f) -> Lit {
  let arrives = params.intensity * ambient_visibility(here.p_world);
  let surface = surfaceness(here.gradient, params.per_threshold);
  let cosine = dot(normal, to_eye);
  let scattered = radiance_at(select(normal, seen_side(normal, cosine, to_eye), params.two_sided != 0u), f32(textureDimensions(maps).z) - 1.0);
  let glossy = radiance_at(2.0 * cosine * normal - to_eye, params.layer);
  let coat = surface * reflected(abs(cosine));
  let below = mix(params.mean, mix(scattered, glossy, params.metallic), surface);
  return Lit(arrives * params.diffuse * (1.0 - coat) * below, arrives * coat * glossy);
}

// Normal of the side that the eye sees. At grazing angles, where either may be it, it leans over to the eye: sides change
// without a jump.
fn seen_side(normal: vec3f, cosine: f32, to_eye: vec3f) -> vec3f {
  let side = clamp(cosine / GRAZING, -1.0, 1.0);
  return normal * side + to_eye * (1.0 - abs(side));
}

const GRAZING = 0.2;

// Radiance from a direction of the world, of any length, as a layer of the maps has it.
fn radiance_at(direction_world: vec3f, layer: f32) -> vec3f {
  let size = vec3f(textureDimensions(maps));
  let place = octahedral_place(params.environment_from_world * direction_world, size.x);
  return table_at(maps, maps_sampler, vec3f(place, (layer + 0.5) / size.z)).rgb;
}

// Share of a white environment that the coat reflects. What reflects next to nothing does not at grazing angles either.
fn reflected(cosine: f32) -> f32 {
  let n = f32(textureDimensions(reflection).x);
  let place = (vec2f(cosine, params.roughness) * (n - 1.0) + 0.5) / n;
  let shares = table_at(reflection, reflection_sampler, vec3f(place, 0.5)).xy;
  return min(params.reflectance * shares.x + min(50.0 * params.reflectance, 1.0) * shares.y, 1.0);
}
