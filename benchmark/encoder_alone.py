"""A bare loop that encodes COUNT copies of a video at once, and prints its peak memory in bytes.

python -m makeup_video.benchmark.encoder_alone VIDEO FOLDER COUNT
"""

import sys
from pathlib import Path

from makeup_video.benchmark.runs import transcode
from makeup_video.pipeline.engine.machine import peak_memory_bytes

if __name__ == "__main__":
    video, folder, count = sys.argv[1:]
    targets = [Path(folder) / f"alone{number}.mp4" for number in range(int(count))]
    transcode(Path(video), targets, (0, 0))
    print(peak_memory_bytes())
