// Others look along: a key that this view hands out, and the key of another.
import { h } from "../dom.js";
import { button, labelled } from "../controls.js";

export const panel = {
  title: "Share",
  order: 87,
  always: true, // those who follow may stop
  build(view) {
    const key = h("input", { type: "text", readonly: true, class: "key", onfocus: () => key.select() });
    const told = h("div", { hidden: true }, labelled("key", key, "Give it to whoever shall look along, in another page of this viewer"));
    const other = h("input", { type: "text", class: "key", "aria-label": "key of another view", placeholder: "key of another view", autocomplete: "off", spellcheck: "false" });
    const stop = button("Stop following", () => view.send({ type: "follow", key: "" }));
    const follow = button("Follow", () => other.value.trim() && view.send({ type: "follow", key: other.value.trim() }));
    const words = h("p", { class: "help", role: "status" });
    const show = () => {
      const { following, followers = 0 } = view.state() ?? {};
      follow.hidden = other.hidden = Boolean(following);
      stop.hidden = !following;
      words.textContent = following ? "This view shows what another shows." : followers ? `${followers} ${followers === 1 ? "view follows" : "views follow"} this one.` : "";
    };
    view.on("shared", (message) => {
      key.value = message.key;
      told.hidden = false;
    });
    view.on("state", show);
    show();
    return h("div", {},
      h("div", { class: "row" }, button("Let others follow", () => view.send({ type: "share" }))), told,
      h("div", { class: "row" }, other, follow, stop), words);
  },
};
