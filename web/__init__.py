"""The page that shows what is painted, and the server behind it."""
