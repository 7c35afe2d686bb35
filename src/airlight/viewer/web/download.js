// Files for the user: a Blob and a link, which notebooks allow, too.
import { h } from "./dom.js";

const KEPT_MS = 60000;

/** Let the browser save data under a name. */
export function download(name, kind, data) {
  const url = URL.createObjectURL(new Blob([data], { type: kind }));
  h("a", { href: url, download: name }).click();
  setTimeout(() => URL.revokeObjectURL(url), KEPT_MS);
}
