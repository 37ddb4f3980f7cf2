"""What a scene is: shapes, materials, lights and a camera, as plain frozen records."""
