// The page: the front-end over a WebSocket.
import app from "./app.js";
import { h } from "./dom.js";
import { socketModel } from "./model.js";
import { styles } from "./styles.js";

const sheet = (name) => h("link", { rel: "stylesheet", href: new URL(name, import.meta.url).href });
document.head.append(...styles.slice(1).map(sheet));
app.render({ model: socketModel(new URL("socket", location.href)), el: document.getElementById("airlight") });
