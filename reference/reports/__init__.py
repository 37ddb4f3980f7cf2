"""What all pages share: one environment of templates, one frame and one style."""
