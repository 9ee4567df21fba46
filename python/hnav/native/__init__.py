"""The C library with the functions of its headers; hnav.filters and hnav.simulation are the interface for users."""
