"""One run on a camera."""
