"""Completion of commands and options in a shell, made from the parser itself."""

from __future__ import annotations

import argparse
from collections.abc import Mapping

SHELLS = ("bash", "zsh", "fish")


def completion_script(shell: str, commands: Mapping[str, argparse.ArgumentParser]) -> str:
    """Write a script that completes commands, options and fixed values; else files.

    Parameters
    ----------
    shell : {"bash", "zsh", "fish"}
        The shell; zsh reads bash's through ``bashcompinit``.
    commands : mapping
        Name to parser.

    Returns
    -------
    str
        The script.
    """
    words = {name: _words(command) for name, command in commands.items()}
    if shell == "fish":
        lines = ["complete -c pawnb -e"]
        known = " ".join(words)
        lines.append(f"complete -c pawnb -n __fish_use_subcommand -f -a '{known}'")
        lines += [
            f"complete -c pawnb -n '__fish_seen_subcommand_from {name}' -a '{' '.join(own)}'"
            for name, own in words.items()
        ]
        return "\n".join(lines) + "\n"
    cases = "\n".join(f'    {name}) words="{" ".join(own)}";;' for name, own in words.items())
    script = f"""_pawnb() {{
  local words word command="" here="${{COMP_WORDS[COMP_CWORD]}}"
  for word in "${{COMP_WORDS[@]:1:COMP_CWORD-1}}"; do
    case "$word" in -*) ;; *) command="$word"; break;; esac
  done
  if [ -z "$command" ]; then
    COMPREPLY=($(compgen -W "{" ".join(words)}" -- "$here")); return
  fi
  case "$command" in
{cases}
  esac
  COMPREPLY=($(compgen -W "$words" -- "$here"))
}}
complete -o default -F _pawnb pawnb
"""
    begin = "autoload -U +X bashcompinit && bashcompinit\n" if shell == "zsh" else ""
    return begin + script


def _words(command: argparse.ArgumentParser) -> list[str]:
    """Return the options of a command, and the values that are fixed."""
    words: list[str] = []
    for action in command._actions:
        words += [option for option in action.option_strings if option.startswith("--")]
        if not action.option_strings and action.choices:
            words += map(str, action.choices)
    return words
