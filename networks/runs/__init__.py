"""One run on disk: its loop, its folder, and how it goes on after a crash."""
