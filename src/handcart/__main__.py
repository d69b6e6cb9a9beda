"""`python -m handcart` is the command `handcart`."""

from handcart.tools.main import main

if __name__ == "__main__":
    main()
