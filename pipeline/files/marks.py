"""How files of pictures begin."""

PNG_MARK = b"\x89PNG\r\n\x1a\n"
JPEG_MARK = b"\xff\xd8"  # a segment follows, which begins with ff
