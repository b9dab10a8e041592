"""The command line: `surflux`, and `python -m surflux`."""

import sys


def main():
    """Runs one command and returns its exit status, 130 where Ctrl-C comes while libraries are loaded, too."""
    try:
        from surflux.cli import commands
    except KeyboardInterrupt:
        print("surflux: error: interrupted", file=sys.stderr)
        return 130
    return commands.main()


if __name__ == "__main__":
    sys.exit(main())
