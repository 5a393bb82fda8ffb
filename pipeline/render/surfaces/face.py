"""The face as one surface."""


class FaceRegion:
    """The whole face."""

    def lit(self, item, scene):
        return ()

    def amount(self, face):
        return 1.0

    def shade(self, light, mean):
        return 1.0


FACE = FaceRegion()
