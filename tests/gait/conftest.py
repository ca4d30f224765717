"""With this file, tests in folders below find what this folder holds for them."""
