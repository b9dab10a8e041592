"""Copies of this project's scripts, run beside tools that only say that they were called."""

import shutil
import subprocess
from pathlib import Path

ROOT = Path(__file__).parents[2]
BASH = shutil.which("bash")


class CopiedScripts:
    """Scripts in `folder`, run as an ordinary user; dpkg knows all packages but `missing`, apt-get says its name."""

    def __init__(self, folder):
        self.folder, self.tools = folder, folder / "tools"
        self.tools.mkdir()
        self.tool("id", "echo 1000")
        self.tool("apt-get", "echo apt-get was called; exit 1")

    def tool(self, name, text):
        (self.tools / name).write_text(f"#!{BASH}\n{text}\n")
        (self.tools / name).chmod(0o755)

    def run(self, name, *arguments, missing=(), environment):
        (self.folder / "script").mkdir(exist_ok=True)
        copy = shutil.copy(ROOT / "script" / name, self.folder / "script")
        shutil.copy(ROOT / "script" / "roots", self.folder / "script")  # which some of them source
        absent = " ".join(missing)
        self.tool("dpkg-query", f'for p in "$@"; do [[ " {absent} " = *" $p "* ]] || echo "installed $p"; done')
        command = [BASH, str(copy), *arguments]
        return subprocess.run(command, env=environment, stdin=subprocess.DEVNULL, capture_output=True, text=True)
