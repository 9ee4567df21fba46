"""Files in: recordings of sensors, and model files."""
