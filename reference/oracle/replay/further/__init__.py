"""Replay of the passes that stand around the resampling of a frame."""
