"""Campaigns: killed at any instant, compared with themselves, timed."""
