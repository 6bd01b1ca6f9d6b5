"""The protocols between rooms and to the outside, one small file each."""
