"""Sentences about wrong numbers: what they are in place of right."""
