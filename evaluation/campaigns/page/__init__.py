"""Page of a campaign."""
