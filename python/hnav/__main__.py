from hnav.cli import main

main()
