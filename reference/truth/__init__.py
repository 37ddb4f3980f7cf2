"""Path-traced truth: accumulated, resumed, and shared among processes."""
