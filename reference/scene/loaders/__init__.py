"""Scenes from files: glTF, OBJ, PLY, Mitsuba XML, and our own scene.json."""
