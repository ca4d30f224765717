// The sheet of the questions: a small picture of each label that is asked about, the first one chosen.
// Joined with the other files here into one module by frame_canvas.py.

class Sheet {
  // `host` is the canvas: its model has the trait sheet, and it has edit and focus.
  constructor(host) {
    this.host = host;
    this.el = element("div", "pawnb-sheet");
    this.el.setAttribute("role", "list");
    this.el.setAttribute("aria-label", "Labels that are asked about");
  }

  show() {
    const asked = this.host.model.get("sheet") || [];
    this.el.hidden = !asked.length;
    this.el.replaceChildren(...asked.map((one, k) => this.crop(one, k)));
  }

  crop({ frame, view, point, colour, url, at, reason, now }, k) {
    const made = element("button", "pawnb-crop", { type: "button" });
    made.title = `Is this ${point} in ${view}? Frame ${frame}: ${reason}`;
    made.setAttribute("aria-pressed", now);
    made.style.setProperty("--colour", colour);
    const picture = element("span", "pawnb-cut");
    picture.append(element("img", "", { src: url, alt: "" }));
    const ring = element("span", "pawnb-ring");
    ring.style.left = `${100 * at[0]}%`;
    ring.style.top = `${100 * at[1]}%`;
    picture.append(ring);
    const asks = element("span", "pawnb-asks", { textContent: `${point || "(no name)"}?` });
    const where = element("span", "pawnb-where", { textContent: `${view}, ${frame}` });
    made.append(picture, asks, where);
    made.onclick = () => {
      this.host.edit({ what: "action", action: "ask about", value: String(k) });
      this.host.focus();
    };
    return made;
  }
}
