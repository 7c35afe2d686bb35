// The medium is the value: what the field holds was made of the voxels. A slab is the mean of the media at its two ends.

import generated::transfer::{ASSOCIATED, WEIGHTED};
import package::optics::make_slab;
import package::sample::{Sample, Medium, Slab};

fn medium(here: Sample) -> Medium {
  let kept = here.value[0];
  if (WEIGHTED && !ASSOCIATED) { return Medium(kept.rgb / max(kept.a, 1e-30), kept.a); }
  return Medium(kept.rgb, kept.a);
}

// Source and extinction [1/world].
fn source_at(here: Sample) -> vec4f {
  let kept = here.value[0];
  if (WEIGHTED || ASSOCIATED) { return kept; }
  return vec4f(kept.rgb * kept.a, kept.a);
}

// Nothing between two ends that hold nothing, since a slab is their mean.
fn empty_slab(front: Sample, back: Sample) -> bool {
  let most = max(front.value[0], back.value[0]);
  return most.a <= 0.0 && (!ASSOCIATED || all(most.rgb <= vec3f(0.0)));
}

fn classify(front: Sample, back: Sample, length: f32) -> Slab {
  let mean = 0.5 * (source_at(front) + source_at(back));
  return make_slab(mean.rgb, mean.a, length);
}
