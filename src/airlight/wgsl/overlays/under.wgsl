// What lies between layers and an environment.

// A picture with a line that covers so much of a pixel, before the environment and behind all else.
fn put_under(picture: vec4f, backdrop: f32, line: vec3f, cover: f32) -> vec4f {
  return (1.0 - cover * backdrop) * picture + (1.0 - picture.a + backdrop) * cover * vec4f(line, 1.0);
}
