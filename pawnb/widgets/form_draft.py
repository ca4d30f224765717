"""What was typed into a form that is not sent yet: there again when the kernel has ended."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

from traitlets import TraitError

from pawnb.errors import InputError
from pawnb.files import write_whole


class FormDraft:
    """The fields of a form, kept in a file as they are filled in, until the form has done its work.

    Parameters
    ----------
    path : Path
        The file. Where it cannot be written nothing is kept, and nobody is stopped.
    fields : mapping of str to widget
        Widgets with a ``value``. What the file holds is put into them; what fits no more is left
        out.
    more : callable, optional
        Returns what else of the form is kept, as JSON can write it.
    """

    def __init__(
        self,
        path: Path,
        fields: Mapping[str, Any],
        *,
        more: Callable[[], Any] | None = None,
    ) -> None:
        self.path, self._fields, self._more = path, dict(fields), more
        self._as_made = self._now()
        kept = self._read()
        self.kept_more: Any = kept.get("more")
        typed = kept.get("fields")
        for name, value in (typed if isinstance(typed, dict) else {}).items():
            if name in self._fields:
                try:
                    self._fields[name].value = value
                except (TraitError, TypeError, ValueError):
                    continue
        for field in self._fields.values():
            self.watch(field)

    def watch(self, field: Any) -> None:
        """Keep the form whenever a field changes."""
        field.observe(lambda _: self.keep(), names="value")

    def keep(self) -> None:
        """Write the form as it is now; one that is as it was made leaves no file."""
        now = self._now()
        if now == self._as_made:
            self.forget()
            return
        try:
            write_whole(self.path, json.dumps(now, indent=1, ensure_ascii=False).encode())
        except (InputError, OSError):
            return

    def forget(self) -> None:
        """Take the file away: the form has done its work."""
        try:
            self.path.unlink(missing_ok=True)
        except OSError:
            return

    def _now(self) -> dict[str, Any]:
        more = {} if self._more is None else {"more": self._more()}
        return {"fields": {name: field.value for name, field in self._fields.items()}, **more}

    def _read(self) -> dict[str, Any]:
        """Return what the file holds; nothing where it is no such file."""
        try:
            kept = json.loads(self.path.read_text(encoding="utf-8"))
        except (OSError, ValueError, RecursionError):
            return {}
        return kept if isinstance(kept, dict) else {}
