"""What the product costs, measured beside the bare codec."""
