"""Training of the nets that find faces and their points."""
