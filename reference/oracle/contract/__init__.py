"""What a backend is asked for: passes, their buffers and their settings."""
