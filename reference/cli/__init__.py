"""The command line: `main`, the commands, one a module, and what they share."""
