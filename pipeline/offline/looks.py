"""process_looks: paints several looks on one video or picture, which is read once."""

import os
import time
from collections.abc import Callable, Mapping, Sequence
from contextlib import ExitStack
from dataclasses import replace
from fractions import Fraction
from pathlib import Path

from makeup_video.pipeline.engine.machine import one_opencv_thread, peak_memory_bytes
from makeup_video.pipeline.errors import MakeupVideoError, UsageError
from makeup_video.pipeline.images.picture_file import is_picture
from makeup_video.pipeline.look.look import Look
from makeup_video.pipeline.media.input_file import local_file
from makeup_video.pipeline.offline.looks_on_film import LooksOnFilm, encoders_at_once
from makeup_video.pipeline.offline.looks_on_picture import paint_picture
from makeup_video.pipeline.offline.process import process_video
from makeup_video.pipeline.offline.report import Report
from makeup_video.pipeline.offline.run import check_picture_settings
from makeup_video.pipeline.offline.settings import Settings

Outcome = Report | MakeupVideoError
