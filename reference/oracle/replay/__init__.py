"""Replay: every pass once more, from the backend's own numbers, with error bounds."""
