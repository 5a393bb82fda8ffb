"""Writes sha256.json, against which the product checks its weights.

    python -m makeup_video.training.list_hashes pipeline/weights

Run this after copying weights into a folder. If a weight file has no hash or an old one, the
product ends with "install makeup-video again".
"""

import argparse
import hashlib
import json
from pathlib import Path

from makeup_video.training.inputs import existing


def list_hashes(folder: Path) -> None:
    """Write sha256.json for all weights of a folder, and print their total size."""
    files = sorted(folder.glob("*.onnx")) + sorted(folder.glob("*.npy"))
    hashes = {file.name: hashlib.sha256(file.read_bytes()).hexdigest() for file in files}
    (folder / "sha256.json").write_text(json.dumps(hashes, indent=2) + "\n")
    print(f"{sum(file.stat().st_size for file in files) / 1e6:.2f} MB in all")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("folder", type=existing)
    list_hashes(parser.parse_args().folder)


if __name__ == "__main__":
    main()
