"""The C library as it is, by its headers; hnav.filters and hnav.simulation are what one works with."""
