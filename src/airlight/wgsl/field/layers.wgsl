// How the samples of a grid lie in layers of 2-D textures.

import generated::layer::layer;

// Across a layer, by both axes in it in their order, and from layer to layer.
fn turned(p: vec3f) -> vec3f { return select(select(p, p.xzy, layer.stack_axis == 1u), p.yzx, layer.stack_axis == 0u); }
