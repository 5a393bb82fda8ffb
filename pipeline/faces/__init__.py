"""Detection and tracking of faces."""
