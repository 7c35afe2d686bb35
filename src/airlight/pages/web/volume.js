// The volume that the page carries.

/** Texels of packed bytes: inflated, and the bytes of a texel put together. */
export async function unpacked(packed, { size, bits }) {
  const stream = new Blob([packed]).stream().pipeThrough(new DecompressionStream("deflate-raw"));
  const bytes = new Uint8Array(await new Response(stream).arrayBuffer());
  const count = size.reduce((a, b) => a * b);
  if (bytes.length !== (count * bits) / 8) throw new Error("The file is damaged: its volume has another size.");
  if (bits === 8) return bytes;
  const texels = new Uint16Array(count);
  for (let n = 0; n < count; n++) texels[n] = bytes[n] | (bytes[count + n] << 8);
  return texels;
}

/** Value of a half float's bits. */
export function halfOf(bits) {
  const [sign, power, rest] = [bits & 0x8000 ? -1 : 1, (bits >> 10) & 31, bits & 1023];
  return sign * (power ? 2 ** (power - 15) * (1 + rest / 1024) : 2 ** -14 * (rest / 1024));
}

/** How many texels hold a value in each of so many equal parts of a range. */
export function histogram(texels, { bits, scale, offset }, [low, high], bins) {
  const codes = new Float64Array(bits === 8 ? 256 : 65536);
  for (let n = 0; n < texels.length; n++) codes[texels[n]]++;
  const counts = new Float64Array(bins);
  codes.forEach((count, code) => {
    if (!count) return;
    const value = (bits === 8 ? code / 255 : halfOf(code)) * scale + offset;
    counts[Math.min(Math.max(Math.floor(((value - low) / (high - low || 1)) * bins), 0), bins - 1)] += count;
  });
  return counts;
}
