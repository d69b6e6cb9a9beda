"""One run on disk: its loop, its folder, and its resume after a crash."""
