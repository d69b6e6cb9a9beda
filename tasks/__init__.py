"""Task files and their worlds: data only."""
