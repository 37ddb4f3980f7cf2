"""A scene as files for other renderers, or the reasons why a form cannot say it."""
