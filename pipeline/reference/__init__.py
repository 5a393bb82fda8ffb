"""One run over a photo: the look that it shows."""
