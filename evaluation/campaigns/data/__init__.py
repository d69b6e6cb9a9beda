"""A campaign's folder: its trials, and how their actions ended."""
