"""Light and painting."""
