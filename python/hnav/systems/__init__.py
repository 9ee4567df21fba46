"""Systems of FMUs in closed loop, the plants and sensors in them, and what a finished simulation holds."""
