"""What all of the program uses: errors, products, units, the ring."""
