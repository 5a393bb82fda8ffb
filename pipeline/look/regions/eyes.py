"""The eyes, as people choose eye-shadow for them: zones of the lids, and how much of it."""

from makeup_video.pipeline.look.regions.info import Dial, RegionInfo

ZONES = ("lid", "crease", "full", "outer")

# Rows in the order of SETTINGS.
_FINISHES = {
    "matte":    (0.92, 0.00, 0.95, 0.00, 0.60, 0.75, 0.05, 0.20, 0.20, 0.90, 0.00, 0.50, 0.50, 1.0),
    "satin":    (0.85, 0.20, 0.80, 0.00, 0.60, 0.80, 0.05, 0.40, 0.40, 0.80, 0.00, 0.50, 0.50, 1.0),
    "sheer":    (0.28, 0.10, 0.80, 0.00, 0.80, 0.90, 0.08, 0.40, 0.30, 0.80, 0.00, 0.50, 0.50, 1.0),
    "gloss":    (0.60, 0.90, 0.40, 0.10, 0.60, 0.80, 0.08, 0.40, 0.60, 0.50, 0.00, 0.50, 0.50, 1.0),
    "metallic": (0.90, 0.70, 0.60, 0.15, 0.60, 0.70, 0.05, 0.20, 0.60, 0.60, 0.60, 0.10, 1.00, 1.0),
    "shimmer":  (0.85, 0.40, 0.65, 0.05, 0.70, 0.75, 0.08, 0.30, 0.50, 0.60, 0.70, 0.30, 0.40, 1.0),
}  # fmt: skip

INFO = RegionInfo(
    name="eyes",
    title="Eyes",
    product="Eye-shadow",
    part="eyes",
    category=r"(?<![a-z])eye(?![ _-]?(brow|lash))",
    first_rgb=(90, 58, 46),
    is_required=True,
    remark="a powder, so softer borders and broader highlights",
    dials=(
        Dial("zone", "lid", "Zone", "Where the eye-shadow is painted.", choices=ZONES),
        Dial("intensity", 1.0, "Intensity", "How strong the eye-shadow is.", scales=True),
    ),
    finishes=_FINISHES,
)
