"""The subcommands for real drives, one a module."""
