// What the page makes of plain data on standard input, as plain data: bytes in hexadecimal numbers.
import { readFileSync } from "node:fs";

import { cameraUniforms, roomFor } from "../../../src/airlight/pages/web/camera.js";
import { functionRows, functionUniforms, segmentRows } from "../../../src/airlight/pages/web/function.js";
import { bytesOf, pack } from "../../../src/airlight/pages/web/packing.js";
import { unpacked } from "../../../src/airlight/pages/web/volume.js";

const given = JSON.parse(readFileSync(0, "utf8"));
const hex = (array) => Buffer.from(array.buffer, array.byteOffset, array.byteLength).toString("hex");

const functions = given.functions.map((one) => ({
  cells: hex(functionRows(one, "cells").texels),
  pieces: hex(functionRows(one, "pieces").texels),
  segments: hex(segmentRows(one, given.entries)),
}));

const packed = given.pages.map(({ page, sizePx }) => {
  const { layout, uniforms, bindings } = page.programs.march;
  const bytes = bytesOf(uniforms);
  const { values, offset } = cameraUniforms(page.camera, roomFor(sizePx, page.size_px), sizePx, page);
  const slabs = bindings.find((one) => one.holds.kind === "slabs")?.holds;
  const told = { frame: { t_offset_world: offset }, camera: values };
  if (page.transfer) told.transfer_0 = functionUniforms(page.transfer, slabs);
  pack(layout, told, new DataView(bytes.buffer));
  return hex(bytes);
});

const volumes = [];
for (const { bytes, size, bits } of given.volumes) volumes.push(hex(await unpacked(bytesOf(bytes), { size, bits })));

console.log(JSON.stringify({ functions, packed, volumes }));
