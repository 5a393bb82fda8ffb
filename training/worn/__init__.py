"""Training of the net that reads what is worn in a photo."""
