"""The namespace of the project: `restir_gi.reference`, `restir_gi.extensions`, ..."""
