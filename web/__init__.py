"""The page that shows the painted picture, and its server."""
