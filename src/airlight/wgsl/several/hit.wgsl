// A surface of one of several layers.

import package::met::Met;

struct Hit { rgb: vec3f, alpha: f32, t_world: f32, met: Met }
