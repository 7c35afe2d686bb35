// Values to the bytes of a struct, by the layout that comes with a program: names, types and places.

/** Bytes of base64. */
export function bytesOf(text) {
  const letters = atob(text);
  const bytes = new Uint8Array(letters.length);
  for (let n = 0; n < letters.length; n++) bytes[n] = letters.charCodeAt(n);
  return bytes;
}

/** Write values by name into a view of a struct's bytes; members without a value stay as they are. */
export function pack(layout, values, view, base = 0) {
  for (const { name, type, offset, struct } of layout.members) {
    const value = values[name];
    if (value === undefined) continue;
    if (struct) pack(struct, value, view, base + offset);
    else put(view, base + offset, type, value);
  }
}

function put(view, at, type, value) {
  if (type.startsWith("mat")) {
    // Columns begin at multiples of 16 bytes.
    value.forEach((column, n) => put(view, at + 16 * n, `vec${column.length}f`, column));
    return;
  }
  const kind = type.startsWith("vec") ? type.at(-1) : type[0];
  const set = { f: "setFloat32", i: "setInt32", u: "setUint32" }[kind];
  (Array.isArray(value) ? value : [value]).forEach((one, n) => view[set](at + 4 * n, Number(one), true));
}
