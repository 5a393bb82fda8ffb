"""Training of the net that tells what is worn in a photo."""
