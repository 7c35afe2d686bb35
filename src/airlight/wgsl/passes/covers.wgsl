// Where the rays of pixels meet the triangles that were found there, and in which light.

import generated::frame::frame;
import generated::mesh::params;
import generated::pass::{covers, cover_counts, triangles, mesh_vertices, mesh_faces};
import generated::sizes::{WORKGROUP_X, WORKGROUP_Y};
import package::cover::COVER_NUMBERS;
import package::ray::Ray;
import package::sample::Sample;
import slot::camera::eye_ray;
import slot::shade::light;

@compute @workgroup_size(WORKGROUP_X, WORKGROUP_Y)
fn main(@builtin(global_invocation_id) id: vec3u) {
  if (any(id.xy >= frame.tile_size_px)) { return; }
  let found = textureLoad(triangles, id.xy, 0).xy;
  if (found.x == 0u || found.y != params.number) { return; }
  // No branch is told by a uniform alone: software devices would compile it anew for each dispatch.
  if (params.layer > 0u && found.x > 0u) { atomicAdd(&cover_counts[params.layer], 1u); }
  // The layer behind the last one is counted alone.
  if (params.layer > params.layers && found.x > 0u) { return; }
  let pixel = frame.tile_origin_px + id.xy;
  let ray = eye_ray(vec2f(pixel) + 0.5);
  let first = 3u * (found.x - 1u);
  let corners = vec3u(mesh_faces[first], mesh_faces[first + 1u], mesh_faces[first + 2u]);
  let a = corner_world(corners.x);
  let b = corner_world(corners.y) - a;
  let c = corner_world(corners.z) - a;
  let share = met_at(ray, a, b, c);
  var here: Sample;
  here.p_world = a + share.y * b + share.z * c;
  here.t_world = dot(here.p_world - ray.origin_world, ray.direction_world);
  let rgba = vec4f(params.rgb, params.opacity) * colour_at(corners, share);
  let alpha = select(rgba.a, 1.0, params.layer == 0u);
  let normal = normal_at(corners, share, cross(b, c));
  here.gradient = -normal;
  let lit = light(here, normal, -ray.direction_world);
  let rgb = select(rgba.rgb, rgba.rgb * lit.diffuse + lit.specular, params.is_lit != 0u);
  let in_band = (pixel.y - frame.band_first_row) * frame.size_px.x + pixel.x;
  let at = COVER_NUMBERS * (params.layer * frame.size_px.x * frame.band_rows + in_band);
  covers[at] = alpha * rgb.r;
  covers[at + 1u] = alpha * rgb.g;
  covers[at + 2u] = alpha * rgb.b;
  covers[at + 3u] = alpha;
  covers[at + 4u] = here.t_world;
}

// Shares of the corners in the point where a ray meets a triangle, or passes it closest by rounding; b and c from a.
fn met_at(ray: Ray, a: vec3f, b: vec3f, c: vec3f) -> vec3f {
  let across = cross(ray.direction_world, c);
  let volume = dot(b, across);
  let from_a = ray.origin_world - a;
  let other = cross(from_a, b);
  let scale = select(1.0 / volume, 0.0, volume == 0.0);
  let v = dot(from_a, across) * scale;
  let w = dot(ray.direction_world, other) * scale;
  let inside = max(vec3f(1.0 - v - w, v, w), vec3f(0.0));
  return inside / (inside.x + inside.y + inside.z);
}

fn corner_world(number: u32) -> vec3f {
  return (params.world_from_mesh * vec4f(mesh_vertices[params.stride * number].xyz, 1.0)).xyz;
}

fn colour_at(corners: vec3u, share: vec3f) -> vec4f {
  let at = select(vec3u(0u), 3u * corners + 2u, params.stride >= 3u);
  return select(vec4f(1.0), mat3x4f(mesh_vertices[at.x], mesh_vertices[at.y], mesh_vertices[at.z]) * share, params.stride >= 3u);
}

// Normal in the world; that of the triangle itself where there is no other.
fn normal_at(corners: vec3u, share: vec3f, across: vec3f) -> vec3f {
  let is_smooth = params.is_smooth != 0u;
  let at = select(vec3u(0u), params.stride * corners + 1u, is_smooth);
  let mixed = mat3x3f(mesh_vertices[at.x].xyz, mesh_vertices[at.y].xyz, mesh_vertices[at.z].xyz) * share;
  let turned = params.normal_from_mesh * mixed;
  let normal = select(across, turned, is_smooth && dot(turned, turned) > 1e-12);
  let steepest = max(abs(normal.x), max(abs(normal.y), abs(normal.z)));
  return normalize(select(vec3f(0.0, 0.0, 1.0), normal / steepest, steepest > 0.0));
}
