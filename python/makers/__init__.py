"""What writes the systems of models/systems from their FMUs, options and scenarios: run in a checkout, and not in the wheel."""
