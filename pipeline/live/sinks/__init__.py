"""Where the pictures of a live run go: page, file, stream, virtual camera."""
