// What is known of a sample in each layer.

import next::several::layer::{Knowns, know_all, know_all_empty};
import package::sample::Sample;

fn know(here: Sample) -> Knowns { return know_all(here.value, here.p_world); }

fn know_empty(here: Sample) -> Knowns { return know_all_empty(here.value, here.p_world); }
