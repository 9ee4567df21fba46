"""What measures hnav and is no part of it: studies are run from a checkout by ./run study NAME and are not in the wheel."""
