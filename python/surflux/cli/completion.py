"""Scripts by which shells complete commands and options of `surflux`, made of its parser."""

import argparse
from typing import NamedTuple

from surflux.scenes.options import TRANSPORTS

SHELLS = ("bash", "zsh", "fish")
# Of options that argparse leaves to others to check.
_WORDS = {
    "--backend": ("auto", "cpu", "gl"),
    "--direct": ("interpolated", "traced"),
    "--light": ("all", "direct", "indirect"),
    "--method": ("curved", "paper"),
    "--style": ("disks", "splats", "points"),
    "--transport": TRANSPORTS,
}


class _Option(NamedTuple):
    names: tuple[str, ...]  # none of an argument by its place
    help: str
    takes_value: bool
    choices: tuple[str, ...]


def script(shell, parser):
    """The completion script of a shell for an argparse parser of commands.

    Args:
        shell: one of SHELLS.
        parser: with subparsers, such as command_line makes.
    """
    action = next(a for a in parser._actions if isinstance(a, argparse._SubParsersAction))
    helps = {choice.dest: choice.help or "" for choice in action._choices_actions}
    commands = {name: (helps[name], _options_of(sub)) for name, sub in action.choices.items()}
    return {"bash": _bash, "zsh": _zsh, "fish": _fish}[shell](parser.prog, commands)


def _options_of(parser):
    found = []
    for action in parser._actions:
        known = next((_WORDS[flag] for flag in action.option_strings if flag in _WORDS), ())
        choices = tuple(map(str, action.choices or known))
        text = "" if action.help in (None, argparse.SUPPRESS) else action.help.replace("%%", "%")
        found.append(_Option(tuple(action.option_strings), text, action.nargs != 0, choices))
    return found


def _bash(prog, commands):
    lines = [
        f"_{prog}() {{",
        '    local cur="${COMP_WORDS[COMP_CWORD]}" prev="${COMP_WORDS[COMP_CWORD-1]}" command="" k',
        '    if [[ $cur == "=" ]]; then cur=""; elif [[ $prev == "=" ]]; then prev="${COMP_WORDS[COMP_CWORD-2]}"; fi',
        "    COMPREPLY=()",
        "    for ((k = 1; k < COMP_CWORD; ++k)); do",
        '        case "${COMP_WORDS[k]}" in',
        f'            {"|".join(commands)}) command="${{COMP_WORDS[k]}}"; break ;;',
        "        esac",
        "    done",
        '    case "$command $prev" in',
    ]
    places = {}
    for name, (_, options) in commands.items():
        for option in options:
            if option.names and option.takes_value:
                patterns = "|".join(f'"{name} {flag}"' for flag in option.names)
                words = f'COMPREPLY=($(compgen -W "{" ".join(option.choices)}" -- "$cur")); ' if option.choices else ""
                lines.append(f"        {patterns}) {words}return ;;")
            elif option.choices and not option.names:
                places[name] = option.choices
    flags = {"": [*commands, "--help", "--version"]}
    for name, (_, options) in commands.items():
        flags[name] = [flag for option in options for flag in option.names] + list(places.get(name, ()))
    lines += ["    esac", '    case "$command" in']
    for name, words in flags.items():
        always = "" if name == "" or name in places else "[[ $cur == -* ]] && "
        lines.append(f'        "{name}") {always}COMPREPLY=($(compgen -W "{" ".join(words)}" -- "$cur")) ;;')
    lines += ["    esac", "}", f"complete -o default -F _{prog} {prog}"]  # of nothing found: names of files
    return "\n".join(lines) + "\n"


def _zsh(prog, commands):
    lines = [f"#compdef {prog}", f"_{prog}() {{", "    local -a commands", "    commands=("]
    lines += [f"        {_single(f'{name}:{text}')}" for name, (text, _) in commands.items()]
    lines += [
        "    )",
        "    if (( CURRENT == 2 )); then",
        "        _describe command commands",
        "        return",
        "    fi",
        "    shift words",
        "    (( CURRENT-- ))",
        '    case "$words[1]" in',
    ]
    for name, (_, options) in commands.items():
        lines.append(f"        {name})")
        specs = [spec for option in options for spec in _zsh_specs(option)]
        lines.append("            _arguments \\")
        lines.append(" \\\n".join(f"                {_single(spec)}" for spec in specs) + " ;;")
    lines += ["    esac", "}"]
    # Read by the shell it defines the function; found in $fpath it is the function's body.
    lines += [f'if [ "$funcstack[1]" = "_{prog}" ]; then _{prog} "$@"; else compdef _{prog} {prog}; fi']
    return "\n".join(lines) + "\n"


def _zsh_specs(option):
    words = f"({' '.join(option.choices)})" if option.choices else "_files"
    if not option.names:
        return [f"*:file:{words}"]
    text = option.help
    for mark in "\\[]:":
        text = text.replace(mark, f"\\{mark}")
    others = f"({' '.join(option.names)})" if len(option.names) > 1 else ""
    return [f"{others}{flag}[{text}]{f':value:{words}' if option.takes_value else ''}" for flag in option.names]


def _fish(prog, commands):
    first = f"complete -c {prog} -n __fish_use_subcommand -f"
    lines = [f"{first} -a {name} -d {_fish_quoted(text)}" for name, (text, _) in commands.items()]
    for name, (_, options) in commands.items():
        for option in options:
            where = f"complete -c {prog} -n '__fish_seen_subcommand_from {name}'"
            words = f" -f -a {_fish_quoted(' '.join(option.choices))}" if option.choices else ""
            if not option.names:
                lines += [f"{where}{words}"] if words else []
                continue
            flags = "".join(f" {'-l' if f.startswith('--') else '-s'} {f.lstrip('-')}" for f in option.names)
            value = (" -r" if option.takes_value else "") + words
            lines.append(f"{where}{flags}{value} -d {_fish_quoted(option.help)}")
    return "\n".join(lines) + "\n"


def _single(text):
    """Text between single quotes, of a POSIX shell."""
    return "'" + text.replace("'", "'\\''") + "'"


def _fish_quoted(text):
    return "'" + text.replace("\\", "\\\\").replace("'", "\\'") + "'"
