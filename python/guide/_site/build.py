"""Builds the site: python python/guide/_site/build.py OUT [--quick]; script/docs sets up what it takes.

Pages are made from a copy in OUT/docs, so that what examples and Sphinx write stays out of python/guide; the site is
OUT/site, made anew each time. Without --quick the examples of the gallery run that have changed since the last time.
Warnings are errors.
"""

import shutil
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[3]


def copy_of_the_guide(folder):
    """python/guide in the folder, beside what its pages link to; pages of examples that are still there stay."""
    guide = folder / "python" / "guide"
    guide.mkdir(parents=True, exist_ok=True)
    for path in guide.iterdir():
        if path.name != "gallery":
            shutil.rmtree(path) if path.is_dir() else path.unlink()
    shutil.copytree(ROOT / "python" / "guide", guide, dirs_exist_ok=True, ignore=shutil.ignore_patterns("__pycache__"))
    for path in (guide / "gallery").glob("*.py"):
        if not (guide / "examples" / path.name).exists():
            for pattern in (f"{path.stem}.*", f"{path.stem}_codeobj*", f"sphx_glr_{path.stem}_*"):
                for made in (guide / "gallery").rglob(pattern):
                    made.unlink()
    for name in ("data", "tests"):
        (folder / name).unlink(missing_ok=True)
        (folder / name).symlink_to(ROOT / name)
    return guide


def main():
    quick = "--quick" in sys.argv[1:]
    (out,) = (Path(argument).resolve() for argument in sys.argv[1:] if argument != "--quick")
    guide = copy_of_the_guide(out / "docs")
    shutil.rmtree(out / "site", ignore_errors=True)  # Sphinx leaves pages that are no more
    options = ["-b", "html", "-a", "-q", "-W", "--keep-going", "-d", out / "docs" / "doctrees"]
    options += ["-D", "plot_gallery=0"] * quick
    done = subprocess.run([sys.executable, "-m", "sphinx", *options, guide, out / "site"], check=False)
    sys.exit(done.returncode)


if __name__ == "__main__":
    main()
