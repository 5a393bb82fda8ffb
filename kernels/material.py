"""Host side of material.h: its constants and its struct. Its numpy twin is material_twin.py."""

import numpy as np
from makeup_video.kernels.definitions import Definitions

ENVIRONMENT_PX = 16  # side of an environment image
ROOM_BITS = 10  # of a channel of an environment in the kernel, where one word holds three channels
FAINTEST_STEP = 1e-30  # least step of an environment: the inverse of a smaller one may overflow
MIDDLE, LAST = (ENVIRONMENT_PX - 1) / 2, ENVIRONMENT_PX - 1.001  # texels that a ray may reach
FINEST = 1.25  # times the broad light: brighter light is a highlight, not texture
BRIGHTEST = 6.0  # most fine light that counts, times the broad light
BRIGHTEST_SHADE = 4.0  # most broad light that counts, times the mean of the region
OWN_HUE = 0.6  # share of the pixel's hue in the skin's highlights; with all of it they are orange
STEEPEST = 0.96  # most nx^2 + ny^2: a steeper normal would turn away from the viewer
LEAST_ROOM = 1e-4  # below the ceiling, so that nothing divides by zero
LOBE_TAIL = 0.3  # share of the highlight's peak: the fainter rest would veil the product
# How fine light breaks up the synthetic highlight: gain, offset and most of the factor.
BREAKUP_GAIN, BREAKUP_START, BREAKUP_MOST = 2.5, 1.5, 2.0
# Sparkles: what is added to coordinates so that cells count from 0; margin and spread of a
# sparkle's place within its cell; how far sparkles are tilted; how narrow their glint is.
CELLS_BEFORE_ZERO = 4096
SPARKLE_MARGIN, SPARKLE_SPREAD, SPARKLE_TILT, SPARKLE_NARROWNESS = 0.3, 0.4, 1.3, 2.5

# The struct of material.h: a product under the light of a scene. Light is linear; colours are in
# sRGB's primaries.
MATERIAL = np.dtype([
    ("product", np.float32, 3),  # its colour under the light
    ("glint", np.float32, 3),  # colour and strength of the synthetic highlight
    ("sparkle", np.float32, 3),  # the same of shimmer
    ("luminance", np.float32, 3),  # weights of red, green and blue
    ("opacity", np.float32),  # 0..1
    ("texture", np.float32),  # how much of the skin's fine light and dark survives, 0..1
    ("undertone", np.float32),  # how much of the skin's chroma survives, 0..1
    ("keep_highlights", np.float32),  # how much of the skin's highlights stays on the film, 0..1
    ("own_highlights", np.float32),  # gain of the highlights that the skin has
    ("lobe", np.float32),  # squared width of the synthetic highlight, 0..1
    ("half_way", np.float32, 3),  # unit vector between light and viewer, z towards the viewer
    ("reflection", np.float32),  # 0..1
    ("fresnel_front", np.float32),  # share of the reflection where the surface faces the viewer
    ("fresnel_rim", np.float32),  # what is added to fresnel_front where the surface turns away
    # (2, 2) by rows, from the x and y of a reflected ray to texels of the environment
    ("room", np.float32, 4),
    ("shimmer", np.float32),  # share of the cells that hold a sparkle
    ("cells", np.float32),  # number of cells per unit of the coordinates that stick to the skin
    ("spot", np.float32),  # squared radius of a sparkle, in cells
    ("dark", np.float32),  # light below which differences do not count
    # The weight is multiplied by dark_offset + dark_gain * fine light, clipped to 0..1. So dark
    # places are spared, except from a film that darkens them.
    ("dark_gain", np.float32),
    ("dark_offset", np.float32),
    ("to_film", np.float32, 9),  # (3, 3) by rows, from the frame's primaries to sRGB's
    ("from_film", np.float32, 9),  # and back
    ("ceiling", np.float32),  # the brightest light that is painted
])  # fmt: skip
DEFINITIONS = Definitions(
    {
        "MATERIAL_ENVIRONMENT_PX": ENVIRONMENT_PX,
        "MATERIAL_ROOM_BITS": ROOM_BITS,
        "MATERIAL_MIDDLE": MIDDLE,
        "MATERIAL_LAST": LAST,
        "MATERIAL_FINEST": FINEST,
        "MATERIAL_BRIGHTEST": BRIGHTEST,
        "MATERIAL_BRIGHTEST_SHADE": BRIGHTEST_SHADE,
        "MATERIAL_STEEPEST": STEEPEST,
        "MATERIAL_OWN_HUE": OWN_HUE,
        "MATERIAL_LEAST_ROOM": LEAST_ROOM,
        "MATERIAL_LOBE_TAIL": LOBE_TAIL,
        "MATERIAL_BREAKUP_GAIN": BREAKUP_GAIN,
        "MATERIAL_BREAKUP_START": BREAKUP_START,
        "MATERIAL_BREAKUP_MOST": BREAKUP_MOST,
        "MATERIAL_CELLS_BEFORE_ZERO": CELLS_BEFORE_ZERO,
        "MATERIAL_SPARKLE_MARGIN": SPARKLE_MARGIN,
        "MATERIAL_SPARKLE_SPREAD": SPARKLE_SPREAD,
        "MATERIAL_SPARKLE_TILT": SPARKLE_TILT,
        "MATERIAL_SPARKLE_NARROWNESS": SPARKLE_NARROWNESS,
    },
    {"material": MATERIAL},
)
