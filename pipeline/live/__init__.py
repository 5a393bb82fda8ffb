"""A live run: frames of a camera are painted as they come and handed to sinks."""
