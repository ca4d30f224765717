"""What was warned of is said on the page: nobody looks into the log of JupyterLab."""

import pytest
import small_trial as scene

import pawnb
from pawnb.schema import add_provenance
from pawnb.workflow.provenance.results import describe_trial, write_track_results

NOTE = "what moves in view cam2 moves 5 frames earlier than in view cam1."


@pytest.fixture
def tracked(tmp_path):
    """A trial that is tracked; the run warned that its films are not synchronised."""
    folder = scene.write_trial(tmp_path / "m1").parent
    tracks = describe_trial(scene.true_tracks(), pawnb.load_trial(folder))
    tracks = add_provenance(tracks, step="track", complete=True, notes=[NOTE], inputs={})
    write_track_results(tracks, folder / "results")
    return folder


def review_notes(bench, folder):
    bench.do("review", folder)
    bench.tool.tool._analysts.submit(int).result()  # its filters of warnings end with this test
    return [part.value for part in bench.tool.children if type(part).__name__ == "Label"]


def test_what_tracking_warned_of_stands_above_the_review(tracked, opened):
    assert review_notes(opened(tracked), tracked) == [f"\u26a0 {NOTE}"]


@pytest.mark.filterwarnings("ignore::pawnb.errors.InputWarning")
def test_what_was_changed_since_tracking_stands_above_the_review(tracked, opened):
    file = tracked / "trial.toml"
    file.write_text(file.read_text().replace('"cam2.avi"\n', '"cam2.avi"\noffset = 3\n'))
    first, _ = review_notes(opened(tracked), tracked)
    assert "offset of cam2 was changed from 0 to 3" in first


@pytest.mark.slow
def test_the_report_is_written_from_the_results(tracked, opened):
    bench = opened(tracked)
    bench.session._reviewed.add(tracked)
    bench.do("look", tracked)
    (report,) = [b for b in bench.tool.children[0].children if b.description == "Write the report"]
    report.click()
    bench.work.wait()
    page = (tracked / "report.html").read_text()
    assert "small" in page
    assert "report.html" in bench._told.value
