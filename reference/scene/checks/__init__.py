"""What makes a scene fit to be rendered, a subject a file."""
