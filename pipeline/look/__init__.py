"""What makeup is."""
