"""Every key that there is, pressed in every widget with pictures, alone, with Shift and with Ctrl.

Nothing breaks, nothing reaches the notebook, and what the help promises is done by some key.
"""

import string

import pytest
from test_cut_connection_browser import KINDS, widget  # noqa: F401, a fixture

pytestmark = pytest.mark.browser

KEYS = [
    *string.ascii_lowercase, *string.digits, "ArrowLeft", "ArrowRight", "ArrowUp", "ArrowDown",
    "Home", "End", "Space", "+", "-", "?", "[", "]", "Enter", "Delete", "Backspace", "Escape",
]  # fmt: skip
OF_THE_BROWSER = set("acfhjknoprtuvwxl") | set(string.digits) | {"+", "-"}
"""With Ctrl they print, search, zoom or close the window: no widget asks for them."""


@pytest.mark.parametrize("widget", KINDS, indirect=True)
def test_no_key_breaks_a_widget_or_reaches_the_notebook(widget):  # noqa: F811
    notebook = widget.notebook
    cells, errors = notebook.n_cells(), list(notebook.errors)
    asked = [
        key for action in notebook.js("c.model.get('actions')") for key in action.get("keys", [])
    ]
    pressed = set()
    for before in ("", "Shift+", "Control+", "Control+Shift+"):
        for key in KEYS:
            if before == "Control+" and key in OF_THE_BROWSER:
                continue
            if before == "Control+Shift+" and key != "z":
                continue
            notebook.focus()
            typed = key.upper() if before.endswith("Shift+") and len(key) == 1 else key
            notebook.press(before + typed)
            pressed.add((before.replace("Control", "Ctrl") + typed).replace("Space", " "))
            notebook.press("Escape")
    notebook.js("f.play(false)")
    notebook.until(
        "bool(getattr(getattr(w, 'corrected', None), 'busy', False))", False, seconds=120
    )
    notebook.wait("c.pending === 0", seconds=60)
    notebook.settle()
    assert set(asked) <= pressed, set(asked) - pressed
    assert notebook.n_cells() == cells
    assert notebook.errors == errors
    assert not notebook.js("c.connection.down")
    # what a key asked for in vain is said in words, and nothing else is
    assert "Error" not in notebook.page.locator(".pawnb-alarm").inner_text()
    # it still works
    notebook.focus()
    notebook.press("Home")
    notebook.wait("c.painted === f.span[0]")
