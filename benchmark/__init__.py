"""Measures what the product costs, compared with the bare codec."""
