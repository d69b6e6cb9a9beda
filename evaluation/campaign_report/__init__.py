"""What a campaign proves."""
