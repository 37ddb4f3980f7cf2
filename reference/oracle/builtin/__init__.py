"""The project's own passes as a backend, in single or double precision."""
