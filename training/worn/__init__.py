"""Training of the nets that read a photo's makeup: its kinds, and forms of liner and lipstick."""
