"""av.VideoFrame -> Frame for a live run: one layout, one size, complete tags, time of arrival."""

from fractions import Fraction

import av
from av.video.frame import PictureType
from av.video.reformatter import ColorRange
from makeup_video.pipeline.errors import DecodeError
from makeup_video.pipeline.frames.colour_tags import FULL_RANGE, ColourTags
from makeup_video.pipeline.frames.display_matrix import turn_of
from makeup_video.pipeline.frames.frame import Frame
from makeup_video.pipeline.frames.transform import fitted, squared
from makeup_video.pipeline.live.interfaces import LIVE_TIME_BASE
from makeup_video.pipeline.media.codecs import PLAYS_EVERYWHERE
from makeup_video.pipeline.media.pixel_format import ConvertPixelFormat

# One layout for every sink: browsers, players, receivers and programs that read cameras take 4:2:0,
# and converting once here costs less than once per sink. Matrix and range stay unchanged.
_LIVE = PLAYS_EVERYWHERE._replace(name="live", pix_fmts=("yuv420p",))
# The defaults of the USB Video Class; a camera's JPEGs keep their own range.
_USB_VIDEO = ColourTags(matrix=6, range=1, transfer=1, primaries=1)
# DV, HDV and anamorphic video have pixel aspects of 8:15 to 2; beyond these limits they are errors
_ASPECTS = Fraction(1, 4), Fraction(4)
# MP4 and MPEG-TS count in 1/90000 s and do not take two pictures with the same time. Times of
# arrival may even go back: a picture that was read late may get a later time than the next one,
# which was waiting meanwhile.
_LEAST_STEP_US = 100


class NormaliseCamera:
    """Turns the pictures of a camera or a file into live frames.

    is_device: the pictures are a camera's. Their unspecified colour tags become the defaults of the
    USB Video Class: BT.601's matrix, BT.709's primaries and transfer, and limited range unless the
    picture is JPEG.
    pixel_aspect: the file's sample aspect ratio. Its pictures are stretched to square pixels, which
    pages, receivers and programs that read cameras expect.
    size_wh: the size of the first picture. Later pictures of another size are fitted into it, and
    their range is converted to the first picture's, since another camera may have been plugged in.
    """

    def __init__(self, *, is_device: bool, pixel_aspect: Fraction | None = None) -> None:
        self._is_device = is_device
        aspect = Fraction(pixel_aspect or 1)
        self._aspect = aspect if _ASPECTS[0] <= aspect <= _ASPECTS[1] else Fraction(1)
        self._convert = ConvertPixelFormat(_LIVE)
        self._source: tuple[int, int, str] | None = None  # size and layout of the last picture
        self._last_us = -_LEAST_STEP_US
        self.size_wh: tuple[int, int] | None = None
        self._range: int | None = None

    def __call__(self, picture: av.VideoFrame, arrived_seconds: float) -> Frame:
        """Normalise a picture. The times of the frames always increase.

        arrived_seconds: when the picture arrived, by time.monotonic().
        Raises DecodeError for a picture that cannot be converted.
        """
        source = (picture.width, picture.height, picture.format.name)
        if source != self._source:
            self._convert, self._source = ConvertPixelFormat(_LIVE), source
        turned = turn_of(picture)
        picture = squared(self._converted(picture), self._aspect)
        if self._is_device:
            _USB_VIDEO.complete(picture)
        picture = self._like_the_first(picture)
        self._last_us = max(
            self._last_us + _LEAST_STEP_US, int(arrived_seconds * LIVE_TIME_BASE.denominator)
        )
        picture.pts, picture.time_base = self._last_us, LIVE_TIME_BASE
        # the encoder must not take over the picture type (I, P, B) of the source
        picture.pict_type = PictureType.NONE
        tags = ColourTags.of(picture)
        return Frame(picture, self._last_us, LIVE_TIME_BASE, tags, turned)

    def _converted(self, picture: av.VideoFrame) -> av.VideoFrame:
        try:
            return self._convert(picture)
        except av.FFmpegError as error:
            raise DecodeError(
                f"pictures of layout {picture.format.name}, matrix {int(picture.colorspace)} "
                "(ITU-T H.273) cannot be converted for painting: choose other pixels, or convert "
                "the video first"
            ) from error

    def _like_the_first(self, picture: av.VideoFrame) -> av.VideoFrame:
        size, span = (picture.width, picture.height), int(picture.color_range)
        if self.size_wh is None:
            self.size_wh, self._range = size, span
        if (self._range == FULL_RANGE) != (span == FULL_RANGE):
            wanted = ColorRange(self._range or ColorRange.MPEG)
            source = ColorRange.JPEG if span == FULL_RANGE else ColorRange.MPEG
            changed = picture.reformat(src_color_range=source, dst_color_range=wanted)
            changed.color_range = wanted
            picture = changed
        return picture if size == self.size_wh else fitted(picture, self.size_wh)
