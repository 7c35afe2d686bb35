// What comes through of a light's picture.

fn comes_through(light: vec4f, picture: vec3f) -> vec3f { return light.rgb * picture; }
