"""Natural frequencies against rotor speed, and how engine orders meet them."""
