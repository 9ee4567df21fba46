"""Whether the checks of recordings speak when they should, and are silent when they should be: ./run study plausibility."""
