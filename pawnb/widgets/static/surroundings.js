// How much room there is for plots, whether the page is dark, and whether Python hears; the keys
// that are pressed in the plots are left to them.
// Joined behind connection.js by surroundings.py.

const NEXT = "pawnb-next"; // the class of where what is opened or done begins: the first that is shown
const HEADS_PX = 100; // menus and tools of a notebook

// The first colour behind an element that covers what is behind it.
function isDark(el) {
  for (let at = el; at; at = at.parentElement) {
    const [r, g, b, a = 1] = (getComputedStyle(at).backgroundColor.match(/[\d.]+/g) || []).map(Number);
    if (r !== undefined && a > 0.5) return 0.2126 * r + 0.7152 * g + 0.0722 * b < 128;
  }
  return false;
}

export default {
  render({ model, el }) {
    const lost = document.createElement("div");
    lost.className = "pawnb-lost";
    lost.setAttribute("role", "alert");
    lost.hidden = true;
    el.append(lost);
    el.classList.add("pawnb-surroundings");
    const connection = new Connection(model, Math.random().toString(36).slice(2), () => {
      lost.hidden = !connection.down;
      lost.textContent = connection.words();
    });
    let timer;
    const look = () => {
      clearTimeout(timer);
      timer = setTimeout(() => {
        const width = Math.floor(el.getBoundingClientRect().width);
        if (!width || connection.down) return; // in a hidden tab, or nobody hears
        model.set({ width, height: window.innerHeight, dark: isDark(el) });
        model.save_changes();
      }, 150);
    };
    // keys in the plots are the plots' own: the notebook asks only the element that has the focus
    const keep = ({ target }) => {
      if (!target.matches(".jupyter-matplotlib-canvas-div")) return;
      if (el.parentElement && el.parentElement.contains(target)) target.dataset.lmSuppressShortcuts = "true";
    };
    document.addEventListener("focusin", keep);
    // what was opened begins above what is in sight, where the one before it was looked at below
    const show = () => {
      const all = el.parentElement ? [...el.parentElement.querySelectorAll(`.${NEXT}`)] : [];
      const next = all.find((one) => one.offsetParent);
      if (next && next.getBoundingClientRect().top < HEADS_PX) next.scrollIntoView({ block: "start" });
    };
    // what is to be shown comes by messages of its own, which may take a moment longer than this one
    let showing;
    const bring = ({ type }) => {
      if (type !== "bring") return;
      clearTimeout(showing);
      showing = setTimeout(show, 100);
    };
    model.on("msg:custom", bring);
    const room = new ResizeObserver(look);
    room.observe(el);
    const theme = new MutationObserver(look);
    theme.observe(document.body, { attributes: true });
    window.addEventListener("resize", look);
    return () => {
      clearTimeout(timer);
      clearTimeout(showing);
      room.disconnect();
      theme.disconnect();
      window.removeEventListener("resize", look);
      document.removeEventListener("focusin", keep);
      model.off("msg:custom", bring);
      connection.close();
    };
  },
};
