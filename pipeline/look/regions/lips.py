"""The lips, as people choose lipstick for them."""

from makeup_video.pipeline.look.regions.info import RegionInfo

# Rows in the order of SETTINGS.
_FINISHES = {
    "matte":    (0.96, 0.00, 0.80, 0.00, 0.30, 0.45, 0.00, 0.20, 0.30, 0.80, 0.00, 0.50, 0.50, 1.0),
    "satin":    (0.92, 0.40, 0.45, 0.05, 0.35, 0.50, 0.05, 0.50, 0.50, 0.60, 0.00, 0.50, 0.50, 1.0),
    "sheer":    (0.40, 0.30, 0.50, 0.05, 0.60, 0.75, 0.08, 0.60, 0.50, 0.50, 0.00, 0.50, 0.50, 1.0),
    "gloss":    (0.94, 1.30, 0.20, 0.25, 0.40, 0.60, 0.08, 0.55, 0.70, 0.20, 0.00, 0.50, 0.50, 1.0),
    "metallic": (0.95, 1.25, 0.40, 0.30, 0.40, 0.45, 0.00, 0.40, 0.60, 0.40, 0.50, 0.10, 1.00, 1.0),
    "shimmer":  (0.75, 0.60, 0.40, 0.10, 0.50, 0.60, 0.08, 0.50, 0.50, 0.50, 0.60, 0.30, 0.40, 1.0),
}  # fmt: skip

INFO = RegionInfo(
    name="lips",
    title="Lips",
    product="Lipstick",
    part="mouth",
    category=r"(?<![a-z])lip",
    first_rgb=(180, 0, 46),
    is_required=True,
    finishes=_FINISHES,
)
