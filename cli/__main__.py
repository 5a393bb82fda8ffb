"""`python -m makeup_video.cli`, the same as the command `makeup-video`."""

from makeup_video.cli.main import main

if __name__ == "__main__":
    main()
