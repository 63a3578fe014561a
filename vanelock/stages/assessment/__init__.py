"""What a response is worth: bounds over undetermined static friction, and stability."""
