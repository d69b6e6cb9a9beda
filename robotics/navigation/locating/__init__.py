"""Global localization: the pose of a base on a map, found without a start pose."""
