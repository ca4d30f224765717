// The canvas on a page without Python: what it would ask for lies in the page.
// Joined behind the other files here, as `canvas`, by page.py.

const ONLY_SHOWN = "This page shows the tracks; they are corrected in pawnb. Nothing was changed.";

// Stands for the model of a widget: it has its traits, and answers its messages.
class PageModel {
  constructor({ traits, frames, lanes }) {
    Object.assign(this, { traits, frames, lanes });
    this.handlers = new Map();
  }

  get(name) {
    return this.traits[name];
  }

  set(name, value) {
    const changed = typeof name === "string" ? { [name]: value } : name;
    for (const [one, to] of Object.entries(changed)) {
      this.traits[one] = to;
      this.tell(`change:${one}`);
    }
  }

  save_changes() {} // nobody else hears of them

  on(event, handler) {
    this.handlers.set(event, [...(this.handlers.get(event) || []), handler]);
  }

  off(event, handler) {
    this.handlers.set(event, (this.handlers.get(event) || []).filter((one) => one !== handler));
  }

  tell(event, ...what) {
    for (const handler of this.handlers.get(event) || []) handler(...what);
  }

  send(message) {
    const each = message.type === "want" ? message.frames : [message.frame];
    for (const frame of each) setTimeout(() => this.tell("msg:custom", this.answer({ ...message, frame }), []));
  }

  answer({ type, who, frame, n, what }) {
    if (type === "lanes") return { type, ...this.lanes };
    if (type === "hello") return { type, who };
    // a copy: what is dragged changes it
    const { overlay, pictures } = structuredClone(this.frames[frame - this.traits.span[0]]);
    const told = { who, frame, version: 0, overlay };
    const ones = this.traits.stages.map(() => 1); // no finer pixels can be had
    if (type === "want") return { type: "frame", ...told, sent: true, shrink: ones, pictures };
    if (["moved", "click", "hide", "stretch"].includes(what)) this.set("alarm", ONLY_SHOWN);
    return { type: "done", ...told, n };
  }
}

const data = JSON.parse(document.getElementById("pawnb-data").textContent);
canvas.render({ model: new PageModel(data), el: document.getElementById("pawnb") });
