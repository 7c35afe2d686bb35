// The panels, in any order; each tells its own place.
import { panel as clips } from "./clips.js";
import { panel as display } from "./display.js";
import { panel as lights } from "./lights.js";
import { panel as look } from "./look.js";
import { panel as quality } from "./quality.js";
import { panel as statistics } from "./statistics.js";
import { panel as surfaces } from "./surfaces.js";
import { panel as time } from "./time.js";
import { panel as channels } from "./channels.js";
import { panel as labels } from "./labels.js";
import { panel as layers } from "./layers.js";
import { panel as transfer } from "./transfer.js";
import { panel as joint } from "./joint.js";
import { panel as probe } from "./probe.js";
import { panel as slices } from "./slices.js";
import { panel as files } from "./files.js";
import { panel as save } from "./save.js";
import { panel as share } from "./share.js";

export const panels = [
  clips,
  display,
  lights,
  look,
  quality,
  statistics,
  surfaces,
  time,
  channels,
  labels,
  layers,
  transfer,
  joint,
  probe,
  slices,
  files,
  save,
  share,
];
