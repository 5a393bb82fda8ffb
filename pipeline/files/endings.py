"""How the names of media files end, in lower case."""

PICTURES = (".jpg", ".jpeg", ".png", ".webp", ".heic", ".heif")
PHOTOS = (*PICTURES, ".avif", ".tif", ".tiff", ".bmp")  # a look can be read from these
VIDEOS = (
    ".mp4", ".m4v", ".mov", ".mkv", ".webm", ".avi", ".mpg", ".mpeg", ".ts", ".mts", ".m2ts",
    ".flv", ".asf", ".wmv", ".3gp", ".ogv", ".mxf", ".gif",
)  # fmt: skip
