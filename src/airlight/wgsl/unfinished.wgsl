// Rays that are drawn part by part: what is known of each in between. Nothing is begun where all is zero.

import slot::integrate::Paused;

struct Unfinished {
  paused: Paused,
  samples: f32,       // negative where the device ended a loop
  covers_taken: u32,  // 0 before the first part
  ended: u32,
}
