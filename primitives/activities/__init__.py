"""Activities from outside whose goal a run is judged by."""
