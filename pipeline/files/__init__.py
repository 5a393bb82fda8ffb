"""Input and output files on disk."""
