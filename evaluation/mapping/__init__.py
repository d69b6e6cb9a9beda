"""Maps from recorded logs: readers of scans with odometry, and the files that a map is written as."""
