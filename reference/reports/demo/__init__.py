"""The demonstration: one scene by three methods, each held against the truth."""
