"""The subcommands that need no hardware, one a module."""
