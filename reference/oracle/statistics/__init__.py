"""Tests of means and distributions, with proved rates of false alarm."""
