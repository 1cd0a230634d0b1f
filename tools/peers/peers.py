#!/usr/bin/env python3
"""Builds umbrage, installs its peers into an environment under target/peers, and compares them. See ../README.md."""
import os
import re
import subprocess
import sys
import venv
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
HERE = Path(__file__).resolve().parent
TOO_OLD = 15  # LLVM 15 ends Mitsuba 3.9 with an error, 19 does not.
ENVIRONMENT = ROOT / "target" / "peers"


def newest_llvm():
    """Version and path of the newest LLVM of the system: Mitsuba compiles while it runs."""
    listed = subprocess.run(["ldconfig", "-p"], capture_output=True, text=True).stdout if sys.platform == "linux" else ""
    found = re.findall(r"libLLVM(?:-(\d+)\.so|\.so\.(\d+))\S* .*=> (\S+)", listed)
    return max(((int(a or b), path) for a, b, path in found), default=(0, None))


def main():
    subprocess.run(["cargo", "build", "--release"], cwd=ROOT, check=True)
    python = ENVIRONMENT / "bin" / "python"
    wanted = HERE / "requirements.txt"
    installed = ENVIRONMENT / "requirements.txt"
    if not installed.exists() or installed.read_text() != wanted.read_text():
        venv.create(ENVIRONMENT, with_pip=True)
        subprocess.run([python, "-m", "pip", "install", "-q", "-r", wanted], check=True)
        installed.write_text(wanted.read_text())
    environment = dict(os.environ)
    version, path = newest_llvm()
    if "DRJIT_LIBLLVM_PATH" not in environment:
        if version <= TOO_OLD:
            sys.exit("error: Mitsuba needs a newer LLVM than 15: apt install libllvm19, or set DRJIT_LIBLLVM_PATH")
        environment["DRJIT_LIBLLVM_PATH"] = path
    os.execve(python, [python, HERE / "compare.py", *sys.argv[1:]], environment)


if __name__ == "__main__":
    main()
