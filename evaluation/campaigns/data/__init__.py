"""Folder of a campaign: its trials, and the ends of their actions."""
