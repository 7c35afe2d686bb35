// All layers: which is edited, which are drawn, how dense they are.
import { layerList } from "../layers.js";

export const panel = { title: "Layers", order: 42, build: layerList };
