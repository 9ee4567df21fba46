from hnav.cli.app import main

main()
