// Triangles of meshes: where rays meet them, and what their corners have.

import generated::mesh::params;
import generated::pass::{mesh_vertices, mesh_faces};
import package::ray::Ray;

struct Triangle {
  corners: vec3u,  // numbers of vertices
  a: vec3f,        // [world]
  b: vec3f,        // from a on
  c: vec3f,
}

fn triangle_of(number: u32) -> Triangle {
  let first = 3u * number;
  let corners = vec3u(mesh_faces[first], mesh_faces[first + 1u], mesh_faces[first + 2u]);
  let a = corner_world(corners.x);
  return Triangle(corners, a, corner_world(corners.y) - a, corner_world(corners.z) - a);
}

// Shares of the corners in the point where a ray meets a triangle, or passes it closest by rounding.
fn shares_of(triangle: Triangle, ray: Ray) -> vec3f {
  let across = cross(ray.direction_world, triangle.c);
  let volume = dot(triangle.b, across);
  let from_a = ray.origin_world - triangle.a;
  let other = cross(from_a, triangle.b);
  let scale = select(1.0 / volume, 0.0, volume == 0.0);
  let v = dot(from_a, across) * scale;
  let w = dot(ray.direction_world, other) * scale;
  let inside = max(vec3f(1.0 - v - w, v, w), vec3f(0.0));
  return min(inside / (inside.x + inside.y + inside.z), vec3f(1.0));
}

fn point_of(triangle: Triangle, share: vec3f) -> vec3f { return triangle.a + share.y * triangle.b + share.z * triangle.c; }

// White where vertices have no colours. No branch is told by a uniform alone: software devices compile it anew for each dispatch.
fn colour_of(triangle: Triangle, share: vec3f) -> vec4f {
  let at = 3u * triangle.corners + 2u;
  if (params.stride < 3u || share.x > 1.0) { return vec4f(1.0); }
  return mat3x4f(mesh_vertices[at.x], mesh_vertices[at.y], mesh_vertices[at.z]) * share;
}

// Normal in the world; that of the triangle itself where there is no other.
fn normal_of(triangle: Triangle, share: vec3f) -> vec3f {
  var normal = cross(triangle.b, triangle.c);
  if (params.is_smooth != 0u && share.x <= 1.0) {
    let at = params.stride * triangle.corners + 1u;
    let mixed = mat3x3f(mesh_vertices[at.x].xyz, mesh_vertices[at.y].xyz, mesh_vertices[at.z].xyz) * share;
    let turned = params.normal_from_mesh * mixed;
    normal = select(normal, turned, dot(turned, turned) > 1e-12);
  }
  let steepest = max(abs(normal.x), max(abs(normal.y), abs(normal.z)));
  return normalize(select(vec3f(0.0, 0.0, 1.0), normal / steepest, steepest > 0.0));
}

fn corner_world(number: u32) -> vec3f {
  return (params.world_from_mesh * vec4f(mesh_vertices[params.stride * number].xyz, 1.0)).xyz;
}
