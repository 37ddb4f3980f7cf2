"""Rows of numbers: arrays, records, random streams, bands, moments."""
