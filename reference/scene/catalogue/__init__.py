"""Built-in scenes, as functions, with the answers that are known for them."""
