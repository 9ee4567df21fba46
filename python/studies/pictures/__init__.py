"""The pictures of README and docs, made anew from data.

./run study pictures                    all, into docs/images (with BROAD_DIR set; without it those that need no recordings)
./run study pictures overview aircraft  some of them
"""
