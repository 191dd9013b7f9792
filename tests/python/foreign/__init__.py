"""Files as other programs write them, with the right answer for each. test_foreign_files.py reads them."""
