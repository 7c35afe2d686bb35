// The device: programs, textures and buffers, and one picture at a time.

import { cameraUniforms, roomFor } from "./camera.js";
import { entriesFor, functionRows, functionUniforms, segmentRows } from "./function.js";
import { bytesOf, pack } from "./packing.js";

const GROUPS = 4;
const TABLE_WINDOWS = 1 << 19; // of one dispatch of a table
const ROUGH_ENTRIES = 128;
const TABLE_THREADS = 8; // of a diagonal
const PIXEL_BYTES = { radiance: 16, depth: 8 };
const TILE_MS = 25;
const FIRST_TILE_PX = 1 << 15;
const NO_WEBGPU = "This browser has no WebGPU, so this is a still picture. Chrome, Edge, Safari and Firefox of today have it.";
const NO_ADAPTER = "WebGPU found no graphics device here, so this is a still picture.";

/** A device with core limits; an error in words where there is none. */
export async function openDevice() {
  if (!navigator.gpu) throw new Error(NO_WEBGPU);
  const adapter = await navigator.gpu.requestAdapter();
  if (!adapter) throw new Error(NO_ADAPTER);
  return adapter.requestDevice();
}

async function program(device, plain) {
  const module = device.createShaderModule({ code: plain.wgsl });
  const layouts = [];
  for (let group = 0; group < GROUPS; group++) {
    const entries = plain.bindings.filter((one) => one.group === group);
    layouts.push(
      device.createBindGroupLayout({ entries: entries.map((one) => ({ ...one.entry, visibility: GPUShaderStage.COMPUTE })) }),
    );
  }
  const layout = device.createPipelineLayout({ bindGroupLayouts: layouts });
  const pipeline = await device.createComputePipelineAsync({ layout, compute: { module, entryPoint: "main" } });
  const uniforms = bytesOf(plain.uniforms);
  const buffer = device.createBuffer({ size: uniforms.length, usage: GPUBufferUsage.UNIFORM | GPUBufferUsage.COPY_DST });
  return { plain, pipeline, layouts, uniforms, view: new DataView(uniforms.buffer), buffer };
}

function bound(device, { plain, layouts }, found) {
  return layouts.map((layout, group) => {
    const entries = plain.bindings.filter((one) => one.group === group);
    return device.createBindGroup({
      layout,
      entries: entries.map(({ entry, name }) => {
        const resource = found[name];
        return { binding: entry.binding, resource: resource instanceof GPUBuffer ? { buffer: resource } : resource };
      }),
    });
  });
}

function dispatch(device, { pipeline, buffer, uniforms }, groups, counts) {
  device.queue.writeBuffer(buffer, 0, uniforms);
  const encoder = device.createCommandEncoder();
  const pass = encoder.beginComputePass();
  pass.setPipeline(pipeline);
  groups.forEach((group, n) => pass.setBindGroup(n, group));
  pass.dispatchWorkgroups(...counts);
  pass.end();
  device.queue.submit([encoder.finish()]);
}

function bufferOf(device, bytes, usage) {
  const buffer = device.createBuffer({ size: Math.ceil(bytes.byteLength / 16) * 16, usage: usage | GPUBufferUsage.COPY_DST });
  device.queue.writeBuffer(buffer, 0, bytes);
  return buffer;
}

function texture3d(device, format, size, texels) {
  const [width, height, depth] = size;
  const usage = GPUTextureUsage.TEXTURE_BINDING | GPUTextureUsage.COPY_DST;
  const texture = device.createTexture({ size, format, dimension: "3d", usage });
  const layout = { bytesPerRow: texels.byteLength / (height * depth), rowsPerImage: height };
  device.queue.writeTexture({ texture }, texels, layout, size);
  return texture;
}

const rowsOf = (text) => new Float32Array(bytesOf(text).buffer);

/** What draws: `setFunction`, `draw` a picture of so many pixels, and `present` it on a canvas. */
export async function renderer(device, page, carried, canvas, background) {
  const [march, table, shown, texels] = await Promise.all([
    program(device, page.programs.march),
    page.programs.table ? program(device, page.programs.table) : null,
    presenter(device, page.present, canvas, background),
    carried,
  ]);
  const found = { uniforms: march.buffer };
  const lasting = []; // of functions: what an edit makes anew
  let pictures = null;
  let groups = null;
  let pixelsInTime = FIRST_TILE_PX;
  let desk = null; // where tables are made
  let wanted = null; // function
  const taken = { function: null, isFine: false };

  for (const { name, entry, holds } of page.programs.march.bindings) {
    if (holds.kind === "sampler") found[name] = device.createSampler({ magFilter: "linear", minFilter: "linear" });
    if (holds.kind === "volume") found[name] = texture3d(device, page.volume.format, page.volume.size, texels).createView();
    if (holds.kind === "table") found[name] = texture3d(device, "rgba32float", holds.size, rowsOf(holds.texels)).createView();
    if (holds.kind === "bytes") {
      const isUniform = entry.buffer.type === "uniform";
      found[name] = bufferOf(device, bytesOf(holds.bytes), isUniform ? GPUBufferUsage.UNIFORM : GPUBufferUsage.STORAGE);
    }
    if (holds.kind === "slabs" && holds.rows) {
      found[name] = slabTable(holds, rowsOf(holds.rows), holds.entries, holds.associated);
    }
  }

  /** Table of slabs, filled on the device. */
  function slabTable(holds, rows, entries, associated, kept = []) {
    const planes = holds.weighted ? 2 : 1;
    const texture = device.createTexture({
      size: [entries, entries, holds.lengths * planes],
      format: "rgba32float",
      usage: GPUTextureUsage.TEXTURE_BINDING | GPUTextureUsage.STORAGE_BINDING,
    });
    const atOnce = Math.min(entries, Math.max(1, Math.floor(TABLE_WINDOWS / entries)));
    const room = 32 * entries * (atOnce + 1) * planes;
    if (!desk || desk.size < room) {
      desk?.destroy();
      desk = device.createBuffer({ size: room, usage: GPUBufferUsage.STORAGE });
    }
    const segments = bufferOf(device, rows, GPUBufferUsage.STORAGE);
    kept.push(texture, segments);
    const bindings = bound(device, table, {
      uniforms: table.buffer,
      segments,
      waiting: desk,
      slab_table_out: texture.createView({ dimension: "2d-array" }),
    });
    const [x, y] = table.plain.group_px;
    for (let layer = 0; layer < holds.lengths; layer++) {
      for (let first = 0; first < entries; first += atOnce) {
        const diagonals = Math.min(atOnce, entries - first);
        const length = (holds.length * (layer + 1)) / holds.lengths;
        const told = { entries, lengths: holds.lengths, layer, length_world: length, associated };
        pack(table.plain.layout, { slab_table: { ...told, first_diagonal: first, diagonals } }, table.view);
        dispatch(device, table, bindings, [Math.ceil(TABLE_THREADS / y), Math.ceil(diagonals / x), 1]);
      }
    }
    return texture.createView({ dimension: "2d-array" });
  }

  /** Make what is read of a function; a rough table of slabs takes a quarter of the time, and less. */
  function takeFunction(given, isFine) {
    lasting.splice(0).forEach((one) => one.destroy());
    let slabs = null;
    for (const { name, holds } of page.programs.march.bindings) {
      if (holds.kind === "function") {
        const { width, height, texels: rows } = functionRows(given, holds.rows);
        const texture = texture3d(device, "rgba32float", [width, height, 1], rows);
        lasting.push(texture);
        found[name] = texture.createView();
      } else if (holds.kind === "slabs" && !holds.rows) {
        slabs = { ...holds, entries: isFine ? entriesFor(given, holds.entries) : ROUGH_ENTRIES };
        found[name] = slabTable(holds, segmentRows(given, slabs.entries), slabs.entries, given.associated, lasting);
      }
    }
    pack(march.plain.layout, { transfer_0: functionUniforms(given, slabs) }, march.view);
    groups = null;
  }

  function makeRoom([width, height]) {
    const pixels = width * height;
    if (pictures && pixels <= pictures.pixels && pixels * 4 > pictures.pixels) return;
    for (const name of Object.keys(PIXEL_BYTES)) found[name]?.destroy();
    for (const [name, bytes] of Object.entries(PIXEL_BYTES)) {
      found[name] = device.createBuffer({ size: pixels * bytes, usage: GPUBufferUsage.STORAGE });
    }
    pictures = { pixels };
    groups = null;
  }

  /** Draw a picture in pieces of about 25 ms, finely or not; false, and nothing to present, when it is no longer wanted. */
  async function draw(camera, sizePx, isFine, isWanted) {
    if (wanted && (wanted !== taken.function || (isFine && !taken.isFine))) {
      takeFunction(wanted, isFine || !table);
      Object.assign(taken, { function: wanted, isFine: isFine || !table });
    }
    makeRoom(sizePx);
    groups ??= bound(device, march, found);
    const { values, offset } = cameraUniforms(camera, roomFor(sizePx, page.size_px), sizePx, page);
    const [width, height] = sizePx;
    const [x, y] = march.plain.group_px;
    for (let first = 0; first < height; ) {
      const rows = Math.min(height - first, Math.max(y, Math.floor(pixelsInTime / width / y) * y));
      const frame = {
        size_px: sizePx,
        tile_origin_px: [0, first],
        tile_size_px: [width, rows],
        band_first_row: 0,
        band_rows: height,
        t_offset_world: offset,
      };
      pack(march.plain.layout, { frame, camera: values }, march.view);
      const start = performance.now();
      dispatch(device, march, groups, [Math.ceil(width / x), Math.ceil(rows / y), 1]);
      await device.queue.onSubmittedWorkDone();
      const pace = (rows * width * TILE_MS) / Math.max(performance.now() - start, 1);
      pixelsInTime = Math.max(Math.min(pace, 4 * pixelsInTime), 64 * y);
      first += rows;
      if (!isWanted()) return false;
    }
    return true;
  }

  return {
    /** Draw with another transfer function from the next picture on. */
    setFunction: (given) => { wanted = given; },
    draw,
    present: (sizePx) => shown(found.radiance, sizePx),
    /** Pixels that are drawn in so many milliseconds. */
    pixelsIn: (ms) => (pixelsInTime * ms) / TILE_MS,
  };
}

/** A function that shows a picture of some size on the canvas. */
async function presenter(device, code, canvas, background) {
  const context = canvas.getContext("webgpu");
  const format = navigator.gpu.getPreferredCanvasFormat();
  context.configure({ device, format, alphaMode: "opaque" });
  const module = device.createShaderModule({ code });
  const pipeline = await device.createRenderPipelineAsync({
    layout: "auto",
    vertex: { module, entryPoint: "corner" },
    fragment: { module, entryPoint: "pixel", targets: [{ format }] },
  });
  const uniforms = device.createBuffer({ size: 32, usage: GPUBufferUsage.UNIFORM | GPUBufferUsage.COPY_DST });
  return (radiance, sizePx) => {
    const bytes = new ArrayBuffer(32);
    new Uint32Array(bytes).set([...sizePx, canvas.width, canvas.height]);
    new Float32Array(bytes).set(background, 4);
    device.queue.writeBuffer(uniforms, 0, bytes);
    const entries = [uniforms, radiance].map((buffer, binding) => ({ binding, resource: { buffer } }));
    const group = device.createBindGroup({ layout: pipeline.getBindGroupLayout(0), entries });
    const encoder = device.createCommandEncoder();
    const view = context.getCurrentTexture().createView();
    const pass = encoder.beginRenderPass({ colorAttachments: [{ view, loadOp: "clear", storeOp: "store" }] });
    pass.setPipeline(pipeline);
    pass.setBindGroup(0, group);
    pass.draw(3);
    pass.end();
    device.queue.submit([encoder.finish()]);
  };
}
