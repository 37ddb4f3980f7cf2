"""Tests of means and of laws whose false-alarm rates are proved, not approximated."""
