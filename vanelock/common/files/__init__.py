"""Files written as a whole or not at all, and files of others read within bounds."""
