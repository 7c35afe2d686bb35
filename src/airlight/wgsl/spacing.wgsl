// Where samples lie along a ray: number k at `(k + shift) * step_world`. By `share` extinction is multiplied.

struct Spacing { step_world: f32, shift: f32, share: f32 }
