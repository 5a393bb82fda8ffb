"""One run over a file."""
