"""What backends with physics share: all that isn't one engine's."""
