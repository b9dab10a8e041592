"""`surflux completion`: scripts that shells run, and the examples in the help of each command."""

import shlex
import shutil
import subprocess

import pytest

from surflux.cli import commands
from surflux.cli.examples import EXAMPLES
from surflux.cli.options import command_line


@pytest.fixture
def script(here, run):
    """The path of the script for a shell."""

    def written(shell):
        status, out, err = run("completion", shell)
        assert (status, err) == (0, "")
        path = here / f"surflux.{shell}"
        path.write_text(out)
        return path

    return written


@pytest.fixture
def completed(script):
    """What bash offers for a line, by its words; the last one is being typed."""
    path = script("bash")

    def offered(*words):
        lines = [
            f"source {path}",
            f"COMP_WORDS=({' '.join(map(shlex.quote, words))})",
            f"COMP_CWORD={len(words) - 1}",
            "_surflux",
            'printf "%s\\n" "${COMPREPLY[@]}"',
        ]
        done = subprocess.run(["bash", "--norc", "-c", "\n".join(lines)], capture_output=True, text=True, check=True)
        assert done.stderr == ""
        return done.stdout.split()

    return offered


def test_bash_completes_commands(completed):
    assert set(completed("surflux", "")) == {*commands.RUNS, "--help", "--version"}
    assert completed("surflux", "so") == ["solve", "solar"]
    assert completed("surflux", "doc") == ["doctor"]
    assert completed("surflux", "x") == []


@pytest.mark.parametrize("command", [name for name in commands.RUNS if name != "bench"])
def test_bash_completes_every_option_of_a_command(completed, command, run, capfd):
    with pytest.raises(SystemExit):
        run(command, "--help")
    usage = capfd.readouterr().out
    offered = completed("surflux", command, "--")
    assert {"--help", "--quiet", "--verbose"} <= set(offered)
    assert all(flag in usage for flag in offered)
    assert len(offered) == len(set(offered))


def test_bash_completes_options_of_the_bench(completed):
    assert completed("surflux", "bench", "--ref") == ["--reference"]
    assert set(completed("surflux", "bench", "--q")) == {"--quick", "--quiet"}


def test_bash_completes_values_by_their_names_and_leaves_others_to_files(completed):
    assert completed("surflux", "solve", "--solver", "") == ["radiosity", "meshless"]
    assert completed("surflux", "solve", "--solver", "=", "m") == ["meshless"]
    assert completed("surflux", "solve", "--solver", "=") == ["radiosity", "meshless"]
    assert completed("surflux", "solve", "a.ply", "--light", "s") == ["studio", "sun", "sky"]
    assert completed("surflux", "solve", "--transport", "p") == ["pairs"]
    assert completed("surflux", "solve", "a.laz", "b.laz", "--ti") == ["--tiles"]
    assert {"bash", "zsh", "fish"} <= set(completed("surflux", "completion", ""))
    # Nothing here: `complete -o default` offers names of files.
    assert completed("surflux", "solve", "-o", "") == []
    assert completed("surflux", "solve", "sc") == []
    assert completed("surflux", "solve", "a.ply", "--image", "--") == []


def test_an_interactive_bash_offers_files_too(script, here):
    (here / "my scan.ply").write_text("")
    words = f"source {script('bash')}; complete -p surflux"
    done = subprocess.run(["bash", "--norc", "-c", words], capture_output=True, text=True, check=True)
    assert done.stdout == "complete -o default -F _surflux surflux\n"


@pytest.mark.skipif(shutil.which("fish") is None, reason="needs fish")
def test_fish(script):
    def offered(line):
        words = f"source {script('fish')}; complete -C {shlex.quote(line)}"
        done = subprocess.run(["fish", "--no-config", "-c", words], capture_output=True, text=True, check=True)
        assert done.stderr == ""
        return [found.split("\t")[0] for found in done.stdout.splitlines()]

    assert offered("surflux so") == ["solar", "solve"]
    assert offered("surflux solve --sol") == ["--solution", "--solver"]
    assert offered("surflux solve --solver ") == ["meshless", "radiosity"]
    assert offered("surflux render --backg") == ["--background"]


@pytest.mark.skipif(shutil.which("zsh") is None, reason="needs zsh")
def test_zsh(script, here):
    """By its own _arguments, in a terminal of its own, as its authors test completion."""
    program = f"""
    zmodload zsh/zpty
    zpty shell zsh -f -i
    say() {{ zpty -w shell "$1" }}
    say 'PS1=; autoload -U compinit; compinit -u -d {here}/dump; source {script("zsh")}'
    say 'zstyle ":completion:*" list-prompt ""; zstyle ":completion:*" menu no; setopt no_list_ambiguous'
    say 'bindkey "^I" complete-word; print rea""dy'
    zpty -r shell got "*ready*"
    zpty -w -n shell $'surflux doc\\t'
    zpty -r -m shell got "*surflux doctor*" && print doctor
    zpty -w -n shell $'\\025surflux solve --trans\\t'
    zpty -r -m shell got "*--transport*" && print transport
    zpty -w -n shell $'\\025surflux solve --solver mesh\\t'
    zpty -r -m shell got "*--solver meshless*" && print meshless
    zpty -d shell
    """
    done = subprocess.run(["zsh", "-f", "-c", program], capture_output=True, text=True, timeout=60)
    assert done.stdout.split() == ["doctor", "transport", "meshless"], done


@pytest.mark.parametrize("command", commands.RUNS)
def test_the_examples_of_the_help_are_commands(run, capfd, command, monkeypatch):
    parser = command_line(commands.RUNS, 1000)
    assert len(EXAMPLES[command]) >= 2
    with pytest.raises(SystemExit):
        run(command, "--help")
    help_text = capfd.readouterr().out
    for arguments, what in EXAMPLES[command]:
        assert f"surflux {command} {arguments}".rstrip() in help_text
        assert what in help_text
        words = shlex.split(arguments.partition(" > ")[0])
        if command == "bench":
            from surflux.bench.command import add_options

            bench = next(a for a in parser._actions if a.dest == "command").choices["bench"]
            if "--quick" not in bench._option_string_actions:
                add_options(bench)
        options = parser.parse_args([command, *words])
        assert options.run is commands.RUNS[command]
        commands._check_options(options)
