"""Training of the nets that read lipstick and eyeshadow from a photo."""
