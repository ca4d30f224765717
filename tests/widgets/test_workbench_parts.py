"""Parts of the workbench that need no trial."""

import matplotlib.pyplot as plt
from ipywidgets import Button

from pawnb.widgets.background_work import BackgroundWork
from pawnb.widgets.workbench_parts import show_results


def test_of_many_notes_the_first_stands_above_the_figure_and_the_others_below(tmp_path):
    figure = plt.figure(figsize=(1, 1))
    figure.savefig(tmp_path / "gait.png")
    plt.close(figure)
    shown = show_results([tmp_path / "gait.png"], ["verdict", "", "a", "b"])
    kinds = [type(part).__name__ for part in shown.children]
    assert kinds == ["Label", "Label", "Dropdown", "Image", "Label", "Label"]
    labels = [part.value for part in shown.children if type(part).__name__ == "Label"]
    assert labels == ["verdict", "2 more notes below the figure.", "a", "b"]
    alone = show_results([tmp_path / "gait.png"], ["verdict"])
    assert [type(part).__name__ for part in alone.children] == ["Label", "Dropdown", "Image"]
    assert [part.value for part in show_results([], ["verdict", "a"]).children] == ["verdict", "a"]


def test_a_fault_of_pawnb_itself_is_said_where_work_goes_on_in_another_thread(capsys):
    """Nobody looks into the log of JupyterLab: the bar went away, and nothing was said."""
    said = []
    work = BackgroundWork(Button(), around=lambda: None, failed=said.append)

    def broken():
        raise ZeroDivisionError("division by zero")

    work.begin("Track", broken)
    work.wait()
    (text,) = said
    assert text.startswith("Track: this is a fault of pawnb itself (ZeroDivisionError: division")
    assert "ZeroDivisionError" in capsys.readouterr().err
    work.close()
