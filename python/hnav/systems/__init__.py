"""Systems of FMUs in closed loop, the plants and sensors in them, and finished simulations."""
