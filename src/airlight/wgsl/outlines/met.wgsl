// Closed meshes that clip, as `passes/outlines.wgsl` left them: changes of what they keep, pixel by pixel.

import generated::pass::changes;
import package::kept::Kept;
import package::outline::{BEGINS, CAPPED, change_place, unpacked_normal};

// Numbers of what cuts a ray: those of other clips are small.
const OUTLINE = 0x80000000u;
const LAST = 3e38;  // what is farther is the end of a row

// The next piece that a mesh keeps: it begins at a distance or behind it.
fn outlined_from(list: u32, pixel: u32, t_world: f32) -> Kept {
  var slot = 0u;
  var place = change_place(list, slot, pixel);
  var change = changes[place];
  loop {
    // There is none behind the last, also for who asks from beyond all.
    if (bitcast<f32>(change.x) > min(t_world, LAST)) { break; }
    slot++;
    place = change_place(list, slot, pixel);
    change = changes[place];
  }
  let t_next = bitcast<f32>(change.x);
  if ((change.y & BEGINS) == 0u) { return Kept(t_world, t_next, 0u, OUTLINE | place); }
  let behind = change_place(list, slot + select(0u, 1u, t_next < LAST), pixel);
  return Kept(t_next, bitcast<f32>(changes[behind].x), OUTLINE | place, OUTLINE | behind);
}

fn is_outline(number: u32) -> bool { return (number & OUTLINE) != 0u; }

fn outline_normal(number: u32) -> vec3f { return unpacked_normal(changes[number & ~OUTLINE].y); }

fn is_outline_capped(number: u32) -> bool { return (changes[number & ~OUTLINE].y & CAPPED) != 0u; }
