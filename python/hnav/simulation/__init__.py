"""What drives filters: plants and sensors of the C library."""
