"""Reads a look from a photo."""
