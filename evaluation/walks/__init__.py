"""Walks through an action network without a robot, thousands side by side: how each action ends is drawn."""
