// The function that is edited: the layer's, or that of a channel of its mixture.
import { layersOf } from "../layers.js";

/** Where the edited function is: { path, transfer, layer, part, key }; transfer is null for functions of several variables. */
export function targetOf(view) {
  const layers = layersOf(view);
  const layer = layers.layer();
  const part = layers.part();
  const inner = part === null ? ["transfer"] : ["transfer", "channels", part, "transfer"];
  const transfer = inner.reduce((data, key) => data?.[key], layer) ?? null;
  const channel = part === null ? layer?.channel : layer.transfer.channels[part].channel;
  return {
    path: layers.path(...inner),
    transfer: transfer?.points ? transfer : null,
    layer: layers.index(),
    part,
    key: JSON.stringify([layers.index(), layer?.volume, channel, layer?.time]),
  };
}

/** Arguments of a question about it. */
export const asked = ({ layer, part }) => (part === null ? { layer } : { layer, part });
