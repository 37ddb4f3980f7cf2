"""The world outside: files, processes, signals, plug-ins, and errors."""
