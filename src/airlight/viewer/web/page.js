// The page: the front-end over a WebSocket.
import { default as app } from "./app.js";
import { socketModel } from "./model.js";

app.render({ model: socketModel(new URL("socket", location.href)), el: document.getElementById("airlight") });
