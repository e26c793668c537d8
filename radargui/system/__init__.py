"""What the program needs of the computer: its cores, and where its files of words are."""
