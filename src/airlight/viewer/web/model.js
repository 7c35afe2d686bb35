// The model of anywidget, as much of it as the front-end uses, over a WebSocket: send, and on "msg:custom".
const AGAIN_MS = [250, 500, 1000, 2000, 4000];

/** One frame: count, lengths of all parts (uint32, little-endian), JSON, buffers. */
export function packed(message, buffers = []) {
  const parts = [new TextEncoder().encode(JSON.stringify(message)), ...buffers.map((buffer) => new Uint8Array(buffer))];
  const head = 4 * (1 + parts.length);
  const frame = new Uint8Array(parts.reduce((sum, part) => sum + part.length, head));
  const view = new DataView(frame.buffer);
  view.setUint32(0, parts.length, true);
  parts.forEach((part, n) => view.setUint32(4 * (n + 1), part.length, true));
  parts.reduce((at, part) => (frame.set(part, at), at + part.length), head);
  return frame;
}

/** The message and the buffers (DataViews, as those of notebooks) of a frame. */
export function unpacked(frame) {
  const view = new DataView(frame);
  const lengths = Array.from({ length: view.getUint32(0, true) }, (_, n) => view.getUint32(4 * (n + 1), true));
  let at = 4 * (1 + lengths.length);
  const parts = lengths.map((length) => new DataView(frame, (at += length) - length, length));
  return [JSON.parse(new TextDecoder().decode(parts[0])), parts.slice(1)];
}

/** A model over a WebSocket that comes back by itself; "msg:open" and "msg:closed" tell of it. */
export function socketModel(url) {
  const listeners = new Map();
  const tell = (name, ...what) => (listeners.get(name) ?? []).forEach((listener) => listener(...what));
  let socket;
  let failures = 0;

  function connect() {
    const session = sessionStorage.getItem("airlight-session");
    const target = new URL(url);
    target.protocol = target.protocol.replace("http", "ws");
    target.search = session ? new URLSearchParams({ session }) : "";
    socket = new WebSocket(target);
    socket.binaryType = "arraybuffer";
    socket.onopen = () => {
      failures = 0;
      tell("msg:open");
    };
    socket.onmessage = (event) => {
      const [message, buffers] = unpacked(event.data);
      if (message.type === "welcome") sessionStorage.setItem("airlight-session", message.session);
      tell("msg:custom", message, buffers);
    };
    socket.onclose = () => {
      tell("msg:closed");
      setTimeout(connect, AGAIN_MS[Math.min(failures++, AGAIN_MS.length - 1)]);
    };
  }

  connect();
  return {
    send: (message, _callbacks, buffers) => socket.readyState === WebSocket.OPEN && socket.send(packed(message, buffers)),
    on: (name, listener) => listeners.set(name, [...(listeners.get(name) ?? []), listener]),
    off: (name, listener) => listeners.set(name, (listeners.get(name) ?? []).filter((other) => other !== listener)),
  };
}
