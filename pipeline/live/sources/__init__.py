"""Where the frames and the sound of a live run come from: cameras, microphones, files."""
