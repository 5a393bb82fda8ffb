"""Reads a look from a photo: photo -> face -> kinds that are worn -> layers of each kind -> Look.

A net that sees the whole face, and the face's colours, decide which kinds are worn
(read_makeup.py). Colours of makeup are measured on the photo and compared with bare faces
(fit_lips.py, fit_shadows.py, fit_blush.py). The shimmer of the lids is measured, too
(lid_shimmer.py). One net reads the roughness and the reflection of the lips from a crop whose light
is divided out, as in its training (crops.py). Two small nets read the form of eyeliner
(read_liner.py), and how lipstick shines and fades (read_lipstick.py).
"""

import os
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from makeup_video.pipeline.engine.machine import READ_PHOTO, check_memory, give_back_memory
from makeup_video.pipeline.errors import (
    PhotoError,
    SeveralFacesError,
    UsageError,
    option,
)
from makeup_video.pipeline.faces.face import Face, check_face_type
from makeup_video.pipeline.files.path_argument import GIVE_NAME, check_path
from makeup_video.pipeline.frames.views import RgbPicture, check_rgb8
from makeup_video.pipeline.images.photo_file import read_photo
from makeup_video.pipeline.look.finishes import FINISHES, nearest_finish, part_in_words
from makeup_video.pipeline.look.kinds import KINDS
from makeup_video.pipeline.look.look import Layer, Look
from makeup_video.pipeline.look.params import GraphicsParams
from makeup_video.pipeline.reference.checks import (
    check_face,
    choose_face,
    face_list,
    faces_within,
    is_inside,
)
from makeup_video.pipeline.reference.colours import Colours
from makeup_video.pipeline.reference.crops import CROPS, NUMBERS, read_input, read_numbers
from makeup_video.pipeline.reference.fit_blush import fit_blush
from makeup_video.pipeline.reference.fit_lips import fit_lips
from makeup_video.pipeline.reference.fit_shadows import fit_shadows
from makeup_video.pipeline.reference.flat_eyes import different_eyes
from makeup_video.pipeline.reference.lid_shimmer import lid_shimmer, lids_of
from makeup_video.pipeline.reference.liner import liner
from makeup_video.pipeline.reference.lower_line import lower_line
from makeup_video.pipeline.reference.nets import (
    LINER,
    LIPS,
    LIPSTICK,
    MAKEUP,
    forget_nets,
    loading,
    reference_net,
)
from makeup_video.pipeline.reference.neutral_face import neutral_face
from makeup_video.pipeline.reference.photo_light import photo_light
from makeup_video.pipeline.reference.read_liner import LinerForm, read_liner
from makeup_video.pipeline.reference.read_lipstick import read_lipstick
from makeup_video.pipeline.reference.read_makeup import (
    WORN_FROM,
    Makeup,
    read_makeup,
)
from makeup_video.pipeline.render.scene import SceneLight

# More shine is hardly ever worn. The net takes pale lips in bright photos for shiny ones, and they
# would be painted frosted.
MOST_GLOSS, MOST_REFLECTION = 3.0, 0.35
# Only from this probability of eyeshadow on do eyes that look different get different layers: on
# bare faces, coloured light and masks make as large a difference.
_SURE_OF_SHADOW = 0.95
_CERTAINTIES = ((0.95, "almost certain"), (0.75, "likely"), (0.0, "not sure"))


@dataclass(frozen=True, slots=True)
class Estimate:
    """The look of a face in a photo, and how sure it is.

    worn: for each kind by its name, the probability that it is worn, 0..1. Kinds below their
    threshold (WORN_FROM) have no layer in the look.
    """

    look: Look
    worn: Mapping[str, float]

    def certainty(self, kind: str) -> str:
        """In words, how sure it is that a kind is worn, or, if the look lacks it, not worn."""
        is_worn, probability = bool(self.look.of(kind)), self.worn[kind]
        sure = probability if is_worn else 1 - probability
        return next(word for least, word in _CERTAINTIES if sure >= least)

    def in_words(self) -> str:
        """One line such as "lips #B4002E, glossy, opaque (almost certain); eyes bare (likely)"."""
        return "; ".join(
            f"{KINDS[kind].part} {part_in_words(self.look, kind) or 'bare'} "
            f"({self.certainty(kind)})"
            for kind in self.worn
        )


def estimate_look(rgb8: np.ndarray, face: Face | None = None) -> Look:
    """The makeup worn in a photo: a look with layers of every kind that is worn.

    rgb8: (H, W, 3) uint8, upright, R'G'B' as sRGB encodes it, any size; it is not changed.
    face: the face that wears the makeup, as `find_faces` found it in this very picture; None: the
    only face.
    Colours are those of the product in neutral light, whatever the light of the photo. Eyes beyond
    the border of the picture count as bare.

    Raises PhotoError with the reason when no look can be read: no face, several faces and none
    chosen, a face that is too small, turned too far, too dark or grey, a mouth that is covered,
    overexposed lips. Raises ValueError for another shape or dtype, TypeError for a `face` that is
    no Face, InstallError when the nets are missing.
    """
    with _choice_by("give one of find_faces(rgb8) as `face`"):
        return estimate(rgb8, face).look


def estimate(rgb8: np.ndarray, face: Face | None = None) -> Estimate:
    """As `estimate_look`, with the probability of each kind of makeup."""
    check_rgb8(rgb8)
    if face is None:
        face = choose_face(faces_within(rgb8))
    check_face_type(face)
    check_face(rgb8, face)
    light = photo_light(rgb8, face)
    colours = Colours.of(neutral_face(rgb8, face, light))
    makeup = read_makeup(rgb8, face, light, colours)
    photo = _Photo(rgb8, face, light, colours, makeup)
    layers = [
        layer
        for kind, probability in makeup.worn.items()
        if probability >= WORN_FROM[kind]
        for layer in _READERS[kind](photo)
    ]
    return Estimate(Look(layers), makeup.worn)


def look_from_photo(
    photo: str | os.PathLike[str] | bytes,
    face: int | str | None = None,
) -> Look:
    """As `estimate_photo`, the look alone."""
    return estimate_photo(photo, face).look


def estimate_photo(
    photo: str | os.PathLike[str] | bytes,
    face: int | str | None = None,
) -> Estimate:
    """The makeup worn in a photo file, or in a file's content as bytes; see `read_photo`.

    face: None or "" for the only face, "largest", or the number of a face, 0 being the largest.
    Raises PhotoError and InputError, which name the file, UsageError for another `face`, TypeError
    for a photo of another type, and TooLittleMemoryError.
    """
    if not isinstance(photo, bytes):
        how = "estimate_look reads an array" if isinstance(photo, np.ndarray) else GIVE_NAME
        check_path("photo", photo, how)
    with _choice_by('give face="largest" or the number of a face'):
        return estimate_from(photo, face)


@contextmanager
def _choice_by(how: str) -> Iterator[None]:
    """Add to an error about several faces how Python chooses one of them."""
    try:
        yield
    except SeveralFacesError as error:
        error.extend(after=f", or {how}; there are {face_list(error.faces)}")
        raise


def estimate_from(
    photo: str | os.PathLike[str] | bytes,
    face: int | str | None = None,
    *,
    name: str = "the photo",
    read: Callable[[bytes, str], np.ndarray] | None = None,
) -> Estimate:
    """As `estimate_photo`, for commands and pages, which let people choose a face in other words.

    name: the name in messages for a photo that comes as bytes; a file has its own name.
    read: decodes a photo that comes as bytes, given the bytes and the name; None: `read_photo`.
    """
    chosen = "" if face is None else str(face)
    is_number = chosen.isascii() and chosen.isdigit() and len(chosen) < 10
    if chosen not in ("", "largest") and not is_number:
        raise UsageError(f"{option('face')} must be largest, or the number of a face, got {face!r}")
    check_memory(READ_PHOTO)
    try:
        with loading([MAKEUP, LIPS, LINER, LIPSTICK]):
            rgb8 = (
                read(photo, name) if read and isinstance(photo, bytes) else read_photo(photo, name)
            )
            return _estimate_of(rgb8, chosen, photo, name)
    finally:
        # painting does not need these nets, which take 50 MB
        forget_nets()
        give_back_memory()


def _estimate_of(
    rgb8: np.ndarray, chosen: str, photo: str | os.PathLike[str] | bytes, name: str
) -> Estimate:
    """As `estimate_from`, for a photo that is already decoded; errors name its file."""
    try:
        return estimate(rgb8, choose_face(faces_within(rgb8), chosen))
    except PhotoError as error:
        if isinstance(error, SeveralFacesError) and not isinstance(photo, bytes):
            error.photo = os.fspath(photo)
        error.extend(before=f"{name if isinstance(photo, bytes) else photo}: ")
        raise


def product_with(numbers: np.ndarray, region: str) -> GraphicsParams:
    """A product with these seven NUMBERS; its other settings are those of the nearest finish.

    The finish never shimmers: the numbers do not cover shimmer, and wrong sparkles look worse than
    missing ones.
    """
    # People read look files, so they hold no more digits than the net can resolve.
    rounded = np.round(np.asarray(numbers, np.float64), 3)
    g = dict(zip(NUMBERS, rounded.tolist(), strict=True))
    g["gloss"] = min(g["gloss"], MOST_GLOSS)
    g["reflection"] = min(g["reflection"], MOST_REFLECTION)
    shine = g["opacity"], g["gloss"], g["gloss_roughness"], g["reflection"]
    finish = nearest_finish(*shine, region, shimmers=False)
    return GraphicsParams(**{**FINISHES[finish][region], **g})


@dataclass(frozen=True, eq=False)
class _Photo:
    """A photo, one of its faces, and what was read from both so far."""

    rgb8: np.ndarray
    face: Face
    light: SceneLight
    colours: Colours
    makeup: Makeup

    @property
    def is_lined(self) -> bool:
        return self.makeup.worn["eyeliner"] >= WORN_FROM["eyeliner"]

    @cached_property
    def liner_form(self) -> LinerForm:
        return read_liner(self.rgb8, self.face, self.makeup.worn["eyeshadow"])


def _lipstick(photo: _Photo) -> list[Layer]:
    crop = read_input(RgbPicture(photo.rgb8), photo.face, LIPS, photo.light)
    if crop is None:
        return []
    net = reference_net(LIPS)
    lips = product_with(read_numbers(lambda rgb8: net(rgb8)["targets"], crop), LIPS)
    seen, form = photo.colours, read_lipstick(photo.rgb8, photo.face)
    probability = photo.makeup.worn["lipstick"]
    return [fit_lips(seen.neutral, seen.lips, lips, seen.flat_lips, form, probability)]


def _eyeshadow(photo: _Photo) -> list[Layer]:
    lids = lids_of(photo.rgb8, photo.face, photo.light)
    if lids is None:
        return []
    seen, probability = photo.colours, photo.makeup.worn["eyeshadow"]
    wing = photo.liner_form.wing if photo.is_lined else None
    winged = wing is not None and wing.is_sure
    shimmer = lid_shimmer(lids)

    def fitted(eyes: np.ndarray | None) -> list[Layer]:
        return fit_shadows(seen.neutral, eyes, probability, photo.is_lined, winged, shimmer)

    apart = different_eyes(seen.each_eye) if probability >= _SURE_OF_SHADOW else {}
    if not apart:
        return fitted(seen.eyes)
    return [
        replace(layer, shape={**layer.shape, "eye": eye})
        for eye, flat in apart.items()
        for layer in fitted(flat)
    ]


def _eyeliner(photo: _Photo) -> list[Layer]:
    if not is_inside(photo.rgb8, photo.face, CROPS["eyes"].needed):
        return []
    read = photo.makeup.layers["eyeliner", ""]
    lower = lower_line(photo.colours.eyes)
    return [liner(read, photo.liner_form, lower, photo.makeup.worn["eyeliner"])]


def _blush(photo: _Photo) -> list[Layer]:
    seen, shape = photo.colours, photo.makeup.layers["blush", ""].shape
    return fit_blush(seen.neutral, seen.cheeks, shape, photo.makeup.worn["blush"])


# For each kind, the function that reads its layers from a photo in which it is worn.
_READERS: Mapping[str, Callable[[_Photo], list[Layer]]] = {
    "lipstick": _lipstick,
    "eyeshadow": _eyeshadow,
    "eyeliner": _eyeliner,
    "blush": _blush,
}
