// Samples of a layer in the world, and slabs with ends that hold nothing.

import generated::layer::layer;
import generated::sizes::HAS_EMPTY;
import package::sample::Sample;
import package::walk::Fetched;
import slot::values::is_gap;

// Samples at both ends, and the share of the slab that is there.
struct FilledEnds { front: Sample, back: Sample, share: f32 }

// Where one end is empty, half of the slab is there, with the sample of the other end.
fn filled_ends(front: Sample, back: Sample) -> FilledEnds {
  var ends = FilledEnds(front, back, 1.0);
  if (HAS_EMPTY) {
    let gaps = vec2<bool>(is_gap(front.value), is_gap(back.value));
    if (gaps.y) { ends.back = front; }
    if (gaps.x) { ends.front = back; }
    ends.share = select(select(1.0, 0.5, any(gaps)), 0.0, all(gaps));
  }
  return ends;
}

fn sample_here(here: Fetched, p_world: vec3f) -> Sample {
  return Sample(here.value, vec3f(0.0), (layer.index_from_world * vec4f(p_world, 1.0)).xyz, p_world, here.t_world);
}
