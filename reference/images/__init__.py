"""Images in and out: layers, EXR, display, and how far two are apart."""
