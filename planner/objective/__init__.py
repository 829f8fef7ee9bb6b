"""What motions cost: the scale of both costs, their integral along a motion, and the one object that charges them."""
