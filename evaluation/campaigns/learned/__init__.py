"""Outcomes and durations of actions, learned from recorded campaigns: trials without a simulator."""
