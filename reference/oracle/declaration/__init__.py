"""What a backend says of itself: what it has, and which choices it makes."""
