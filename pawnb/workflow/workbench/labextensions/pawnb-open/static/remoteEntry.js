// Runs the one cell of a page that `pawnb open` has made, so that nobody has to.
//
// JupyterLab loads this as a federated extension: an object with init and get. Written by hand, since
// it needs no other module and so no build step. Only the page that the command has just written is run:
// another notebook with the same mark may be somebody else's, and waits for a person as any does.

(() => {
  const PAGE = "workbench.ipynb"; // in the folder that was opened
  const begun = new WeakSet();

  async function runPage(app) {
    const panel = app.shell.currentWidget;
    if (!panel || !panel.sessionContext || !panel.context || begun.has(panel)) return;
    if (panel.context.path !== PAGE) return;
    await panel.context.ready;
    const model = panel.content && panel.content.model;
    if (!model || !model.getMetadata || !model.getMetadata("pawnb_workbench") || begun.has(panel)) return;
    begun.add(panel);
    await panel.sessionContext.ready;
    await app.commands.execute("notebook:run-all-cells");
  }

  const plugin = {
    id: "pawnb-open:plugin",
    description: "Runs the cell of a workbench page.",
    autoStart: true,
    activate: (app) => {
      const run = () => runPage(app);
      app.restored.then(run);
      if (app.shell.currentChanged) app.shell.currentChanged.connect(run);
    },
  };

  (window._JUPYTERLAB = window._JUPYTERLAB || {})["pawnb-open"] = {
    init: () => {},
    get: async () => () => plugin,
  };
})();
