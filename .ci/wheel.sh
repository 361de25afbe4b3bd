#!/usr/bin/env bash
# Packs a program that is built into a Python wheel, with the package of src/python:  .ci/wheel.sh [PROGRAM [FOLDER]]
# (default: target/release/loopscope, target/wheels). `pip install FOLDER/loopscope-….whl` then gives `import loopscope`, and puts
# the program beside `python`. Needs Python 3.8 and nothing else. The same program gives the same bytes.
set -euo pipefail
cd "$(dirname "$0")/.."

program=${1:-target/release/loopscope}
said=$("$program" --version | tr -d '\r')
version=$(sed -n 's/^loopscope //p' <<<"$said")
target=${TARGET:-$(sed -n 's/^target: //p' <<<"$said")}
python=$(command -v python3 || command -v python)
"$python" - "$program" "${2:-target/wheels}" "$version" "$target" <<'END'
import base64, hashlib, pathlib, re, sys, zipfile

program, out, version, target = pathlib.Path(sys.argv[1]), pathlib.Path(sys.argv[2]), *sys.argv[3:]
content = program.read_bytes()
processor = target.split("-")[0]
if "-linux-" in target:
    # The oldest C library on which the program runs.
    newest = max(int(minor) for minor in re.findall(rb"GLIBC_2\.(\d+)", content))
    platform = f"manylinux_2_{newest}_{processor}"
elif "-windows-" in target:
    platform = {"x86_64": "win_amd64", "aarch64": "win_arm64"}[processor]
elif "-apple-" in target:
    platform = {"x86_64": "macosx_10_12_x86_64", "aarch64": "macosx_11_0_arm64", "universal": "macosx_11_0_universal2"}[processor]
else:
    sys.exit(f"wheel: no Python name is known for {target}")
suffix = ".exe" if "-windows-" in target else ""
info = f"loopscope-{version}.dist-info"
files = {f"loopscope/{path.name}": path.read_bytes() for path in pathlib.Path("src/python/loopscope").iterdir() if path.suffix in (".py", ".typed")}
files[f"loopscope-{version}.data/scripts/loopscope{suffix}"] = content
for licence in ("LICENSE-MIT", "LICENSE-APACHE"):
    files[f"{info}/licenses/{licence}"] = pathlib.Path(licence).read_bytes()
files[f"{info}/licenses/LICENCES-OF-CRATES.txt"] = pathlib.Path("assets/licences.txt").read_bytes()
files[f"{info}/METADATA"] = f"""Metadata-Version: 2.4
Name: loopscope
Version: {version}
Summary: Calibrate force/torque sensors, and compensate their hysteresis
License-Expression: MIT OR Apache-2.0
License-File: LICENSE-MIT
License-File: LICENSE-APACHE
License-File: LICENCES-OF-CRATES.txt
Classifier: Topic :: Scientific/Engineering
Requires-Python: >=3.8
Requires-Dist: numpy
Description-Content-Type: text/markdown

""".encode() + pathlib.Path("assets/guide/python.md").read_bytes()
files[f"{info}/WHEEL"] = f"Wheel-Version: 1.0\nGenerator: loopscope\nRoot-Is-Purelib: false\nTag: py3-none-{platform}\n".encode()
lines = [f"{name},sha256={base64.urlsafe_b64encode(hashlib.sha256(data).digest()).rstrip(b'=').decode()},{len(data)}" for name, data in files.items()]
files[f"{info}/RECORD"] = "\n".join([*lines, f"{info}/RECORD,,", ""]).encode()
out.mkdir(parents=True, exist_ok=True)
path = out / f"loopscope-{version}-py3-none-{platform}.whl"
with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as wheel:
    for name, data in sorted(files.items()):
        entry = zipfile.ZipInfo(name)
        entry.external_attr = (0o100755 if "/scripts/" in name else 0o100644) << 16
        entry.compress_type = zipfile.ZIP_DEFLATED
        wheel.writestr(entry, data)
print(path)
END
