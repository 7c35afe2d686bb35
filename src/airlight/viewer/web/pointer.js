// What pointer and wheel do, by the table of bindings that the session gives.

/** Send gestures of the pointer over an element; returns what ends it. */
export function attachPointer(view, element) {
  let last = null;
  const kindOf = (pointer, event) => {
    const fits = (binding) => binding.pointer === pointer && (!binding.modifier || event.getModifierState(binding.modifier));
    const found = (view.schema?.bindings ?? []).filter(fits).sort((a, b) => !!b.modifier - !!a.modifier);
    return found[0]?.kind;
  };
  const down = (event) => {
    last = { x: event.clientX, y: event.clientY, kind: kindOf(["left", "middle", "right"][event.button], event) };
    element.setPointerCapture(event.pointerId);
  };
  const move = (event) => {
    view.tell("pointer", event);
    if (!last?.kind) return;
    const height = element.clientHeight;
    view.gesture({ kind: last.kind, dx: (event.clientX - last.x) / height, dy: (event.clientY - last.y) / height });
    Object.assign(last, { x: event.clientX, y: event.clientY });
  };
  const up = () => (last = null);
  const wheel = (event) => {
    event.preventDefault();
    view.gesture({ kind: kindOf("wheel", event), dx: 0, dy: Math.sign(event.deltaY) * 0.05 });
  };
  const menu = (event) => event.preventDefault();
  const attached = Object.entries({ pointerdown: down, pointermove: move, pointerup: up, pointercancel: up, wheel, contextmenu: menu });
  attached.forEach(([name, listener]) => element.addEventListener(name, listener, { passive: false }));
  return () => attached.forEach(([name, listener]) => element.removeEventListener(name, listener));
}
