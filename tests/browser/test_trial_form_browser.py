"""The form of a new trial in a real browser: what is typed stays while its fields come and go."""

import pytest

pytestmark = pytest.mark.browser


def test_what_is_typed_stays_where_fields_come_and_go_beside_it(notebook, bare_videos):
    notebook.show(f"""from pawnb.widgets.trial_form import TrialForm
w = TrialForm({bare_videos!r}, done=print)
w""")
    rate = notebook.page.get_by_placeholder("frames a second")
    rate.click()
    notebook.page.keyboard.type("12")
    points = notebook.page.get_by_placeholder("names with commas between")
    assert points.is_hidden()
    notebook.kernel_runs("w.animal.value = 'other'")  # as if it had been chosen a moment before
    points.wait_for()
    notebook.page.keyboard.type("5.")
    views = notebook.page.get_by_role("button", name="Leave out")
    assert views.count() == 2
    notebook.kernel_runs("w._add(w.made.views[0])")
    views.nth(2).wait_for()
    notebook.page.keyboard.type("5")
    notebook.until("w.fps.value", "125.5")
    assert rate.input_value() == "125.5"
    # the frames to use are those that the pictures show
    notebook.js("f.go(7)")
    notebook.until("w._canvas.frame", 7)
    notebook.page.get_by_role("button", name="Begin here").click()
    notebook.until("[w.first.value, w.last.value]", ["7", ""])
    # one view is calibrated by a scale, several by a DLT
    scale = notebook.page.get_by_placeholder("px in one unit")
    assert scale.is_hidden()
    for _ in range(2):
        notebook.page.get_by_role("button", name="Leave out").first.click()
        notebook.page.wait_for_timeout(500)
    scale.wait_for()
    assert notebook.page.get_by_label("DLT", exact=True).is_hidden()
    notebook.assert_no_errors()
