class SmoothAhead:
    def __call__(self, item):
        return item

    def drain(self):
        return []
