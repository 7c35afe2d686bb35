// Samples at equal distances from the eye, shifted from pixel to pixel and from frame to frame.

import generated::driver::params;
import generated::frame::frame;
import package::ray::Ray;
import package::spacing::Spacing;
import slot::offsets::offset_of;

fn spacing_of(ray: Ray, pixel: vec2u) -> Spacing { return Spacing(frame.step_world, fract(offset_of(pixel) + params.shift), 1.0); }
