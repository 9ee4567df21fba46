"""Plants and sensors of the C library that provide input for filters."""
