"""Objects in pictures, and the views from which they are seen."""
