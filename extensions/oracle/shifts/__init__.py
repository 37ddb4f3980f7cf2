"""Shifts of whole paths: passes, judges, and known mistakes."""
