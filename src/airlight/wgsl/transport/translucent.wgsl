// Light that slabs scatter goes on within a cone: in alpha the direct part, as an opaque medium has it, in rgb the scattered one
// (after Kniss, Premoze, Hansen and Ebert 2002).

import generated::lamp::params as lamp;
import generated::translucent::params;
import package::sample::Slab;
import package::transport::colours::let_through;
import slot::beam::picture_at;
import slot::before::light_at;

const MIDDLE = 0.25;  // weight of the middle; the rest is that of a ring as wide as a disk of even light is
const RING = 8;
const DISK = 0.816497;

fn passing(slab: Slab) -> vec4f { return vec4f(let_through(slab, params.scatter), 1.0 - slab.alpha); }

// Where no light comes straight on, it may come from aside.
fn lasting(light: vec4f) -> bool { return true; }

// Light at this place, and on the mean round it: its direct part and its scattered part.
struct Gathered { direct: vec3f, scattered: vec3f, direct_round: vec3f, scattered_round: vec3f }

fn gathered(light: vec4f, p_world: vec3f) -> Gathered {
  let radius = DISK * lamp.spread_world * tan(radians(params.angle_deg));
  var around = Gathered(light.a * picture_at(p_world), light.rgb, vec3f(0.0), vec3f(0.0));
  around.direct_round = MIDDLE * around.direct;
  around.scattered_round = MIDDLE * around.scattered;
  for (var i = 0; i < RING; i++) {
    let turn = 6.2831853 * f32(i) / f32(RING);
    let beside = p_world + radius * (cos(turn) * lamp.right + sin(turn) * lamp.up);
    let there = light_at(beside);
    around.direct_round += (1.0 - MIDDLE) / f32(RING) * there.a * picture_at(beside);
    around.scattered_round += (1.0 - MIDDLE) / f32(RING) * there.rgb;
  }
  return around;
}

// From plane to plane more comes from round here. All that light is attenuated by what is not scattered; the scattered part is what
// of it is not direct.
fn carried(light: vec4f, around: Gathered, through: vec4f, share: f32) -> vec4f {
  let direct = mix(around.direct, around.direct_round, share);
  let scattered = mix(around.scattered, around.scattered_round, share);
  return vec4f(max((direct + scattered) * through.rgb - direct * through.a, vec3f(0.0)), light.a * through.a);
}

fn comes_through(light: vec4f, picture: vec3f) -> vec3f { return light.rgb + light.a * picture; }
