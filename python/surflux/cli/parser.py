"""How a line of words is taken apart, and what is said of one that is wrong."""

import argparse
import difflib
import re

_NEGATIVE = re.compile(r"-[\d.][^,\s]*,")  # begins a vector that is no option


def vectors_joined(arguments):
    """Arguments in which vectors that begin with a minus are joined to their option, as argparse wants them."""
    out = []
    for argument in arguments:
        if out and out[-1].startswith("--") and "=" not in out[-1] and _NEGATIVE.match(argument):
            out[-1] += f"={argument}"
        else:
            out.append(argument)
    return out


class Parser(argparse.ArgumentParser):
    """One that says what is wrong in a line, and which option may have been meant."""

    _commands = None

    def parse_args(self, args=None, namespace=None):
        options, left = self.parse_known_args(args, namespace)
        if left:
            parser = self._commands.choices.get(getattr(options, "command", None), self) if self._commands else self
            parser.error(f"unrecognized arguments: {' '.join(left)}{self._meant(left[0].split('=')[0], parser)}")
        return options

    def _meant(self, option, parser):
        """Where an option belongs: to other commands, behind this one, in scene files; or one that is spelled alike."""
        if option in parser._option_string_actions:
            return f"; {option} goes behind the command: {parser.prog} {option}"
        of_others = [
            name
            for name, other in (self._commands.choices if self._commands else {}).items()
            if option in other._option_string_actions
        ]
        if of_others:
            return f"; {option} is an option of {' and '.join(f'surflux {name}' for name in of_others)}"
        from surflux.scenes.scene_object import OBJECT_KEYS  # which other commands start without

        key = option.lstrip("-").replace("-", "_")
        if key in OBJECT_KEYS:
            return f"; {key} is a key of an [[object]] in a scene file"
        near = difflib.get_close_matches(option, parser._option_string_actions, 1)
        return f"; did you mean {near[0]}?" if near else ""

    def add_subparsers(self, **given):
        self._commands = super().add_subparsers(**given)
        return self._commands

    def _check_value(self, action, value):
        """Refuses a command, or a value of an option, that there is not; one that is spelled alike is named."""
        try:
            super()._check_value(action, value)
        except argparse.ArgumentError as error:
            near = difflib.get_close_matches(str(value), [str(choice) for choice in action.choices], 1)
            error.message += f"; did you mean {near[0]}?" if near else ""
            raise

    def error(self, message):
        if self._commands and message.endswith("COMMAND"):
            message += f", of {', '.join(self._commands.choices)}"
        self.exit(2, f"{self.prog}: error: {message} ({self.prog} --help says more)\n")
