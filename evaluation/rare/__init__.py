"""Ends of runs that are too rare to count: split where they come nearer, and weighed."""
