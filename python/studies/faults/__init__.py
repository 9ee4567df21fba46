"""What a fault of sensors or time stamps costs: simulated events with exact truth, and recordings damaged on purpose."""
