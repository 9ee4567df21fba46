"""Rates of missed and false findings of the checks of recordings: ./run study plausibility."""
