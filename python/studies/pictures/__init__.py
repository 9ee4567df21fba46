"""Draws the pictures of README and docs from data.

./run study pictures                    all, into docs/images (with BROAD_DIR set; without it those that need no recordings)
./run study pictures overview aircraft  some of them
"""
